"""What our figures have in common: a quiet style, and Okabe and Ito's colours, which colour-blind people tell apart."""

from typing import Any

BLUE, VERMILION, GREEN, PURPLE, SKY, ORANGE = "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00"
DARK = "#222222"

STYLE: dict[Any, Any] = {  # for matplotlib's rc_context
    "font.size": 10.0,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "legend.fontsize": 9.0,
}
