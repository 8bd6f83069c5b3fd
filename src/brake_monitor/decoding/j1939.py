"""What SAE J1939 lays down about identifiers (J1939-21) and about raw values that are no measurement (J1939-71)."""

NULL_ADDRESS = 0xFE  # of a node that has no address; in a DBC it stands for whichever node sends

_PF_PDU2 = 240  # from this PDU format on, the byte below it belongs to the PGN; before, it is a destination

_PDU1_MASK = 0x03FF0000
_PDU2_MASK = 0x03FFFF00


def pgn_mask(can_id: int) -> int:
    """Return the bits of a 29-bit identifier that make its PGN: no priority, source nor destination address."""
    return _PDU2_MASK if can_id >> 16 & 0xFF >= _PF_PDU2 else _PDU1_MASK


def pgn_bits(can_id: int) -> int:
    """Return the identifier with everything but its PGN set to 0."""
    return can_id & pgn_mask(can_id)


def pgn(can_id: int) -> int:
    """Return the parameter group number of a 29-bit identifier."""
    return pgn_bits(can_id) >> 8


def first_not_available(length: int) -> int | None:
    """Return the lowest raw value of an unsigned parameter of `length` bits that means error or not available.

    From one byte on the most significant byte tells (0xFE error, 0xFF not available); of 2 and 4 bits the two
    highest codes; other short parameters only have "all ones"; a single bit has none.
    """
    if length >= 8:
        return 0xFE << (length - 8)
    if length == 1:
        return None
    return (1 << length) - (2 if length in (2, 4) else 1)
