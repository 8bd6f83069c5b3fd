"""Number types of the settings, with the bounds that the configuration reader enforces."""

from typing import Annotated

from msgspec import Meta

Positive = Annotated[float, Meta(gt=0.0)]
NonNegative = Annotated[float, Meta(ge=0.0)]
Deviation = Annotated[float, Meta(gt=0.0, le=10.0)]  # relative: 0.2 is 20 %, and 20 was meant to be
