"""PEAK's .trc with its error frames. python-can's reader passes over them, and stops at those of version 1.0."""

import re

import can
from can.io.trc import TRCFileVersion

_MAY_BE_ONE = re.compile(r"\s(ER|Error|ERROR)\s")
_KIND_AT = {TRCFileVersion.V1_1: 2, TRCFileVersion.V1_3: 3}  # from version 2.0 on the header says
_KIND_AT_IN_1_0 = 4  # before the data
_BUS_AT = {TRCFileVersion.V1_3: 2}


class TrcReader(can.TRCReader):
    """python-can's reader; of an error frame it tells when it was, and on which bus."""

    def _parse_line(self, line: str) -> can.Message | None:
        found = self._error_frame(line.split()) if _MAY_BE_ONE.search(line) else None
        return found or super()._parse_line(line)

    def _error_frame(self, cells: list[str]) -> can.Message | None:
        """None where the word is the text of an event."""
        version, columns = self.file_version, self.columns
        kind_at = columns.get("T", _KIND_AT.get(version, _KIND_AT_IN_1_0))
        if cells[kind_at : kind_at + 1] not in (["ER"], ["Error"], ["ERROR"]):
            return None
        bus_at = columns.get("B", _BUS_AT.get(version))
        return can.Message(
            timestamp=float(cells[columns.get("O", 1)]) / 1000 + self._start_time,
            is_error_frame=True,
            channel=1 if bus_at is None else int(cells[bus_at]),
        )
