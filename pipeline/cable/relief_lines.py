"""Straight lines of the unrolled cable along which a map of heights stands out of its noise.

Takes the map of heights; gives the line that stands out most, by a Radon transform of the periodic map.
Leaves out the shape of what lies along it (:mod:`pipeline.cable.relief_ridges`).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.cable.relief_map import HeightMap
from pipeline.core.vocabulary import Array

_COARSE_MM = (4.0, 2.0)  # along and around: lines are looked for in a copy of the map so coarse
_LEAST_SHARE = 0.6  # of the line's measured cells stand out
_LEAST_LENGTH = 0.5  # of the map's length must be measured along the line
_LEAST_PITCH_MM = 100.0


class Lines:
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
