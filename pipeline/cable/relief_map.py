"""The map of heights over the base, smoothed where it was measured, and its noise.

Pure functions on arrays; the map closes around the cable.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from pipeline.core.vocabulary import Array

_LEAST_WEIGHT = 0.25  # of a Gaussian's weight must lie on measured cells


@dataclass(frozen=True, kw_only=True)
class HeightMap:
    """Heights over the base on the unrolled cable.

    Attributes:
        azimuth: (m,) radians, evenly spaced, the full turn, seen from the base's centre.
        y_mm: (n,) evenly spaced.
        height_mm: (n, m), NaN where not measured.
        radius_mm: of the base, mean: gives arc lengths.
        wave_mm: standard deviation of the map over large areas.
    """

    azimuth: Array
    y_mm: Array
    height_mm: Array
    radius_mm: float
    wave_mm: float

    @property
    def cell_mm(self) -> tuple[float, float]:
        """Side of a cell along the cable and around it."""
        return float(self.y_mm[1] - self.y_mm[0]), float(self.azimuth[1] - self.azimuth[0]) * self.radius_mm

    def arc_mm(self, azimuth: Array | float) -> Array:
        """Arc (m,) from an azimuth to the cells' columns, the short way."""
        return np.asarray(np.angle(np.exp(1j * (self.azimuth - azimuth))) * self.radius_mm)


def smoothed(heights: HeightMap, sigma_mm: float) -> Array:
    """The map averaged by a Gaussian over its measured cells, (n, m); NaN where too few of them are near."""
    sigma = [sigma_mm / side for side in heights.cell_mm]
    known = np.isfinite(heights.height_mm)
    mode: tuple[Literal["nearest"], Literal["wrap"]] = ("nearest", "wrap")
    weight = ndimage.gaussian_filter(known.astype(np.float32), sigma, mode=mode)
    total = ndimage.gaussian_filter(
        np.where(known, heights.height_mm, 0.0).astype(np.float32), sigma, mode=mode
    )
    enough = weight > _LEAST_WEIGHT
    return np.where(enough, total / np.where(enough, weight, 1.0), np.nan).astype(np.float64)


def noise_of_rows(smooth_mm: Array, rows: int) -> Array:
    """Standard deviation (n,) of a smoothed map near each row, from its bulk: the ends are noisier.

    Args:
        smooth_mm: (n, m).
        rows: so many rows are taken together.
    """
    n = len(smooth_mm)
    starts = np.arange(0, n, rows)
    away = np.abs(smooth_mm)
    found = np.full(len(starts), np.nan)
    for index, start in enumerate(starts):
        part = away[start : start + rows]
        part = part[np.isfinite(part)]
        if len(part):
            found[index] = 1.4826 * np.median(part)
    good = np.isfinite(found)
    if not good.any():
        return np.full(n, np.inf)
    return np.interp(np.arange(n), starts[good] + rows / 2, found[good])


def regions(mask: NDArray[np.bool_]) -> tuple[NDArray[np.int32], int]:
    """Connected regions of a mask (n, m) that closes around: labels from 1, and their number."""
    labels, count = ndimage.label(mask, structure=np.ones((3, 3)))
    parent = list(range(count + 1))

    def root(label: int) -> int:
        while parent[label] != label:
            label = parent[label]
        return label

    left, right = labels[:, 0], labels[:, -1]
    for shift in (-1, 0, 1):
        for a, b in zip(left, np.roll(right, shift), strict=True):
            if a and b and root(a) != root(b):
                parent[max(root(a), root(b))] = min(root(a), root(b))
    _, joined = np.unique([root(label) for label in range(count + 1)], return_inverse=True)
    return joined[labels].astype(np.int32), int(joined.max(initial=0))
