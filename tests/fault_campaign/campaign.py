"""The faults: what is done to a gateway, what is expected of it, and how that is seen."""

import errno
import os
import random
import resource
import signal
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple

from brake_monitor.frame import Frame
from brake_monitor.storage.store import Store
from gateway import MEMORY, STATE_MOUNT, WATCHDOG_S, Gateway
from installation import CONFIG, INSTALLED, SERVICE, run, shown
from program import run as run_whatever_comes

SOON_S = 10.0  # until an estimate is there again, once what it needs is; on a slow virtual machine
ENDS = 6

Play = Callable[[Gateway], str]


class Fault(NamedTuple):
    """One row of the table."""

    name: str
    expected: str
    play: Play  # does it, asserts what is expected, says what was seen
    everyday: bool  # part of every test run, not of the whole campaign alone


FAULTS: list[Fault] = []


def fault(name: str, expected: str, *, everyday: bool = False) -> Callable[[Play], Play]:
    def enter(play: Play) -> Play:
        FAULTS.append(Fault(name, expected, play, everyday))
        return play

    return enter


def back(seconds: float) -> str:
    return f"estimates again after {seconds:.1f} s"


# -- the process ---------------------------------------------------------------------------------------------------


@fault("kill -9", "systemd starts it anew within 2 s; it goes on with its memory", everyday=True)
def killed(gateway: Gateway) -> str:
    with gateway.driving():
        worn = braked_j()
        before_s = time.monotonic()
        gateway.kill(signal.SIGKILL)
        gap_s = until_it_estimates_again(gateway, before_s)
        assert braked_j() >= worn
    assert shown("RestartUSec") == "1s"  # what is more is the machine's
    started_s = int(shown("ExecMainStartTimestampMonotonic")) * 1e-6 - before_s
    return f"started anew after {started_s:.1f} s; {back(gap_s)}; {gateway.assert_sound(restarts=1)}"


def until_it_estimates_again(gateway: Gateway, before_s: float) -> float:
    """Seconds from the fault to the first estimate of the process that was started anew."""
    gateway.wait_for_restart()
    ready_s = time.monotonic()
    return ready_s - before_s + gateway.wait_for_estimate(ready_s)


@fault(
    "the main thread hangs",
    f"the watchdog (here {WATCHDOG_S} s) has it killed and started anew; where it hung is in the journal",
)
def hangs(gateway: Gateway) -> str:
    return not_responding(gateway, signal.SIGUSR1)


@fault("SIGSTOP", f"the watchdog (here {WATCHDOG_S} s) has it killed and started anew; where it hung is in the journal")
def stopped(gateway: Gateway) -> str:
    return not_responding(gateway, signal.SIGSTOP)


def not_responding(gateway: Gateway, number: signal.Signals) -> str:
    with gateway.driving():
        before_s = time.monotonic()
        gateway.kill(number)
        gap_s = until_it_estimates_again(gateway, before_s)
    assert any("/daemon/service.py" in line for line in gateway.places())
    return f"{back(gap_s)}; {gateway.assert_sound(restarts=1)}"


@fault("two daemons with the same memory", "the second ends with one sentence; the first is not disturbed")
def second_daemon(gateway: Gateway) -> str:
    with gateway.driving():
        second = run_whatever_comes(
            *("env", f"STATE_DIRECTORY={STATE_MOUNT}"),
            *(INSTALLED / "bin/brake-monitor", "run", "-c", CONFIG, "--log-level", "error"),
        )
        gateway.wait_for_estimate(time.monotonic(), {"valid"})
    (sentence,) = second.stderr.splitlines()
    assert (second.returncode, second.stdout) == (1, "")
    return f"“{sentence}”; {gateway.assert_sound()}"


@fault("memory limit", "the kernel kills it alone, it is started anew until there is room, and then goes on")
def out_of_memory(gateway: Gateway) -> str:
    with gateway.driving():
        run("systemctl", "set-property", "--runtime", SERVICE, "MemoryMax=24M")
        gateway.wait_for(lambda: gateway.restarts() >= 1, "restarted")
        run("systemctl", "set-property", "--runtime", SERVICE, "MemoryMax=256M")
        before_s = time.monotonic()
        gap_s = gateway.wait_for_estimate(before_s)
        restarts = gateway.restarts()
        assert restarts <= 5
    return f"{back(gap_s)} with room; {gateway.assert_sound(restarts=restarts)}"


