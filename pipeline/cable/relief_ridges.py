"""Ridges: long, narrow, helical, such as the fillets that keep rain from running down a stay cable.

Takes the map of heights; finds the straight lines of the unrolled cable along which it stands out of its
noise (:mod:`pipeline.cable.relief_lines`), follows each crest, and averages the profile across it along
the line (:mod:`pipeline.cable.relief_profile`).  What is shorter than half of the map is left to
:mod:`pipeline.cable.relief_spots`.
"""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray

from pipeline.cable.relief_lines import Lines
from pipeline.cable.relief_map import HeightMap
from pipeline.cable.relief_profile import HALF_MM, Profile
from pipeline.core.vocabulary import Array

_MOST = 12
_PIECES = 6  # a crest is measured in so many pieces as well: their scatter tells its sigma
_FOOT = 0.05  # of the height: where the ridge begins


@dataclass(frozen=True, kw_only=True)
class Ridge:
    """One ridge.

    Attributes:
        crest: (3,) azimuth of the crest, rad, as a polynomial in (y - middle) mm.
        middle_mm: position where that has its origin.
        height_mm, sigma_mm: of the crest.
        width_mm: across the ridge, at right angles to it, between its feet as the map shows them: up to a
            window wider than they are.
        length_mm: along the cable, where it is seen.
    """

    crest: Array
    middle_mm: float
    height_mm: float
    sigma_mm: float
    width_mm: float
    length_mm: float

    def azimuth(self, y_mm: Array | float) -> Array:
        """Azimuth of the crest, rad."""
        return np.asarray(polynomial.polyval(np.asarray(y_mm) - self.middle_mm, self.crest))


def find_ridges(
    heights: HeightMap, smooth_mm: Array, level_mm: Array, window_mm: float
) -> tuple[tuple[Ridge, ...], NDArray[np.bool_]]:
    """All ridges, the highest first, and the cells (n, m) that they cover.

    Args:
        heights: the map.
        smooth_mm: (n, m) the same, smoothed.
        level_mm: (n,) what stands out exceeds this.
        window_mm: side of the window that the map was matched with.
    """
    lines = Lines(heights, smooth_mm, level_mm)
    taken = np.zeros(smooth_mm.shape, dtype=bool)
    ridges: list[Ridge] = []
    while len(ridges) < _MOST and (line := lines.best(taken)) is not None:
        crest = _followed(heights, np.array([*line, 0.0]), taken)
        ridge = _measured(heights, crest, taken, float(np.median(level_mm)), window_mm)
        slant = np.cos(np.arctan(heights.radius_mm * crest[1]))
        band = np.abs(_across(heights, crest)) * slant < max(ridge.width_mm / 2 + 2.0, 4.0)
        taken |= band
        if np.isfinite(ridge.height_mm):
            ridges.append(ridge)
    return tuple(sorted(ridges, key=lambda r: -r.height_mm)), taken


def _across(heights: HeightMap, crest: Array) -> Array:
    """Arc (n, m) from the crest to every cell, the short way."""
    at = polynomial.polyval(heights.y_mm - heights.y_mm.mean(), crest)
    away = heights.azimuth[None, :] - at[:, None]
    return np.asarray((np.mod(away + np.pi, 2 * np.pi) - np.pi) * heights.radius_mm)


def _followed(heights: HeightMap, crest: Array, taken: NDArray[np.bool_]) -> Array:
    """The line laid onto the crest: Gauss-Newton steps that fit the mean profile to the map."""
    half = max(float(np.ptp(heights.y_mm)) / 2, 1.0)
    part = (heights.y_mm - heights.y_mm.mean()) / half
    for order in (1, 1, 2, 2, 2):
        across, values, rows = _near(heights, crest, taken)
        profile = Profile.of(across, values)
        slope = np.gradient(profile.height_mm, profile.across_mm)
        design = -np.interp(across, profile.across_mm, slope)[:, None] * part[rows, None] ** np.arange(1, 3)
        design = design[:, :order]
        miss = values - np.interp(across, profile.across_mm, profile.height_mm)
        limit = max(4 * 1.4826 * float(np.median(np.abs(miss))), 0.05)
        miss = np.clip(miss, -limit, limit)
        square = design.T @ design
        shift_mm = np.linalg.solve(square + 1e-9 * np.trace(square) * np.eye(order), design.T @ miss)
        move = np.zeros(3)
        move[0] = profile.crest_mm()
        move[1 : order + 1] = shift_mm / half ** np.arange(1, order + 1)
        crest = crest + move / heights.radius_mm
    return crest


def _near(
    heights: HeightMap, crest: Array, taken: NDArray[np.bool_]
) -> tuple[Array, Array, NDArray[np.intp]]:
    """Arc from the crest, height and row of the measured cells near it."""
    across = _across(heights, crest)
    use = (np.abs(across) < HALF_MM) & np.isfinite(heights.height_mm) & ~taken
    return across[use], heights.height_mm[use], np.nonzero(use)[0]


def _measured(
    heights: HeightMap, crest: Array, taken: NDArray[np.bool_], level_mm: float, window_mm: float
) -> Ridge:
    across, values, rows = _near(heights, crest, taken)
    across = across * np.cos(np.arctan(heights.radius_mm * crest[1]))
    profile = Profile.of(across, values)
    top, sigma = profile.top_mm()
    place = heights.y_mm[rows]
    edges = np.linspace(heights.y_mm[0], heights.y_mm[-1], _PIECES + 1)[1:-1]
    pieces = np.digitize(place, edges)
    tops = []
    for piece in range(_PIECES):
        mine = pieces == piece
        if np.sum(np.abs(across[mine]) < profile.width_mm(top / 2) / 2) >= 50:
            tops.append(Profile.of(across[mine], values[mine]).top_mm()[0])
    scatter = float(np.std(tops, ddof=1) / np.sqrt(len(tops))) if len(tops) > 1 else 0.0
    seen = place[(np.abs(across) < profile.width_mm(top / 2)) & (values > level_mm)]
    # a sweep that follows relief from below flattens between not at all and as much as once more
    most = profile.flattened_mm(window_mm)
    return Ridge(
        crest=crest,
        middle_mm=float(heights.y_mm.mean()),
        height_mm=top + most / 2,
        sigma_mm=float(np.sqrt(sigma**2 + scatter**2 + heights.wave_mm**2 + most**2 / 12)),
        width_mm=profile.width_mm(_FOOT * top),
        length_mm=float(np.ptp(seen)) if len(seen) else 0.0,
    )
