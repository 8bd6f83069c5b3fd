"""What `replay --publish` answers, to who asks while it plays."""

import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import zenoh

from network import free_port, session
from program import BRAKE_MONITOR, PATIENCE_S, Program, until

VEHICLES = Path(__file__).parents[2] / "dbc"
BEGIN_S = 1_700_000_000.0


def frames() -> list[str]:
    """Half a minute at 36 km/h, of which the vehicle speed is lost after a second."""
    lines = []
    for k in range(1500):
        stamp = f"({BEGIN_S + k * 0.02:.6f}) can0"
        lines += [f"{stamp} 1A0#100E100E000000{k % 16:02X}", f"{stamp} 120#00000000000000{k % 16:02X}"]
        if k < 50:
            lines.append(f"{stamp} 2A0#D007000000000000")
    return lines


def replies(other: zenoh.Session, key: str, **more: Any) -> list[zenoh.Reply]:
    return list(other.get(f"brake/v1/wagon-8127/{key}", timeout=PATIENCE_S, **more))


def test_nobody_acknowledges_an_alarm_of_a_recording(tmp_path: Path) -> None:
    """Not even where the daemon lets them: nothing would follow."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    shutil.copy(VEHICLES / "wagon.dbc", tmp_path)
    published = f'[zenoh]\nlisten = ["{endpoint}"]\naccept_acknowledgements = true\n'
    config = tmp_path / "wagon.toml"
    config.write_text(f"{(VEHICLES / 'wagon.toml').read_text()}\n{published}")
    (tmp_path / "lost.log").write_text("\n".join(frames()) + "\n")
    arguments = ("replay", "-c", config, tmp_path / "lost.log", "--publish", "--speed", "0.5")
    with Program(BRAKE_MONITOR, *arguments), session(endpoint, "peer") as other:
        until(lambda: replies(other, "alarm/**"))
        told, *_ = (json.loads(reply.ok.payload.to_bytes()) for reply in replies(other, "alarm/**") if reply.ok)
        (reply,) = replies(other, "acknowledge", payload=json.dumps({"id": told["id"]}))
        assert reply.err is not None
        assert reply.err.payload.to_string() == "this is a recording, and what it tells of is over"


def test_it_says_where_it_publishes(tmp_path: Path) -> None:
    """Nobody could guess the port that is taken where none is configured."""
    (tmp_path / "lost.log").write_text("\n".join(frames()) + "\n")
    arguments = ("replay", "-c", VEHICLES / "wagon.toml", tmp_path / "lost.log", "--publish")
    ended = subprocess.run([BRAKE_MONITOR, *arguments], capture_output=True, text=True, check=True, timeout=PATIENCE_S)
    told = re.search(r"^publishing brake/v1/wagon-8127, tcp/127\.0\.0\.1:(\d+)$", ended.stderr, re.MULTILINE)
    assert told is not None, ended.stderr
    assert int(told[1]) > 0
