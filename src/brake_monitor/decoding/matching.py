"""How the frames of a message are known: by identifier and width, or by PGN whatever their priority and addresses."""

from dataclasses import dataclass
from typing import Literal

from cantools.database.can import Message

from brake_monitor.decoding.dbc import BusDatabase
from brake_monitor.decoding.j1939 import NULL_ADDRESS, pgn, pgn_bits, pgn_mask
from brake_monitor.errors import InputError
from brake_monitor.frame import LARGEST_EXTENDED_ID, LARGEST_ID, CanFilter, can_id_text


@dataclass(frozen=True, slots=True)
class Matching:
    """Which frames of a bus are taken for a message, and why it is done that way."""

    bus: str
    message: str
    can_id: int  # as the DBC has it
    extended: bool
    by: Literal["id", "pgn"]
    is_j1939: bool  # its raw values have J1939's codes for "error" and "not available"
    reason: str  # for people; "" where the ordinary is done

    def __str__(self) -> str:
        known = f"PGN 0x{pgn(self.can_id):04X}" if self.by == "pgn" else f"id {can_id_text(self.can_id, self.extended)}"
        return f"{known}, {self.reason}" if self.reason else known

    def can_filter(self) -> CanFilter:
        """Return the kernel filter that lets the message's frames through."""
        if self.by == "pgn":
            return CanFilter(can_id=pgn_bits(self.can_id), can_mask=pgn_mask(self.can_id), extended=True)
        mask = LARGEST_EXTENDED_ID if self.extended else LARGEST_ID
        return CanFilter(can_id=self.can_id, can_mask=mask, extended=self.extended)


def matching_of(database: BusDatabase, message: Message, wanted: Literal["id", "pgn"] | None) -> Matching:
    """Decide how a message is matched; `wanted` overrides what its DBC says.

    InputError when another message of the bus cannot be told from it, or when it has no PGN to be matched by.
    """
    evidence = _j1939_evidence(database, message)
    id_double = database.double_of(message, lambda other: (other.is_extended_frame, other.frame_id))
    pgn_double = database.double_of(message, lambda other: (other.is_extended_frame, pgn_bits(other.frame_id)))
    by, reason = wanted, "as configured"
    if by is None:
        by, reason = ("pgn", f"J1939: {evidence}") if evidence else ("id", "")
        if by == "pgn" and pgn_double:
            by, reason = "id", f"J1939, but {pgn_double} has the same PGN"
    if by == "pgn" and not message.is_extended_frame:
        raise InputError(f'message "{message.name}" has an 11-bit id, which has no PGN')
    double = pgn_double if by == "pgn" else id_double
    if double:
        raise InputError(
            f'message "{message.name}" is ambiguous on bus "{database.bus}": by {by} it cannot be told from "{double}"'
        )
    is_j1939 = bool(evidence) or by == "pgn"
    return Matching(database.bus, message.name, message.frame_id, message.is_extended_frame, by, is_j1939, reason)


def _j1939_evidence(database: BusDatabase, message: Message) -> str:
    """Return what in its DBC says that a message is J1939, "" when nothing does."""
    is_something_else = (
        message.dbc is not None and "VFrameFormat" in message.dbc.attributes and message.protocol != "j1939"
    )
    if not message.is_extended_frame or is_something_else:
        return ""
    if message.protocol == "j1939":
        return 'its VFrameFormat is "J1939PG"'
    path, file = database.file_of(message)
    protocol = file.dbc.attributes.get("ProtocolType") if file.dbc is not None else None
    if protocol is not None and str(protocol.value).upper() == "J1939":
        return f'the ProtocolType of {path.name} is "{protocol.value}"'
    if any(signal.spn for signal in message.signals):
        return "its signals have SPNs"
    if all(other.frame_id & 0xFF == NULL_ADDRESS for other in file.messages if other.is_extended_frame):
        # No node sends measurements from the null address: it holds the place of every sender's.
        return f"all extended ids of {path.name} end in the null address 0x{NULL_ADDRESS:02X}"
    return ""
