"""Which of the mapped signals are believed now, and why the others are not."""

from collections.abc import Iterator, Mapping

from brake_monitor.estimation.core.core import Core
from brake_monitor.samples import ESSENTIAL, FLAGS, InputCondition, Measurand, Quantity


class InputTrust:
    """The condition of each input of one wagon, and which are contradicted from outside; the core is told of losses."""

    def __init__(self, core: Core, channels: Mapping[Measurand, int]) -> None:
        """Nothing has arrived yet; `channels`: the core's numbers of the mapped signals."""
        self._core, self._channels = core, channels
        self._conditions = dict.fromkeys(channels, InputCondition.AWAITED)
        self.disbelieved: frozenset[Measurand] = frozenset()  # contradicted from outside, whatever they say
        self._lost = frozenset(channels)
        self._heard: set[Measurand] = set()  # inputs that were good at any time
        self.known: frozenset[Measurand] = frozenset()  # inputs of which anything is known, see `_settle`
        self.changes = 0  # of any condition, so far

    def disbelieve(self, measurands: frozenset[Measurand]) -> None:
        """From now on these inputs are contradicted, and no others."""
        self.disbelieved = measurands
        self._settle()

    def note(self, measurand: Measurand, condition: InputCondition) -> bool:
        """The signal is in this condition; True when it was not before."""
        if self._conditions[measurand] is condition:
            return False
        self._conditions[measurand] = condition
        if condition is InputCondition.GOOD:
            self._heard.add(measurand)
        self.changes += 1
        self._settle()
        return True

    def _settle(self) -> None:
        """Work out which inputs are lost, and which are known: of a lost one the last value is, unless it is a flag."""
        bad = [one for one, condition in self._conditions.items() if condition is not InputCondition.GOOD]
        self._lost = self.disbelieved.union(bad)
        self.known = frozenset(one for one in self._heard if one not in self._lost or one[0] not in FLAGS)
        for measurand, number in self._channels.items():
            self._core.channels[number].lost = measurand in self._lost
        self._core.now.speed_lost = self.is_lost(Quantity.SPEED)
        for i, wheel in enumerate(self._core.wheels):
            wheel.axle_speed_lost = self.is_lost(Quantity.AXLE_SPEED, i)
            wheel.force_lost = self.is_lost(Quantity.PRESSING_FORCE, i)

    def condition(self, measurand: Measurand) -> InputCondition:
        """What the signal itself is like."""
        return self._conditions.get(measurand, InputCondition.GOOD)

    def is_lost(self, quantity: Quantity, wheelset: int = 0) -> bool:
        """Whether the signal says nothing that may be used."""
        return (quantity, wheelset) in self._lost

    def reasons(self) -> Iterator[str]:
        """For each essential input that is lost what it is and why, in words."""
        for quantity, wheelset in sorted(one for one in self._lost if one[0] in ESSENTIAL):
            own = self.condition((quantity, wheelset))
            yield f"{quantity} {wheelset + 1} {InputCondition.CONTRADICTED if own is InputCondition.GOOD else own}"
