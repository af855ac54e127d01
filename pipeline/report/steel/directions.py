"""Compass words for a direction, as the paper's Table 1 says "leans north"."""

import math
from typing import Literal

Wind = Literal[
    "north", "north-east", "east", "south-east", "south", "south-west", "west", "north-west", "nowhere"
]
_WINDS: tuple[Wind, ...] = (
    *("north", "north-east", "east", "south-east"),
    *("south", "south-west", "west", "north-west"),
)


def wind(azimuth_deg: float) -> Wind:
    """The nearest of the eight winds to an azimuth, clockwise from north; "nowhere" where it is NaN."""
    if not math.isfinite(azimuth_deg):
        return "nowhere"
    return _WINDS[round(azimuth_deg / 45) % 8]


def north_east_axes(north_deg: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Unit vectors (x, y) of north and east in the site frame; ``north_deg`` is clockwise from +y."""
    turn = math.radians(north_deg)
    return (math.sin(turn), math.cos(turn)), (math.cos(turn), -math.sin(turn))
