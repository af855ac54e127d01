"""Ridges: long, narrow, helical, such as the fillets that keep rain from running down a stay cable.

Takes the map of heights; finds the straight lines of the unrolled cable along which it stands out of its
noise (a Radon transform of the periodic map), follows each crest, and averages the profile across it along
the line.  What is shorter than half of the map is left to :mod:`pipeline.cable.relief_spots`.
"""

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray

from pipeline.cable.relief_map import HeightMap
from pipeline.core.vocabulary import Array

_COARSE_MM = (4.0, 2.0)  # along and around: lines are looked for in a copy of the map so coarse
_LEAST_SHARE = 0.6  # of the line's measured cells stand out
_LEAST_LENGTH = 0.5  # of the map's length must be measured along the line
_LEAST_PITCH_MM = 100.0
_HALF_MM = 16.0  # of the profile across
_STEP_MM = 0.5
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
    lines = _Lines(heights, smooth_mm, level_mm)
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


class _Lines:
    """Sums along all straight lines of the unrolled map, over a coarse copy of it, by the shift theorem."""

    def __init__(self, heights: HeightMap, smooth_mm: Array, level_mm: Array) -> None:
        sides = zip(_COARSE_MM, heights.cell_mm, strict=True)
        self._rows, self._columns = (slice(None, None, max(round(c / side), 1)) for c, side in sides)
        self._smooth = smooth_mm[self._rows, self._columns]
        self._out = self._smooth > level_mm[self._rows, None]
        y = heights.y_mm[self._rows]
        self._y = y - heights.y_mm.mean()
        self._azimuth = heights.azimuth[self._columns]
        # so fine that the best line stays within 1.5 mm of the true one
        step = 6.0 / (heights.radius_mm * max(float(np.ptp(y)), 1.0))
        most = int(2 * np.pi / _LEAST_PITCH_MM / step)
        self._slopes = step * np.arange(-most, most + 1)
        self._known: NDArray[np.floating] | None = None

    def best(self, taken: NDArray[np.bool_]) -> tuple[float, float] | None:
        """Azimuth in the middle (rad) and slope (rad/mm) of the line that stands out most, or None."""
        out = self._out & ~taken[self._rows, self._columns]
        least = _LEAST_LENGTH * len(self._y)
        if out.sum() < _LEAST_SHARE * least:
            return None
        if self._known is None:
            self._known = self._sums(np.isfinite(self._smooth)).real
        sums = self._sums(out * (1 + 1j * np.nan_to_num(self._smooth)))
        known: NDArray[np.floating] = np.maximum(self._known, 1e-9)
        good = (known >= least) & (sums.real >= _LEAST_SHARE * known)
        if not good.any():
            return None
        slope, column = np.unravel_index(int(np.argmax(np.where(good, sums.imag / known, -1))), good.shape)
        return float(self._azimuth[column]), float(self._slopes[slope])

    def _sums(self, values: NDArray[Any]) -> NDArray[np.complexfloating]:
        """(slopes, columns) of the sums along the lines through each column of the middle row."""
        spectrum = np.fft.fft(values, axis=1).astype(np.complex64)
        sums = np.empty((len(self._slopes), spectrum.shape[1]), dtype=np.complex64)
        turn = np.exp(1j * np.outer(self._slopes, self._y)).astype(np.complex64)
        phase = np.ones_like(turn)
        for frequency in range(spectrum.shape[1] // 2 + 1):
            sums[:, frequency] = phase @ spectrum[:, frequency]
            sums[:, -frequency] = phase.conj() @ spectrum[:, -frequency]
            phase *= turn
        return np.fft.ifft(sums, axis=1)


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
        profile = _Profile.of(across, values)
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
    use = (np.abs(across) < _HALF_MM) & np.isfinite(heights.height_mm) & ~taken
    return across[use], heights.height_mm[use], np.nonzero(use)[0]


@dataclass(frozen=True, kw_only=True)
class _Profile:
    """Mean heights (k,) over distances across the ridge (k,), with their standard deviations (k,)."""

    across_mm: Array
    height_mm: Array
    sigma_mm: Array

    @staticmethod
    def of(across: Array, values: Array) -> "_Profile":
        """Mean of the middle half of each step's cells, as good as the median and finer."""
        edges = np.arange(-_HALF_MM, _HALF_MM + _STEP_MM / 2, _STEP_MM)
        order = np.lexsort((values, np.digitize(across, edges)))
        bounds = np.searchsorted(np.digitize(across, edges)[order], np.arange(1, len(edges) + 1))
        mean, sigma = np.full(len(edges) - 1, np.nan), np.full(len(edges) - 1, np.nan)
        for k, (first, last) in enumerate(itertools.pairwise(bounds)):
            sample = values[order[first:last]]
            if len(sample) >= 4:
                quarter = len(sample) // 4
                mean[k] = sample[quarter : len(sample) - quarter].mean()
                # the windows of the dense step overlap: some six cells of a line say one thing
                sigma[k] = 1.4826 * np.median(np.abs(sample - mean[k])) * np.sqrt(6 / len(sample))
        middle = (edges[:-1] + edges[1:]) / 2
        good = np.isfinite(mean)
        if not good.any():
            return _Profile(across_mm=middle, height_mm=0 * middle, sigma_mm=0 * middle + np.inf)
        return _Profile(
            across_mm=middle,
            height_mm=np.interp(middle, middle[good], mean[good]),
            sigma_mm=np.interp(middle, middle[good], sigma[good]),
        )

    def width_mm(self, level_mm: float) -> float:
        """Between the places on either side of the crest where the profile falls below the level."""
        low = self.height_mm < level_mm
        crest = int(np.argmin(np.abs(self.across_mm - self.crest_mm())))
        left, right = np.flatnonzero(low[:crest]), np.flatnonzero(low[crest:])
        begin = self._crossing(left[-1], level_mm) if len(left) else self.across_mm[0]
        end = self._crossing(crest + right[0] - 1, level_mm) if len(right) else self.across_mm[-1]
        return float(end - begin)

    def _crossing(self, k: int, level_mm: float) -> float:
        """Where the profile passes the level between the steps k and k + 1."""
        first, last = self.height_mm[k : k + 2]
        part = (level_mm - first) / (last - first) if last != first else 0.5
        return float(self.across_mm[k] + part * _STEP_MM)

    def crest_mm(self) -> float:
        """Place of the crest: of the upper half of the profile near its middle, by moments."""
        near = np.abs(self.across_mm) < _HALF_MM / 2
        excess = np.where(near, self.height_mm, 0.0)
        excess = np.clip(excess - excess.max() / 2, 0.0, None)
        return float(np.sum(excess * self.across_mm) / max(float(excess.sum()), 1e-9))

    def top_mm(self) -> tuple[float, float]:
        """Height of the crest and its sigma: a polynomial of fourth order over the ridge's upper part."""
        crest = self.crest_mm()
        reach = max(0.8 * self.width_mm(self.height_mm.max() / 2) / 2, 2 * _STEP_MM)
        near = np.abs(self.across_mm - crest) <= reach
        order = min(4, int(near.sum()) - 1) // 2 * 2
        design = ((self.across_mm[near] - crest) / reach)[:, None] ** np.arange(order + 1)
        weight = 1 / np.maximum(self.sigma_mm[near], 1e-3)
        inverse = np.linalg.pinv(design * weight[:, None])
        return float(inverse[0] @ (self.height_mm[near] * weight)), float(np.linalg.norm(inverse[0]))


def _measured(
    heights: HeightMap, crest: Array, taken: NDArray[np.bool_], level_mm: float, window_mm: float
) -> Ridge:
    across, values, rows = _near(heights, crest, taken)
    across = across * np.cos(np.arctan(heights.radius_mm * crest[1]))
    profile = _Profile.of(across, values)
    top, sigma = profile.top_mm()
    place = heights.y_mm[rows]
    edges = np.linspace(heights.y_mm[0], heights.y_mm[-1], _PIECES + 1)[1:-1]
    pieces = np.digitize(place, edges)
    tops = []
    for piece in range(_PIECES):
        mine = pieces == piece
        if np.sum(np.abs(across[mine]) < profile.width_mm(top / 2) / 2) >= 50:
            tops.append(_Profile.of(across[mine], values[mine]).top_mm()[0])
    scatter = float(np.std(tops, ddof=1) / np.sqrt(len(tops))) if len(tops) > 1 else 0.0
    seen = place[(np.abs(across) < profile.width_mm(top / 2)) & (values > level_mm)]
    flat = _flattened(profile, window_mm)
    return Ridge(
        crest=crest,
        middle_mm=float(heights.y_mm.mean()),
        height_mm=top + flat,
        sigma_mm=float(np.sqrt(sigma**2 + scatter**2 + heights.wave_mm**2 + (flat / 2) ** 2)),
        width_mm=profile.width_mm(_FOOT * top),
        length_mm=float(np.ptp(seen)) if len(seen) else 0.0,
    )


def _flattened(profile: _Profile, window_mm: float) -> float:
    """How much a window of that side would take off the crest if it were laid over it once more.

    To first order what it has taken off already (van Cittert 1931, one step); how far the map was really
    flattened hangs on the texture, so half of it goes into sigma.
    """
    steps = round(window_mm / _STEP_MM) | 1
    if steps < 2:
        return 0.0
    again = np.convolve(profile.height_mm, np.ones(steps) / steps, mode="same")
    crest = int(np.argmin(np.abs(profile.across_mm - profile.crest_mm())))
    return float(max(profile.height_mm[crest] - again[crest], 0.0))
