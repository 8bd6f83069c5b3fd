"""What is due of sensors and buses that fail."""

from collections.abc import Iterator

from brake_monitor.samples import TRAITS
from brake_monitor.simulator.due.alarm import AFTERMATH_S, SETTLED_S, Due
from brake_monitor.simulator.due.truth import Truth
from brake_monitor.simulator.sensor_faults import BusFailure, BusFault, SensorFailure, SensorFault


def failed_sensors(truth: Truth) -> Iterator[Due]:
    """What each sensor fault makes due."""
    for fault in truth.recording.modifiers.sensor_faults:
        end_s = min(fault.to_s, float(truth.time_s[-1]))
        yield from _sensor(truth, fault, end_s)


def _sensor(truth: Truth, fault: SensorFault, end_s: float) -> Iterator[Due]:
    """Lost is what no longer arrives, implausible what arrives and says nothing; nobody sees a bias within the range.

    With a message, all signals in it are lost.
    """
    due_kind = "input_lost" if fault.failure is SensorFailure.LOST else "input_implausible"
    place = fault.place if TRAITS[fault.quantity].per_wheelset and not _is_shared(truth, fault) else None
    span = (fault.from_s, end_s + AFTERMATH_S)
    why = f"{fault.quantity} {fault.place + 1}: {fault.failure}"
    from_s = _tells_from(truth, fault)
    if from_s is not None:
        yield truth.due(due_kind, place, span, from_s, why)
    for kind in ("input_lost", "input_implausible"):
        for wheelset in (None, *range(truth.count)):
            yield truth.due(kind, wheelset, span, None, why)


def _is_shared(truth: Truth, fault: SensorFault) -> bool:
    """Whether it is the one flag that tells of all wheelsets."""
    return fault.quantity == "wsp_active" and len(truth.recording.settings.signals.wsp_active) == 1


def _tells_from(truth: Truth, fault: SensorFault) -> float | None:
    """When the fault can be seen, None: never.

    What a pressing force says wrongly shows once the brakes are applied, beside those of other wheelsets.
    """
    from_s = max(fault.from_s, SETTLED_S)
    if fault.failure is SensorFailure.BIASED:
        return None
    if fault.quantity != "pressing_force" or fault.failure in (SensorFailure.LOST, SensorFailure.ERROR_CODE):
        return from_s
    braked = truth.time_s[truth.supplied & (truth.time_s >= from_s)]
    return float(braked[0]) if truth.count > 1 and len(braked) else None


def failed_buses(truth: Truth) -> Iterator[Due]:
    """What each bus fault makes due, and that nothing arrives meanwhile."""
    for fault in truth.recording.modifiers.bus_faults:
        yield from _bus(truth, fault)


def _bus(truth: Truth, fault: BusFault) -> Iterator[Due]:
    due_kind = "bus_silent" if fault.failure is BusFailure.SILENT else "bus_fault"
    span, why = (fault.from_s, fault.to_s + AFTERMATH_S), f"the bus: {fault.failure}"
    yield truth.due(due_kind, None, span, fault.from_s, why)
    yield truth.due("bus_silent", None, span, None, why)
    for kind in ("input_lost", "input_implausible"):
        for wheelset in (None, *range(truth.count)):
            yield truth.due(kind, wheelset, span, None, f"nothing arrives: {why}")
