"""A bogie wagon with sensors as many have them: four wheelsets, no state of the WSP, slow messages in coarse steps.

Wheel speeds come in steps of 0.1 km/h, vehicle speeds of 0.05 m/s, pressures of 0.05 bar.
"""

from pathlib import Path

from brake_monitor.settings.config import Preset, Settings
from brake_monitor.settings.config_file import load_settings

COUNT = 4
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
[estimator]
preset = "PRESET"
[signals]
speed = { message = "SPEED", signal = "v", unit = "m/s", noise_std = 0.02 }
axle_speed = [WHEELS]
pressing_force = [BRAKES]
"""
WHEEL = '{ message = "WHEELS", signal = "n_%d", unit = "km/h", noise_std = 0.036 }'
BRAKE = '{ message = "BRAKES", signal = "p_%d", scale = 18600.0, offset = -4650.0, min = 0.0, noise_std = 50.0 }'


def coarse_bogie(folder: Path, *, wheels_ms: int = 100, pressures_ms: int = 100, preset: Preset = "wagon") -> Settings:
    """Its settings, from files that are written into the folder."""
    cycles = "".join(f'BA_ "GenMsgCycleTime" BO_ {i} {ms};\n' for i, ms in ((257, wheels_ms), (258, pressures_ms)))
    (folder / "coarse.dbc").write_text(DBC + cycles)
    config = CONFIG.replace("PRESET", preset)
    for key, one in (("[WHEELS]", WHEEL), ("[BRAKES]", BRAKE)):
        config = config.replace(key, f"[{', '.join(one % i for i in range(COUNT))}]")
    (folder / "coarse.toml").write_text(config)
    return load_settings(folder / "coarse.toml")
