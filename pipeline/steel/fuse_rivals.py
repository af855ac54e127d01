"""Which of several placements of a photo cloud most points agree with, and whether that is clear.

Takes clouds laid onto the scan from different starts; gives the best.  Leaves out laying them
(:mod:`pipeline.steel.point_match`).
"""

import numpy as np

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array
from pipeline.steel.fuse_records import FuseOptions
from pipeline.steel.fuse_sigma import Held
from pipeline.steel.fuse_start import STAGE
from pipeline.steel.point_match import TUKEY, Laid


def best_laid(
    tried: list[tuple[Laid, Held, int]], points: Array, options: FuseOptions
) -> tuple[Laid, Held, int]:
    """The placement that most points agree with.

    Args:
        tried: each cloud as laid, what holds it, and the number of its start.
        points: (n, 3) of the photo cloud.
        options: see there.

    Raises:
        StageError: too few agree, or as many with another one.
    """
    noise_m = min((item[0].noise_m for item in tried if len(item[0].chosen) >= 200), default=1.0)
    best = max(tried, key=lambda item: _merit(item[0], noise_m))
    if best[0].share < options.least_overlap or len(best[0].chosen) < 200:
        raise StageError(
            STAGE,
            f"only {100 * best[0].share:.0f} % of the photo cloud lie on scanned surface",
            "check that both show the same part, or give pairs of places by hand",
        )
    _refuse_rivals(tried, best, noise_m, points, options)
    return best


def _merit(laid: Laid, noise_m: float) -> float:
    """Photo points on the surface, each by its robust weight at the same noise for all rivals."""
    return float(np.sum(np.clip(1 - (laid.distances / (TUKEY * noise_m)) ** 2, 0, None) ** 2))


def _refuse_rivals(
    laid_all: list[tuple[Laid, Held, int]],
    best: tuple[Laid, Held, int],
    noise_m: float,
    points: Array,
    options: FuseOptions,
) -> None:
    mine = best[0].placement.apply(points)
    for laid, _, number in laid_all:
        apart = float(np.sqrt(np.mean(np.sum((laid.placement.apply(points) - mine) ** 2, axis=1))))
        if (
            number != best[2]
            and apart > 5 * options.feature_tolerance_mm / 1000
            and _merit(laid, noise_m) > 0.9 * _merit(best[0], noise_m)
        ):
            raise StageError(
                STAGE,
                f"the structure looks alike in two places {apart:.1f} m apart, so the photos fit in both",
                "give three pairs of places by hand",
            )