@fault("no more file descriptors", "it goes on with those it has, and reopens the bus once there are more")
def out_of_descriptors(gateway: Gateway) -> str:
    with gateway.driving():
        _, hard = resource.prlimit(gateway.pid, resource.RLIMIT_NOFILE)
        resource.prlimit(gateway.pid, resource.RLIMIT_NOFILE, (4, hard))  # below it, all are in use; poll(2) needs it
        gateway.wait_for_estimate(time.monotonic() + 2.0 * WATCHDOG_S, {"valid"})
        bus_fails(gateway)
        gateway.wait_for_line("Too many open files")
        before_s = time.monotonic()
        resource.prlimit(gateway.pid, resource.RLIMIT_NOFILE, (hard, hard))
        gap_s = gateway.wait_for_estimate(before_s)
        assert gap_s < SOON_S
    return f"{back(gap_s)} with descriptors; {gateway.assert_sound(alarms=['bus_fault'])}"


# -- the bus -------------------------------------------------------------------------------------------------------


def bus_fails(gateway: Gateway) -> None:
    run("ip", "link", "set", "can0", "down")
    gateway.wait_for_line("failed while listening")
    run("ip", "link", "set", "can0", "up")


@fault(
    "interface down and up",
    f"alarm bus_fault; estimates within {SOON_S:.0f} s of its return, then the alarm clears",
    everyday=True,
)
def interface_down(gateway: Gateway) -> str:
    with gateway.driving():
        run("ip", "link", "set", "can0", "down")
        gateway.wait_for_alarm("bus_fault", "open")
        assert "is down" in gateway.wait_for(lambda: re_status("is down"), "told in the status")
        before_s = time.monotonic()
        run("ip", "link", "set", "can0", "up")
        gap_s = gateway.wait_for_estimate(before_s)
        assert gap_s < SOON_S
        gateway.wait_for_alarm("bus_fault", "cleared")
    return f"{back(gap_s)}; {gateway.assert_sound(alarms=['bus_fault'])}"


def re_status(word: str) -> str:
    status = shown("StatusText")
    return status if word in status else ""


@fault("interface deleted and made anew", f"as when it is down; estimates within {SOON_S:.0f} s of the wagon's frames")
def interface_gone(gateway: Gateway) -> str:
    with gateway.driving():
        gateway.bus_goes()
        gateway.wait_for_alarm("bus_fault", "open")
    gateway.bus_appears()
    before_s = time.monotonic()
    with gateway.driving(again=True):
        gap_s = gateway.wait_for_estimate(before_s)
        gateway.wait_for_alarm("bus_fault", "cleared")
    return f"{back(gap_s)}; {gateway.assert_sound(alarms=['bus_fault'])}"


@fault("start before the interface exists", "it waits, says so once, and is ready when the interface is up")
def no_interface_at_the_start(gateway: Gateway) -> str:
    gateway.systemctl("stop")
    gateway.bus_goes()
    run("systemctl", "start", "--no-block", SERVICE)
    gateway.wait_for(lambda: re_status("no network interface"), "told in the status")
    assert shown("ActiveState") == "activating"
    gateway.bus_appears(up=False)
    gateway.wait_for(lambda: re_status("is down"), "told in the status")
    assert shown("ActiveState") == "activating"
    before_s = time.monotonic()
    for name in ("can0", "wire0"):
        run("ip", "link", "set", name, "up")
    gateway.wait_for(lambda: shown("ActiveState") == "active", "ready")
    ready_s = time.monotonic() - before_s
    with gateway.driving(again=True):
        pass
    return f"ready {ready_s:.1f} s after the interface; {gateway.assert_sound()}"


