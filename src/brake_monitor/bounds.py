"""Number types of the settings, with the bounds that the configuration reader enforces."""

from typing import Annotated

from msgspec import Meta

Positive = Annotated[float, Meta(gt=0.0)]
NonNegative = Annotated[float, Meta(ge=0.0)]
