"""Dragging brake: one goes on pressing when the others are released, or all do while the train pulls the wagon."""

from collections.abc import Sequence
from math import inf

from brake_monitor.estimation.estimate import Estimate
from brake_monitor.estimation.inputs.pad_contact import RELEASE_FRACTION
from brake_monitor.monitoring.alarm import Severity, Values
from brake_monitor.monitoring.inputs.watched_wheelset import STANDSTILL_MPS
from brake_monitor.monitoring.inputs.wheel_state import WheelState
from brake_monitor.monitoring.misled import MisledBy
from brake_monitor.monitoring.observation import Observation
from brake_monitor.monitoring.rule import FINE, UNKNOWN, Finding, Rule, Suspicion, Verdict
from brake_monitor.monitoring.rules.hidden_drag import HiddenDrag, HiddenDragSearch
from brake_monitor.monitoring.rules.lasting_creep import CreepDrag, LastingCreepSearch
from brake_monitor.monitoring.rules.participation import LEAST_FRICTION, Participation
from brake_monitor.samples import Quantity
from brake_monitor.settings.alarm_settings import DraggingBrakeRule

BLOCKED = WheelState.BLOCKED
STRONG = 3.0  # times the force of a brake that should be released: snow brakes of trains under power press with less
GAINED_MPS = 5.0  # with brakes that are about to release, as those at a train's end, it gains less


class DraggingBrake(Rule[DraggingBrakeRule]):
    """Judges pressing forces against each other, and whether one that stays really retards.

    Fewer than half that stay have not been released. Half of them that stay have not, either, when they eased as the
    others left; if they press on as before, the others may have lost their air in mid-application: both is said then.
    A brake that drags without its pressing force saying so is looked for after each release, and is not fine before the
    wagon has rolled without it. One that lets its wheelset stand is not before the wagon has stood. While motors brake
    they may do so for brakes that are released. In a train an unseen drag shows but in the creep of some kilometres.
    """

    kind = "dragging_brake"

    def __init__(self, settings: DraggingBrakeRule, friction_nominal: float, wheelset_count: int) -> None:
        super().__init__(settings, wheelset_count)
        self._released_n = RELEASE_FRACTION * settings.min_force_n
        self._least_friction = LEAST_FRICTION * friction_nominal
        self._participation = Participation(settings.min_force_n, wheelset_count)
        self._strong_n = STRONG * settings.min_force_n
        self._least_mps = inf  # since more than half of the brakes have pressed so strongly without interruption
        self._search = HiddenDragSearch(settings.min_force_n, settings.hidden_force_n)
        self._long_search = LastingCreepSearch(settings.min_force_n, settings.hidden_force_n)
        self._blocks: set[int] = set()  # brakes that let their wheelsets stand, and may still press

    def judge(self, seen: Observation) -> tuple[Verdict, ...]:
        """One verdict per wheelset."""
        now = seen.estimate
        count = len(self.wheelsets)
        hidden = self._search.see(now, seen.all_good)
        creeping = self._long_search.see(now, seen.all_good)
        gained_mps = self._gained_mps(seen)
        if all(seen.inputs.are_good(Quantity.PRESSING_FORCE, count)):  # in a tunnel as well
            self._participation.see(now.time_s, seen.forces_n)
        if not seen.all_good:
            return (UNKNOWN,) * count
        self._see_blocked(now.speed_mps, seen.wheels)
        if now.speed_mps < self.settings.min_speed_mps:
            return (UNKNOWN,) * count
        if BLOCKED in seen.wheels:  # nothing can be said of a brake that is applied, or of wheelsets that roll
            pairs = zip(seen.wheels, seen.forces_n, strict=True)
            are_held = [state is BLOCKED and force_n < self._released_n for state, force_n in pairs]
            return tuple([_blocked(i, now) if is_held else UNKNOWN for i, is_held in enumerate(are_held)])
        if now.saturated or True in seen.motors_brake:
            return (UNKNOWN,) * count
        may_drag = self._drags_unseen or self._long_search.suspected is not None
        if not may_drag and max(seen.forces_n) < self._released_n:  # the usual case
            return (FINE,) * count
        released = [i for i, force_n in enumerate(seen.forces_n) if force_n < self._released_n]
        found = {creeping.wheelset: _creeping(creeping, now)} if creeping else {}
        if hidden:
            found[hidden.wheelset] = _hidden(hidden, now)
        if gained_mps > GAINED_MPS:
            pressing = [i for i, force_n in enumerate(seen.forces_n) if force_n >= self._strong_n]
            found |= {i: _pulled(i, seen, self._least_mps) for i in pressing}
        return tuple([found.get(i) or self._judge(i, released, seen) for i in range(count)])

    def resume(self, i: int, evidence: Values) -> MisledBy | None:
        """Go on with a brake that drags unseen until the wagon has rolled without it, or has stood.

        What pressing forces tell needs no memory.
        """
        if "others_pressing_force_n" in evidence or "least_speed_mps" in evidence:
            return None
        if told := _numbers(evidence, HiddenDrag._fields[1:]):
            self._search.lasting[i] = HiddenDrag(i, *told)
        elif told := _numbers(evidence, CreepDrag._fields[1:]):
            self._long_search.lasting[i] = CreepDrag(i, *told)
        else:
            self._blocks.add(i)
        return MisledBy.DRAG

    @property
    def _drags_unseen(self) -> set[int]:
        """The wheelsets of which it has been found, and not known to be over."""
        return self._blocks.union(self._search.lasting, self._long_search.lasting)

    def _gained_mps(self, seen: Observation) -> float:
        """What the wagon has gained though most brakes press, as far as is known: the train pulls it."""
        press = [force_n >= self._strong_n for force_n in seen.forces_n] if seen.all_good else []
        self._least_mps = min(self._least_mps, seen.estimate.speed_mps) if 2 * sum(press) > len(press) else inf
        return seen.estimate.speed_mps - self._least_mps

    def _see_blocked(self, speed_mps: float, wheels: tuple[WheelState, ...]) -> None:
        if speed_mps < STANDSTILL_MPS:
            self._blocks.clear()
        elif BLOCKED in wheels:
            self._blocks.update([i for i, state in enumerate(wheels) if state is BLOCKED])

    def _judge(self, i: int, released: list[int], seen: Observation) -> Verdict:
        if i in released:
            suspected = self._long_search.suspected
            if suspected is not None and suspected.wheelset == i:
                return Suspicion(MisledBy.SILENT)
            return UNKNOWN if i in self._drags_unseen else FINE
        own, forces_n = seen.estimate.wheelsets[i], seen.forces_n
        most_are = 2 * len(released) >= len(forces_n) and forces_n[i] >= self.settings.min_force_n
        if not most_are or not self._are_through(released, seen.time_s) or own.friction < self._least_friction:
            return UNKNOWN
        if self._participation.is_easing(i):  # slower than the others
            return UNKNOWN
        is_likely = 2 * len(released) > len(forces_n) or self._participation.eased[i]
        is_certain = is_likely and self._took_part(released)
        others = _named(released) if len(released) < len(forces_n) - 1 else "the others"
        return Finding(
            Severity.ALARM,
            f"The brake of wheelset {i + 1} still presses with {forces_n[i] / 1000.0:.1f} kN while {others} are "
            f"released, at {seen.estimate.speed_mps * 3.6:.0f} km/h."
            + ("" if is_certain else f" Or the wagon is braking, and {others} are isolated or have lost their air."),
            {
                "pressing_force_n": forces_n[i],
                "others_pressing_force_n": max(forces_n[k] for k in released),
                "friction": own.friction,
                "disc_temperature_c": seen.brakes.units[i].disc_temperature_c,
                "speed_mps": seen.estimate.speed_mps,
            },
            latches=is_likely,
            weighed_by="pressing_force_n",
        )

    def _are_through(self, released: list[int], time_s: float) -> bool:
        """Whether those have braked and been released, or would have by now; else they may still have to come on."""
        return self._took_part(released) or time_s - self._participation.begun_s > self.settings.alone_s

    def _took_part(self, released: list[int]) -> bool:
        return any(map(self._participation.took_part, released))


