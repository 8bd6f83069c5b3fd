"""Who took part in the present brake application: what tells a brake that stays from one that never came."""

from collections import deque
from collections.abc import Sequence
from math import inf
from statistics import fmean

from brake_monitor.estimation.inputs.pad_contact import PadContact
from brake_monitor.monitoring.brake_units.running_application import LONGEST_GAP_S
from brake_monitor.monitoring.observation import OBSERVATION_PERIOD_S

EASED = 0.8  # of its force while the others released: a brake that follows a common release, if not all the way
RELEASE_S = 20.0  # by then any brake that is vented has eased so far
EASING = 0.95  # of what a brake pressed with EASING_S before: it is still being vented, in position G within 60 s
EASING_S = 2.0
LEAST_FRICTION = 0.4  # of nominal; brakes that retard less than pads like that do not press, whatever their sensors say


class Participation:
    """Sees the pressing forces, in order of time, while all are known. An application ends when all are released."""

    def __init__(self, contact_force_n: float, wheelset_count: int) -> None:
        self._contact_force_n = contact_force_n
        self._count = wheelset_count
        self._seen_s = -inf
        self._forget()

    def _forget(self) -> None:
        self.begin_was_seen = False  # all brakes were released before it: what is known of it is all of it
        self.begun_s = inf  # inf: none goes on
        self._contacts = [PadContact(self._contact_force_n) for _ in range(self._count)]
        self.eased = [False] * self._count  # which ones pressed less as the last one left its disc, no more since
        self._left_n: Sequence[float] = ()  # what each pressed with then
        self._lately: deque[Sequence[float]] = deque(maxlen=round(RELEASE_S / OBSERVATION_PERIOD_S))  # forces

    def see(self, time_s: float, forces_n: Sequence[float]) -> None:
        """Take the pressing forces of all wheelsets."""
        if time_s - self._seen_s > LONGEST_GAP_S:
            self._forget()
        self._seen_s = time_s
        self._lately.append(forces_n)
        changed = [contact.see(time_s, force_n) for contact, force_n in zip(self._contacts, forces_n, strict=True)]
        if any(
            has_changed and not contact.pressed for contact, has_changed in zip(self._contacts, changed, strict=True)
        ):
            before_n = [max(of_one) for of_one in zip(*self._lately, strict=True)]
            self.eased = [now_n < EASED * most_n for now_n, most_n in zip(forces_n, before_n, strict=True)]
            self._left_n = forces_n
        elif True in self.eased:  # a brake that is being released presses no harder again
            grown = [EASED * now_n > left_n for now_n, left_n in zip(forces_n, self._left_n, strict=True)]
            self.eased = [eased and not has_grown for eased, has_grown in zip(self.eased, grown, strict=True)]
        if any(contact.pressed for contact in self._contacts):
            self.begun_s = min(self.begun_s, time_s)
            return
        self.begin_was_seen, self.begun_s, self.eased = True, inf, [False] * self._count
        for contact in self._contacts:
            contact.begin_application()

    def took_part(self, i: int) -> bool:
        """Whether brake i has pressed in this application."""
        return self._contacts[i].has_pressed

    def is_easing(self, i: int) -> bool:
        """Whether brake i is still being vented, on average over the steps of a coarse sensor."""
        count = round(EASING_S / OBSERVATION_PERIOD_S)
        own_n = [forces_n[i] for forces_n in list(self._lately)[-2 * count :]]
        return fmean(own_n[-count:]) < EASING * fmean(own_n[:count])
