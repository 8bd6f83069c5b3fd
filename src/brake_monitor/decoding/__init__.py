"""CAN frames → samples of mapped signals in SI units, through DBC files; frame by frame, or a block at once."""