@fault("bus silent", "estimate invalid at once, alarm bus_silent; both end with the silence", everyday=True)
def silence(gateway: Gateway) -> str:
    with gateway.driving():
        pass
    gateway.mark.until = None
    before_s = time.monotonic()
    told_s = gateway.wait_for_estimate(before_s, {"invalid"})
    assert told_s < SOON_S
    gateway.wait_for_alarm("bus_silent", "open")
    with gateway.driving(again=True):
        gateway.wait_for_alarm("bus_silent", "cleared")
    return f"invalid after {told_s:.1f} s; {gateway.assert_sound(alarms=['bus_silent'])}"


@fault("100 % load of unmapped frames (4000 a second)", "the kernel keeps them out: none is seen, none is dropped")
def foreign_load(gateway: Gateway) -> str:
    with gateway.driving():
        before = gateway.health()
        with gateway.frames_on_the_wire("unmapped", "4000"):
            time.sleep(8.0)
            gateway.wait_for_estimate(time.monotonic(), {"valid"})
        after = gateway.health()
    strangers = (after["frames"] - after["mapped_frames"]) - (before["frames"] - before["mapped_frames"])
    assert (strangers, after["dropped_frames"]) == (0, before["dropped_frames"])
    return f"0 of them seen, 0 frames dropped; {gateway.assert_sound()}"


@fault("error frames", "alarm bus_fault, which clears; estimates stay valid")
def error_frames(gateway: Gateway) -> str:
    with gateway.driving():
        with gateway.frames_on_the_wire("errors", "20"):
            gateway.wait_for_alarm("bus_fault", "open")
            gateway.wait_for_estimate(time.monotonic(), {"valid"})
        gateway.wait_for_alarm("bus_fault", "cleared")
    return gateway.assert_sound(alarms=["bus_fault"])


@fault(
    "malformed frames: wrong lengths, remote, CAN FD, impossible values",
    "each is counted and not used; estimates go on",
    everyday=True,
)
def malformed(gateway: Gateway) -> str:
    with gateway.driving():
        before = gateway.health()["decode_errors"]
        with gateway.frames_on_the_wire("malformed", "100"):
            gateway.wait_for(lambda: gateway.health()["decode_errors"] - before > 300, "counted")
            gateway.wait_for_estimate(time.monotonic())
        counted = gateway.health()["decode_errors"] - before
        gateway.wait_for_estimate(time.monotonic(), {"valid"})
    return f"{counted} counted; {gateway.assert_sound()}"


GAPS_S = {0x120: (8.0, 13.0), 0x1A0: (20.0, 25.0), 0x2A0: (32.0, 37.0), 0x2A1: (44.0, 52.0), 0x320: (56.0, 64.0)}
SANDER_GAP_S = (70.0, 78.0)
LOST_INPUTS = 6


@fault("each mapped message lost alone, one after the other", "alarm input_lost for each, which clears; no brake alarm")
def messages_lost(gateway: Gateway) -> str:
    def is_missing(time_s: float, frame: Frame) -> bool:
        begin_s, end_s = SANDER_GAP_S if frame.extended else GAPS_S.get(frame.can_id, (0.0, 0.0))
        return begin_s <= time_s < end_s

    with gateway.driving(gateway.log_without("gaps", is_missing)):
        gateway.wait_for(lambda: len(lost_messages(gateway)) == LOST_INPUTS, "each told to be lost")
        open_alarms = len({alarm["id"] for alarm in gateway.alarms()})
        gateway.wait_for(
            lambda: len([a for a in gateway.alarms() if a["state"] == "cleared"]) == open_alarms, "all cleared"
        )
    lost = lost_messages(gateway)
    return f"told: {', '.join(sorted(lost))}; {gateway.assert_sound(alarms=['input_lost'])}"


def lost_messages(gateway: Gateway) -> set[str]:
    """Names of the messages that alarms were raised for."""
    names = ("BCU_Status", "BCU", "WSP", "GNSS_Position", "GNSS", "Sander")
    told = [a["message"] for a in gateway.alarms() if a["kind"] == "input_lost" and a["state"] == "open"]
    return {next(name for name in names if name in message) for message in told}


# -- the clock -----------------------------------------------------------------------------------------------------


