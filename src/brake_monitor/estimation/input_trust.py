"""Which of the mapped signals are believed now, and why the others are not."""

from collections.abc import Iterable, Iterator, Mapping

from brake_monitor.estimation.core.core import Core
from brake_monitor.samples import FLAGS, InputCondition, Measurand, Quantity


class InputTrust:
    """The condition of each input of one wagon, and which are contradicted from outside; the core is told of losses."""

    def __init__(self, core: Core, channels: Mapping[Measurand, int]) -> None:
        """Nothing has arrived yet; `channels`: the core's numbers of the mapped signals."""
        self._core, self._channels = core, channels
        self._bad = dict.fromkeys(channels, InputCondition.AWAITED)
        self.disbelieved: frozenset[Measurand] = frozenset()  # contradicted from outside, whatever they say
        self._lost = frozenset(self._bad)
        self._heard: set[Measurand] = set()  # inputs that were good at any time
        self.known: frozenset[Measurand] = frozenset()  # inputs of which anything is known, see `_settle`
        self.changes = 0  # of any condition, so far

    def disbelieve(self, measurands: frozenset[Measurand]) -> None:
        """From now on these inputs are contradicted, and no others."""
        self.disbelieved = measurands
        self._settle()

    def lose(self, measurand: Measurand, condition: InputCondition) -> bool:
        """From now on the signal is in this condition; True when it was not before."""
        is_new = self._bad.get(measurand) is not condition
        if is_new:
            self.changes += 1
            self._bad[measurand] = condition
            self._settle()
        return is_new

    def gain(self, measurand: Measurand) -> None:
        """The signal is good, again or still."""
        if self._bad.pop(measurand, None) is not None:
            self.changes += 1
            self._heard.add(measurand)
            self._settle()

    def _settle(self) -> None:
        """Work out which inputs are lost, and which are known: of a lost one the last value is, unless it is a flag."""
        self._lost = self.disbelieved.union(self._bad)
        self.known = frozenset(one for one in self._heard if one not in self._lost or one[0] not in FLAGS)
        for measurand, number in self._channels.items():
            self._core.channels[number].lost = measurand in self._lost
        self._core.now.speed_lost = self.is_lost(Quantity.SPEED)
        for i, wheel in enumerate(self._core.wheels):
            wheel.axle_speed_lost = self.is_lost(Quantity.AXLE_SPEED, i)
            wheel.force_lost = self.is_lost(Quantity.PRESSING_FORCE, i)

    def condition(self, measurand: Measurand) -> InputCondition:
        """What the signal itself is like."""
        return self._bad.get(measurand, InputCondition.GOOD)

    def is_lost(self, quantity: Quantity, wheelset: int = 0) -> bool:
        """Whether the signal says nothing that may be used."""
        return (quantity, wheelset) in self._lost

    def reasons(self, essential: Iterable[Quantity]) -> Iterator[str]:
        """For each lost input of these quantities what it is and why, in words."""
        wanted = set(essential)
        for quantity, wheelset in sorted(one for one in self._lost if one[0] in wanted):
            condition = self._bad.get((quantity, wheelset), InputCondition.CONTRADICTED)
            yield f"{quantity} {wheelset + 1} {condition}"
