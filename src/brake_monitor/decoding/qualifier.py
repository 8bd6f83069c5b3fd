"""The signal beside a value by which its sender says whether the value is to be believed."""

from collections.abc import Iterable
from dataclasses import dataclass

from brake_monitor.decoding.raw_number import integers
from brake_monitor.decoding.signal_field import SignalField
from brake_monitor.errors import InputError


@dataclass(slots=True)
class Qualifier:
    """Judges the values of one signal; every frame with the signal has it, unless it is cut off."""

    field: SignalField
    good: frozenset[int]  # raw numbers
    rejected: int = 0  # values so far

    def is_good(self, data: bytes) -> bool | None:
        """Whether a frame's value is to be believed; None when the frame is too short to tell."""
        raw = self.field.raw_of(data)
        return None if raw is None else raw in self.good

    def __str__(self) -> str:
        """For people: `fix is 2 or 3`."""
        return f"{self.field.name} is {' or '.join(map(str, sorted(self.good)))}"


def as_qualifier(field: SignalField, qualified: SignalField) -> SignalField:
    """The signal that is named as another's qualifier; InputError when it cannot be one."""
    if fault := _no_qualifier(field, qualified):
        raise InputError(
            f'signal "{field.name}" cannot be the qualifier of "{qualified.name}": it {fault}, expected a whole number '
            "in every frame that has the value"
        )
    return field


def good_numbers(field: SignalField, numbers: Iterable[int]) -> frozenset[int]:
    """The numbers of a qualifier that speak for the value; InputError when it cannot have one of them."""
    least, most = integers(field.length, field.is_signed)
    for number in numbers:
        if not least <= number <= most:
            bits = f"{field.length} bits" if field.length > 1 else "1 bit"
            raise InputError(f'signal "{field.name}" has {bits}, expected raw numbers from {least} to {most}')
    return frozenset(numbers)


def _no_qualifier(field: SignalField, qualified: SignalField) -> str:
    """Why it cannot be a qualifier; "" where it may be one."""
    if field.name == qualified.name:
        return "is the value itself"
    if field.is_float:
        return "is a floating-point number"
    pages = {condition.multiplexer.name: condition.pages for condition in qualified.conditions}
    for own in field.conditions:
        name = own.multiplexer.name
        if name not in pages or not pages[name] <= own.pages:
            return "is only on some pages"
    return ""
