"""A bogie wagon whose sensors are coarse and whose WSP tells nothing: its sensors' faults are still no brake's.

Wheel speeds come ten times a second in steps of 0.1 km/h, vehicle speeds in steps of 0.05 m/s, pressures of 0.05 bar.
"""

from pathlib import Path

import pytest

from brake_monitor.config_file import load_settings
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.pipeline import Pipeline
from brake_monitor.simulator.simulate import EPOCH_S, run
from brake_monitor.simulator.troubles import ROW_S, TROUBLES

COUNT, SECONDS = 4, 95.0
WHEELS = "\n".join(f' SG_ n_{i} : {16 * i}|16@1- (0.1,0) [-400|400] "km/h" X' for i in range(COUNT))
PRESSURES = "\n".join(f' SG_ p_{i} : {8 * i}|8@1+ (0.05,0) [0|12] "bar" X' for i in range(COUNT))
DBC = f"""VERSION ""
BU_: S X
BO_ 256 SPEED: 8 S
 SG_ v : 0|16@1+ (0.05,0) [0|100] "m/s" X
BO_ 257 WHEELS: 8 S
{WHEELS}
BO_ 258 BRAKES: 8 S
{PRESSURES}
BA_DEF_ BO_ "GenMsgCycleTime" INT 0 60000;
BA_DEF_DEF_ "GenMsgCycleTime" 100;
"""
CONFIG = """
[vehicle]
id = "coarse"
mass_kg = 72000.0
axle_positions_m = [7.9, 6.1, -6.1, -7.9]
cog_height_m = 1.6
wheelset_inertia_kgm2 = 118.0
wheel_radius_m = 0.445
brake_radius_m = 0.247
track_resistance_n = 1800.0
drag_n_per_mps2 = 2.6
[can]
interface = "socketcan"
channel = "can0"
dbc = ["coarse.dbc"]
[signals]
speed = { message = "SPEED", signal = "v", unit = "m/s", noise_std = 0.02 }
axle_speed = [WHEELS]
pressing_force = [BRAKES]
"""
WHEEL = '{ message = "WHEELS", signal = "n_%d", unit = "km/h", noise_std = 0.036 }'
BRAKE = '{ message = "BRAKES", signal = "p_%d", scale = 18600.0, offset = -4650.0, min = 0.0, noise_std = 50.0 }'


def alarms(name: str, folder: Path) -> list[Alarm]:
    """Of the trouble's first two brakings, as they were raised."""
    (folder / "coarse.dbc").write_text(DBC)
    lists = {key: ", ".join(one % i for i in range(COUNT)) for key, one in (("WHEELS", WHEEL), ("BRAKES", BRAKE))}
    config = CONFIG.replace("[WHEELS]", f"[{lists['WHEELS']}]").replace("[BRAKES]", f"[{lists['BRAKES']}]")
    (folder / "coarse.toml").write_text(config)
    trouble, settings = TROUBLES[name], load_settings(folder / "coarse.toml")
    frames = run(trouble.scenario, trouble.settings(settings), 1, trouble.modifiers, row_s=ROW_S).frames
    pipeline = Pipeline.from_settings(settings)
    until = [frame for frame in frames if frame.time_s < EPOCH_S + SECONDS]
    return [alarm for frame in until for alarm in pipeline.step(frame).alarms]


@pytest.mark.parametrize("name", ["frozen-pressure", "pressure-stuck"])
def test_a_pressure_that_stands_is_the_sensors_fault(name: str, tmp_path: Path) -> None:
    raised = alarms(name, tmp_path)
    assert {(alarm.kind, alarm.wheelset) for alarm in raised} == {("input_implausible", 1)}


def test_a_brake_that_never_fills_is_the_brakes_fault(tmp_path: Path) -> None:
    raised = alarms("unapplied", tmp_path)
    assert {(alarm.kind, alarm.wheelset) for alarm in raised} == {("brake_not_applied", 1)}
