"""How many times larger small things are drawn: one round factor a figure."""

import math
from collections.abc import Iterable


def round_factor(largest_mm: float, wanted_m: float) -> int:
    """The largest of 1, 2, 5, 10, 20, ... that draws ``largest_mm`` at most ``wanted_m`` long.

    1 where nothing is to be drawn.
    """
    if not (math.isfinite(largest_mm) and largest_mm > 0 and wanted_m > 0):
        return 1
    raw = 1000 * wanted_m / largest_mm
    if raw < 1:
        return 1
    power = 10 ** math.floor(math.log10(raw))
    return int(next(step * power for step in (5, 2, 1) if step * power <= raw * (1 + 1e-9)))


def largest(values: Iterable[float]) -> float:
    """Largest finite value, 0 where there is none."""
    return max((value for value in values if math.isfinite(value)), default=0.0)
