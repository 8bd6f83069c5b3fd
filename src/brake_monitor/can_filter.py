"""Which frames a bus lets through: decided where signals are mapped, applied by the kernel."""

from typing import TypedDict


class CanFilter(TypedDict):
    """Lets a frame through when `received_id & can_mask == can_id & can_mask`, as python-can takes it."""

    can_id: int
    can_mask: int
    extended: bool
