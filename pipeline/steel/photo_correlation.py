"""Windows of a photo compared with another photo's, candidate by candidate, and the best candidate kept.

Takes grey pictures and where to look; gives normalised cross-correlations and the place of their summit.
Leaves out where another photo sees a cell (photo_depth.py).
"""

import cv2
import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.float32]
NOISE_GREY = 2.0
"""Contrast of a window below which it says nothing, grey values."""
OUTSIDE = -1e3


def sample(image: Image, columns: Image, rows: Image) -> Image:
    """Values at places counted from the first pixel's centre, linear between pixels; OUTSIDE beyond them."""
    return np.asarray(
        cv2.remap(image, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=OUTSIDE)
    )


class Template:
    """The photo's own windows, ready to be correlated."""

    def __init__(self, image: Image, window: int) -> None:
        self._window = (window, window)
        self._image = image
        self._mean = self._box(image)
        self._variance = np.maximum(self._box(image * image) - self._mean**2, 0)
        self.textured = self._variance > NOISE_GREY**2

    def correlate(self, other: Image) -> Image:
        """Normalised cross-correlation of every window; -1 where part of it is outside the neighbour."""
        mean = self._box(other)
        variance = np.maximum(self._box(other * other) - mean**2, 0)
        product = self._box(self._image * other) - self._mean * mean
        score = product / np.sqrt(self._variance * variance + np.float32(NOISE_GREY**2))
        # a value of OUTSIDE anywhere in the window makes a variance that no picture has
        return np.where((variance > 128**2) | (mean < -200), np.float32(-1), score)

    def _box(self, image: Image) -> Image:
        return np.asarray(cv2.boxFilter(image, cv2.CV_32F, self._window, borderType=cv2.BORDER_REFLECT))


class Peak:
    """The best score of every cell so far, with those beside it."""

    def __init__(self, shape: tuple[int, ...]) -> None:
        self._count = 0
        self._best = np.full(shape, -2, dtype=np.float32)
        self._index = np.zeros(shape, dtype=np.int32)
        self._before = np.full(shape, np.nan, dtype=np.float32)
        self._after = np.full(shape, np.nan, dtype=np.float32)
        self._last = np.full(shape, np.nan, dtype=np.float32)

    def add(self, score: Image) -> None:
        """The next candidate."""
        follows = self._index == self._count - 1
        self._after[follows] = score[follows]
        better = score > self._best
        self._best[better], self._before[better] = score[better], self._last[better]
        self._index[better], self._after[better] = self._count, np.nan
        self._last, self._count = score, self._count + 1

    def at(self) -> tuple[Image, Image]:
        """Candidate number at the summit, with a fraction, and the score there; NaN at the ends."""
        bend = self._before - 2 * self._best + self._after
        with np.errstate(invalid="ignore", divide="ignore"):
            shift = np.where(bend < 0, (self._before - self._after) / (2 * bend), np.nan)
            good = np.abs(shift) <= 1
            found = np.where(good, self._index + shift, np.nan)
            height = np.where(good, self._best - bend * shift**2 / 2, np.nan)
        return found.astype(np.float32), height.astype(np.float32)
