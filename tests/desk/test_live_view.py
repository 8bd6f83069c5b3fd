"""What a person sees: pure formatting first, then the panel, then a real terminal."""

import fcntl
import io
import math
import os
import pty
import re
import struct
import subprocess
import sys
import termios

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from brake_monitor.desk.board import ALARMS_SHOWN, BIN_S, HISTORY, Board
from brake_monitor.desk.board_lines import plain_line
from brake_monitor.desk.board_panel import panel, rail_style
from brake_monitor.desk.live_view import live_view
from brake_monitor.desk.text_marks import Moment, band, bar, number, plus_minus, scale_top, sparkline
from brake_monitor.errors import InputError
from brake_monitor.estimation.estimate import Status
from brake_monitor.monitoring.alarm import Severity
from brake_monitor.processing.pipeline import Outputs
from brake_monitor.samples import Quantity
from brake_monitor.settings.alarm_settings import LowAdhesionRule
from brake_monitor.settings.config import Vehicle
from estimates import alarm, estimate, wheelset
from network import PATIENCE_S

NAN = math.nan
ANY = st.floats(allow_nan=True, allow_infinity=True)


def vehicle(wheelsets: int = 2) -> Vehicle:
    return Vehicle(
        id="wagon-1",
        mass_kg=36000.0,
        axle_positions_m=tuple(4.5 - 3.0 * i for i in range(wheelsets)),
        cog_height_m=1.6,
        wheelset_inertia_kgm2=(118.0,) * wheelsets,
        wheel_radius_m=(0.445,) * wheelsets,
        brake_radius_m=(0.247,) * wheelsets,
    )


def board(*outputs: Outputs, wheelsets: int = 2) -> Board:
    shown = Board(vehicle(wheelsets), LowAdhesionRule())
    for output in outputs:
        shown = shown.after(output)
    return shown


def drawn(shown: Board, width: int = 80) -> list[str]:
    console = Console(width=width, file=io.StringIO(), force_terminal=True, color_system=None)
    console.print(panel(shown, width, "hint"))
    return re.sub(r"\x1b\[[0-9;]*m", "", console.file.getvalue()).splitlines()


def test_what_is_no_number_is_a_dash() -> None:
    assert (number(1.25, 1), number(NAN, 1, 5), number(math.inf, 3)) == ("1.2", "    –", "–")
    assert plus_minus(0.0834, 0.0061) == " 0.083 ±0.006"
    assert plus_minus(NAN, NAN) == "     – ±    –"


def test_a_bar_grows_with_its_value() -> None:
    assert (bar(0.0, 10.0, 4), bar(5.0, 10.0, 4), bar(10.0, 10.0, 4)) == ("    ", "██  ", "████")
    assert bar(5.0 + 10.0 / 32, 10.0, 4) == "██▏ "
    assert (bar(99.0, 10.0, 4), bar(-1.0, 10.0, 4), bar(NAN, 10.0, 4)) == ("████", "    ", "    ")


def test_a_band_stands_where_its_value_is_on_the_scale() -> None:
    assert band(0.055, 0.02, 0.10, 10) == "───▒▒█▒▒──"
    assert band(0.0, 0.0, 0.10, 10) == "█─────────"
    assert band(0.5, 0.0, 0.10, 10) == "─────────█"
    assert band(NAN, 0.01, 0.10, 10) == "──────────"


@given(value=ANY, std=st.just(NAN) | st.floats(min_value=0.0), width=st.integers(1, 60))
def test_a_bar_and_a_band_keep_their_width_whatever_comes(value: float, std: float, width: int) -> None:
    assert len(bar(value, 1.0, width)) == width
    assert len(band(value, std, 0.1, width)) == width
    assert len(sparkline([Moment(value, False)] * width, 0.1)) == width


def test_a_sparkline_rises_with_adhesion_and_is_empty_where_nothing_is_known() -> None:
    values = [Moment(0.1 * i / 8, False) for i in range(1, 9)]
    assert sparkline([*values, None, Moment(NAN, False), Moment(-0.01, False)], 0.1) == "▁▂▃▄▅▆▇█  ▁"


def test_the_scale_holds_every_value() -> None:
    assert scale_top([]) == pytest.approx(0.10)
    assert scale_top([0.15, NAN]) == pytest.approx(0.15)
    assert scale_top([0.151]) == pytest.approx(0.20)


