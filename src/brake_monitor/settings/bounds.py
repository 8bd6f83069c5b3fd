"""Number types of the settings, with the bounds that the configuration reader enforces."""

from typing import Annotated

from msgspec import Meta

COLDEST_C = -60.0  # the lowest temperature of a wagon and its discs
LARGEST_FRICTION = 0.6  # no pad has more
MOST_WHEELSETS = 32  # of a transporter of 800 t

Positive = Annotated[float, Meta(gt=0.0)]
NonNegative = Annotated[float, Meta(ge=0.0)]
Wait = Annotated[float, Meta(ge=0.0, le=86400.0)]  # s: an alarm that is later than a day is none
TimeOut = Annotated[float, Meta(gt=0.0, le=86400.0)]  # s: what may be a day old is as good as never lost
Speed = Annotated[float, Meta(ge=0.0, le=200.0)]  # m/s, beyond what trains on wheels have reached
Friction = Annotated[float, Meta(gt=0.0, le=LARGEST_FRICTION)]  # of a pad on its disc, or how far pads lie apart
Force = Annotated[float, Meta(gt=0.0, le=1e7)]  # N of one brake
Distance = Annotated[float, Meta(gt=0.0, le=1e5)]  # m that a wheelset slides at a stretch
Energy = Annotated[float, Meta(gt=0.0, le=1e9)]  # J that one wheelset takes up in a brake application
Rate = Annotated[float, Meta(ge=0.0, le=1e4)]  # Hz; no bus has more frames a second
Thermal = Annotated[float, Meta(ge=1e-3, le=1e6)]  # kg and J/(kg K) of any disc, W/K of its surface
DiscTemperature = Annotated[float, Meta(gt=0.0, le=1500.0)]  # °C at which cast iron and steel melt
Ambient = Annotated[float, Meta(ge=COLDEST_C, le=80.0)]  # °C in which a wagon runs
Deviation = Annotated[float, Meta(gt=0.0, le=10.0)]  # relative: 0.2 is 20 %, and 20 is meant in per cent
