"""Which of the mapped signals are believed now, and why the others are not."""

from collections.abc import Iterable, Iterator

from brake_monitor.samples import InputCondition, Quantity

Place = tuple[Quantity, int]  # wheelsets from 0


class InputTrust:
    """What is not good among the inputs of one wagon."""

    def __init__(self, channels: Iterable[Place]) -> None:
        """Nothing has arrived yet."""
        self._bad = dict.fromkeys(channels, InputCondition.AWAITED)
        self.disbelieved: frozenset[Place] = frozenset()  # good by themselves, but contradicted from outside

    def lose(self, place: Place, condition: InputCondition) -> bool:
        """From now on the signal is in this condition; True when it was not before."""
        is_new = self._bad.get(place) is not condition
        self._bad[place] = condition
        return is_new

    def gain(self, place: Place) -> None:
        """The signal is good again."""
        self._bad.pop(place, None)

    def condition(self, place: Place) -> InputCondition:
        """What the signal itself is like."""
        return self._bad.get(place, InputCondition.GOOD)

    def is_lost(self, quantity: Quantity, wheelset: int = 0) -> bool:
        """Whether the signal says nothing that may be used."""
        place = (quantity, wheelset)
        return place in self._bad or place in self.disbelieved

    def reasons(self, essential: Iterable[Quantity]) -> Iterator[str]:
        """What is lost of these quantities, in words."""
        wanted = set(essential)
        for place in sorted(place for place in self._bad.keys() | self.disbelieved if place[0] in wanted):
            yield f"{place[0]} {place[1] + 1} {self._bad.get(place, InputCondition.CONTRADICTED)}"