@fault("clock set 1 h ahead, then 1 h back", f"valid estimates within {2 * SOON_S:.0f} s, with the new time; no alarm")
def clock_set(gateway: Gateway) -> str:
    gaps_s = []
    with gateway.driving(by_the_clock=False):
        for hours in (1, -1):
            set_clock(time.time() + hours * 3600.0)
            before_s = time.monotonic()
            gaps_s.append(gateway.wait_for_estimate(before_s + 1.0, {"valid"}) + 1.0)
            newest = [s["payload"]["time_s"] for s in gateway.heard if s["key"].endswith("/adhesion")][-1]
            assert abs(newest - time.time()) < 5.0
        gateway.wait_for_estimate(time.monotonic() + 3.0, {"valid"})
        assert not gateway.alarms(), gateway.alarms()
    assert max(gaps_s) < 2 * SOON_S
    return f"valid after {gaps_s[0]:.1f} s and {gaps_s[1]:.1f} s; {gateway.assert_sound()}"


def set_clock(time_s: float) -> None:
    time.clock_settime(time.CLOCK_REALTIME, time_s)


# -- the network ---------------------------------------------------------------------------------------------------


@fault("router gone for 6 s", f"estimates within {SOON_S:.0f} s of its return; every alarm arrives, once and in order")
def router_gone(gateway: Gateway) -> str:
    with gateway.driving():
        gateway.router.__exit__()
        bus_fails(gateway)  # something to tell meanwhile
        time.sleep(6.0)
        before_s = time.monotonic()
        gateway.start_router()
        gap_s = gateway.wait_for_estimate(before_s)
        gateway.wait_for_alarm("bus_fault", "cleared")
    return f"{back(gap_s)}; {gateway.assert_sound(alarms=['bus_fault'])}"


@fault("router frozen for 8 s: partitioned", "every alarm of that time arrives, once and in order; no restart")
def router_frozen(gateway: Gateway) -> str:
    with gateway.driving():
        gateway.router.send_signal(signal.SIGSTOP)
        bus_fails(gateway)
        time.sleep(8.0)
        before_s = time.monotonic()
        gateway.router.send_signal(signal.SIGCONT)
        gap_s = gateway.wait_for_estimate(before_s)
        gateway.wait_for_alarm("bus_fault", "cleared")
    return f"{back(gap_s)}; {gateway.assert_sound(alarms=['bus_fault'])}"


# -- the disk ------------------------------------------------------------------------------------------------------


@fault(
    "disk full",
    "estimates go on, alarm memory_failing; the memory is written again when there is room, then the alarm clears",
    everyday=True,
)
def disk_full(gateway: Gateway) -> str:
    gateway.systemctl("restart")  # what SQLite has written ahead by now would be room enough for a while
    with gateway.driving():
        filler = STATE_MOUNT / "filler"
        try:
            fill_up(filler)
            gateway.wait_for_line("kept in the process and written when that works again")
            gateway.wait_for_estimate(time.monotonic() + 2.0, {"valid"})
            gateway.wait_for_alarm("memory_failing", "open")
        finally:
            filler.unlink()
        gateway.wait_for_line("the memory is written again")
        gateway.wait_for_alarm("memory_failing", "cleared")
    return gateway.assert_sound(alarms=["memory_failing"])


def fill_up(filler: Path) -> None:
    """Write until the disk is full; unbuffered, for what a buffer still held would fail once more at the close."""
    with filler.open("wb", buffering=0) as stream:
        try:
            while True:
                stream.write(bytes(1 << 16))
        except OSError as error:
            if error.errno != errno.ENOSPC:
                raise


@fault(
    "state directory read-only",
    "it starts, says so, and estimates with what it can read; nothing is lost of what was there",
)
def disk_read_only(gateway: Gateway) -> str:
    gateway.systemctl("stop")
    worn = braked_j()
    run("mount", "-o", "remount,ro", STATE_MOUNT)
    try:
        gateway.systemctl("start")
        with gateway.driving(again=True):
            gateway.wait_for_line("kept in the process and written when that works again")
            gateway.wait_for_alarm("memory_failing", "open")
            run("mount", "-o", "remount,rw", STATE_MOUNT)
            assert braked_j() == worn
            # Its own view of the directory stays read-only until then. What it told meanwhile it cannot keep, so that
            # nothing may be open but memory_failing: it drives.
            gateway.systemctl("restart")
            gateway.wait_for_estimate(time.monotonic(), {"valid"})
    finally:
        run("mount", "-o", "remount,rw", STATE_MOUNT)
    return gateway.assert_sound(alarms=["memory_failing"], once=False)