def test_colour_speaks_of_the_rail_only_when_the_wheels_got_all_there_was() -> None:
    rule = LowAdhesionRule()
    assert rail_style(Moment(0.01, saturated=False), rule) == rail_style(Moment(0.3, saturated=False), rule)
    styles = [rail_style(Moment(adhesion, saturated=True), rule) for adhesion in (0.03, 0.07, 0.2)]
    assert styles == ["bold red", "yellow", "green"]


def test_history_has_a_bin_for_every_half_second_and_gaps_stay_gaps() -> None:
    times = (10.0, 10.0 + BIN_S, 10.0 + 3 * BIN_S)
    shown = board(*(Outputs(estimate(time_s=t, adhesion=t / 100, saturated=False)) for t in times))
    assert shown.history == (Moment(0.1, False), Moment(0.105, False), None, Moment(0.115, False))


def test_within_a_bin_the_worst_of_the_saturated_adhesion_is_kept() -> None:
    steps = ((0.08, False), (0.03, True), (0.05, True), (0.09, False))
    shown = board(*(Outputs(estimate(time_s=10.0, adhesion=a, saturated=s)) for a, s in steps))
    assert shown.history == (Moment(0.03, True),)


@pytest.mark.parametrize("then_s", [5.0, 11.0 + HISTORY * BIN_S])
def test_history_begins_anew_when_time_jumps(then_s: float) -> None:
    shown = board(*(Outputs(estimate(time_s=t)) for t in (10.0, 11.0, then_s)))
    assert (len(shown.history), shown.begun_s) == (1, then_s)


def test_history_does_not_grow_for_ever() -> None:
    shown = board(*(Outputs(estimate(time_s=k * BIN_S)) for k in range(HISTORY + 50)))
    assert len(shown.history) == HISTORY


def test_an_alarm_stands_as_it_is_now_and_open_ones_stay() -> None:
    still_open = alarm(id="open")
    cleared = [alarm(id=f"over-{k}", cleared_time_s=1700000009.0) for k in range(ALARMS_SHOWN + 2)]
    shown = board(Outputs(None, (still_open, alarm(id="over-7"))), *(Outputs(None, (a,)) for a in cleared))
    assert len(shown.alarms) == ALARMS_SHOWN
    assert shown.alarms[0] == still_open
    assert all(a.cleared_time_s is not None for a in shown.alarms[1:])


def test_the_panel_shows_all_that_is_asked_of_it() -> None:
    shown = board(
        Outputs(estimate(wheelsets=(wheelset(), wheelset(wsp_active=True, friction_status=Status.HELD)))),
        Outputs(None, (alarm(message="The rail gives 0.03."),)),
    )
    lines = drawn(shown)
    text = "\n".join(lines)
    assert all(len(line) == 80 for line in lines)
    assert "wagon-1" in lines[0]
    assert "hint" in lines[-1]
    assert "64.8 km/h" in text  # 18 m/s
    assert "0.080 ±0.003" in text
    assert "the rail gives no more" in text
    first, second = (next(line for line in lines if line.startswith(f"│ {i} ")) for i in (1, 2))
    assert "64.1" in first  # 40 rad/s on a wheel of 0.445 m
    assert "2.0 %" in first
    assert "41.0 kN" in first
    assert "0.340 ±0.010 valid" in first
    assert "WSP" not in first
    assert "held" in second
    assert "WSP" in second
    assert " ALARM " in text
    assert "low adhesion since" in text
    assert "The rail gives 0.03." in text


@pytest.mark.parametrize("wheelsets", [1, 2, 4])
@pytest.mark.parametrize("status", list(Status))
def test_nothing_is_cut_off_at_80_columns(wheelsets: int, status: Status) -> None:
    axle = wheelset(
        friction_status=status,
        wsp_active=True,
        slip=-0.999,
        adhesion=-0.123,
        omega_radps=100.0,
        pressing_force_n=99999.0,
    )
    shown = board(Outputs(estimate(wheelsets=(axle,) * wheelsets, status=status)), wheelsets=wheelsets)
    rows = [line for line in drawn(shown) if "kN" in line]
    assert len(rows) == wheelsets
    assert all("…" not in row and f"{status}" in row and "WSP" in row for row in rows)


@pytest.mark.parametrize(
    ("width", "kept"), [(60, ("2.0 %", "41.0 kN", "WSP")), (44, ("2.0 %",)), (80, ("64.1", "0.090"))]
)
def test_a_narrow_terminal_keeps_friction_and_status_and_cuts_nothing(width: int, kept: tuple[str, ...]) -> None:
    converging = wheelset(friction_status=Status.CONVERGING, wsp_active=True)
    lines = drawn(board(Outputs(estimate(wheelsets=(converging,) * 4)), wheelsets=4), width)
    rows = [line for line in lines if "0.340 ±0.010 converging" in line]
    assert len(rows) == 4
    assert all(text in row for row in rows for text in kept)
    assert any("pad friction" in line for line in lines)
    assert any("64.8 km/h" in line and "valid" in line for line in lines)
    assert all(len(line) == width for line in lines)
    assert "…" not in "".join(lines) or width < 60