def _named(wheelsets: list[int]) -> str:
    *first, last = [str(k + 1) for k in wheelsets]
    return f"those of wheelsets {', '.join(first)} and {last}"


def _pulled(i: int, seen: Observation, from_mps: float) -> Finding:
    now = seen.estimate
    return Finding(
        Severity.ALARM,
        f"The brake of wheelset {i + 1} still presses with {seen.forces_n[i] / 1000.0:.1f} kN, as most do, though "
        f"the wagon has gained speed from {from_mps * 3.6:.0f} to {now.speed_mps * 3.6:.0f} km/h: it has not been "
        "released, or does not hold the wagon on a descent.",
        {
            "pressing_force_n": seen.forces_n[i],
            "friction": now.wheelsets[i].friction,
            "disc_temperature_c": seen.brakes.units[i].disc_temperature_c,
            "least_speed_mps": from_mps,
            "speed_mps": now.speed_mps,
        },
    )


def _blocked(i: int, now: Estimate) -> Finding:
    why = ": its hand brake is on, its pads stick, or a bearing or gear has seized"
    return _unseen(i, now, "does not let it turn, though its pressing force says released", {}, why)


def _hidden(found: HiddenDrag, now: Estimate) -> Finding:
    said = (
        "drags after the release, though its pressing force says released: it retards with about "
        f"{found.retarding_force_n / 1000.0:.1f} kN"
    )
    return _unseen(found.wheelset, now, said, found._asdict())


def _creeping(found: CreepDrag, now: Estimate) -> Finding:
    force_n = found.retarding_force_n(now)
    said = (
        f"drags, though its pressing force says released: over {found.shown_over_m / 1000.0:.1f} km of free rolling it "
        f"has turned more slowly than before, as under about {force_n / 1000.0:.1f} kN"
    )
    return _unseen(found.wheelset, now, said, {**found._asdict(), "retarding_force_n": force_n})


def _unseen(i: int, now: Estimate, said: str, told: Values, why: str = "") -> Finding:
    """What a brake does of which its pressing force says nothing."""
    values = told | {"pressing_force_n": now.wheelsets[i].pressing_force_n, "speed_mps": now.speed_mps}
    values.pop("wheelset", None)
    return Finding(
        Severity.ALARM,
        f"The brake of wheelset {i + 1} {said}, at {now.speed_mps * 3.6:.0f} km/h{why}.",
        values,
        misled_by=MisledBy.DRAG,
    )


def _numbers(evidence: Values, names: Sequence[str]) -> list[float]:
    """The evidence by these names; empty where not all of it is there."""
    told = [value for name in names if isinstance(value := evidence.get(name), float | int)]
    return told if len(told) == len(names) else []