@fault("corrupt database", "it is set aside under another name, a new memory begins; no restart loop", everyday=True)
def database_corrupt(gateway: Gateway) -> str:
    with gateway.driving():  # so that no alarm is open that the lost memory would have had to clear
        gateway.systemctl("stop")
        size = MEMORY.stat().st_size
        with MEMORY.open("r+b") as stream:
            stream.seek(0)
            stream.write(os.urandom(size // 2))
        before_s = time.monotonic()
        gateway.systemctl("start")
        line = gateway.wait_for_line("a new memory begins")
        gap_s = gateway.wait_for_estimate(before_s)
    assert list(STATE_MOUNT.glob("refused-*"))
    assert "refused-" in line
    return f"{back(gap_s)}; {gateway.assert_sound(once=False)}"


def braked_j() -> float:
    """Energy that the pads have taken, as remembered: it only grows."""
    if not MEMORY.exists():
        return 0.0
    with Store.look(MEMORY, "wagon-8127", "ro") as store:
        brakes = store.brakes()
    return 0.0 if brakes is None else sum(unit.pads.since_fitted.energy_j for unit in brakes.units)


# -- the configuration ---------------------------------------------------------------------------------------------


@fault("corrupt configuration on reload", "the reload fails, the same process goes on with the old one", everyday=True)
def reload_of_nonsense(gateway: Gateway) -> str:
    good, process = CONFIG.read_text(), gateway.pid
    try:
        with gateway.driving():
            CONFIG.write_text(good.replace("mass_kg", "mass_lb"))
            refused = run_whatever_comes("systemctl", "reload", SERVICE)
            assert refused.returncode != 0
            gateway.kill(signal.SIGHUP)  # past the unit's own check
            gateway.wait_for_line("the new configuration is refused: .*mass_lb")
            assert re_status("refused") or gateway.wait_for(lambda: re_status("refused"), "told in the status")
            CONFIG.write_text("\x00\xff[")
            gateway.kill(signal.SIGHUP)
            gateway.wait_for_line("the new configuration is refused: .*not valid TOML")
            gateway.wait_for_estimate(time.monotonic(), {"valid"})
            CONFIG.write_text(good)
            before_s = time.monotonic()
            gateway.systemctl("reload")
            gateway.wait_for_line("the new configuration is good")
            gap_s = gateway.wait_for_estimate(before_s + 1.0) + 1.0
    finally:
        CONFIG.write_text(good)
    assert gateway.pid == process
    return f"a good one afterwards is taken over in {gap_s:.1f} s; {gateway.assert_sound()}"


@fault("a braking, and everything at once", "what was promised holds: nothing about the brakes is said")
def everything(gateway: Gateway) -> str:
    with gateway.driving(), ExitStack() as stack:
        stack.enter_context(gateway.frames_on_the_wire("unmapped", "1000"))
        stack.enter_context(gateway.frames_on_the_wire("malformed", "50"))
        for _ in range(3):
            bus_fails(gateway)
            time.sleep(1.0)
        before_s = time.monotonic()
        gateway.kill(signal.SIGKILL)
        gap_s = until_it_estimates_again(gateway, before_s)
    return f"{back(gap_s)}; {gateway.assert_sound(restarts=1)}"


@fault("SIGTERM at random instants, also while it starts", "ends in order before systemd would kill it; wear is kept")
def ended_at_any_time(gateway: Gateway) -> str:
    worn, dice = braked_j(), random.Random(1)
    with gateway.driving():
        begun_s = time.monotonic()
        gateway.systemctl("restart")
        start_s = time.monotonic() - begun_s
        for _ in range(ENDS):
            run("systemctl", "start", "--no-block", SERVICE)
            time.sleep(dice.uniform(0.0, 2.0 * start_s))
            gateway.systemctl("stop")
            assert shown("Result") == "success"
            worn, before = braked_j(), worn
            assert worn >= before
        gateway.systemctl("start")
    return f"{ENDS} ends; {gateway.assert_sound()}"