def test_without_numbers_there_is_still_a_panel_and_a_line() -> None:
    nothing = wheelset(**dict.fromkeys(("omega_radps", "slip", "friction", "friction_std", "pressing_force_n"), NAN))
    shown = board(Outputs(estimate(speed_mps=NAN, adhesion=NAN, adhesion_std=NAN, wheelsets=(nothing,) * 2)))
    assert "– km/h" in "\n".join(drawn(shown))
    assert "– km/h" in plain_line(shown)
    assert "waiting" in "\n".join(drawn(board()))


def test_what_was_never_told_is_a_dash() -> None:
    first = {(Quantity.AXLE_SPEED, 0), (Quantity.PRESSING_FORCE, 0), (Quantity.WSP_ACTIVE, 0)}
    shown = board(Outputs(estimate(unknown=frozenset({(Quantity.SPEED, 0), *first}))))
    rows = [line for line in drawn(shown) if "kN" in line]
    assert re.match(r"│ 1 +– +– % +– kN .* –  *│$", rows[0])
    assert re.match(r"│ 2 +64\.1 +– % .* 41\.0 kN .* WSP *│$", rows[1])
    assert re.search(r"– km/h .* 1: +– km/h  slip +– %  force +– kN .* –  *\| 2: +64\.1 km/h", plain_line(shown))
    assert "speed          – km/h" in "\n".join(drawn(shown))


def test_a_plain_line_names_every_wheelset_from_one() -> None:
    line = plain_line(board(Outputs(estimate())))
    assert "64.8 km/h  adhesion  0.080 ±0.003 saturated valid" in line
    assert re.search(r"\| 1: .* friction  0\.340 ±0\.010 valid \| 2: .* 0\.310 ±0\.010 held  WSP$", line)


def test_off_a_terminal_there_is_one_line_per_second_and_one_per_alarm(capsys: pytest.CaptureFixture[str]) -> None:
    with live_view(vehicle(), LowAdhesionRule()) as show:
        for tenth in range(21):
            show(Outputs(estimate(time_s=10.0 + tenth / 10)))
        show(Outputs(None, (alarm(severity=Severity.WARNING),)))
        show(Outputs(None, (alarm(severity=Severity.WARNING, cleared_time_s=12.0),)))
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(" s ")[0].strip() for line in lines[:3]] == ["0.0", "1.0", "2.0"]
    assert [line.split(":")[0] for line in lines[3:]] == [
        "  WARNING low adhesion open",
        "  WARNING low adhesion cleared",
    ]


def test_a_terminal_without_rich_is_told_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    monkeypatch.setitem(sys.modules, "rich", None)
    with pytest.raises(InputError, match=r"'\.\[desk\]'"), live_view(vehicle(), LowAdhesionRule()):
        pass


ON_A_TERMINAL = """
from brake_monitor.settings.alarm_settings import LowAdhesionRule
from brake_monitor.desk.live_view import live_view
from brake_monitor.processing.pipeline import Outputs
from test_live_view import vehicle
from estimates import alarm, estimate
with live_view(vehicle(), LowAdhesionRule(), "how to subscribe") as show:
    show(Outputs(estimate(), (alarm(),)))
"""


def test_on_a_real_terminal_it_draws_in_colour_and_gives_the_cursor_back() -> None:
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
    environment = {k: v for k, v in os.environ.items() if k not in ("NO_COLOR", "COLUMNS", "LINES")}
    environment |= {"PYTHONPATH": os.pathsep.join(sys.path), "TERM": "xterm-256color"}
    with subprocess.Popen([sys.executable, "-c", ON_A_TERMINAL], stdout=theirs, env=environment) as child:
        os.close(theirs)
        seen = b""
        try:
            while chunk := os.read(ours, 4096):
                seen += chunk
        except OSError:  # the other end was closed: how a pseudo-terminal ends
            pass
        os.close(ours)
        assert child.wait(PATIENCE_S) == 0
    text = seen.decode()
    assert "how to subscribe" in text
    assert "0.080 ±0.003" in text
    assert "\x1b[1;37;41m ALARM " in text  # bold white on red
    assert text.rindex("\x1b[?25h") > text.rindex("\x1b[?25l")  # cursor shown again after it was hidden
