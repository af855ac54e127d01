"""Long smooth edges through a picture, traced by dynamic programming.

Takes a colour image in which the edges run roughly along x; gives, for each row of the middle, the strength
of the best trace through it.  Leaves out which traces are the cable's (:mod:`pipeline.cable.silhouette`).
"""

from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d

from pipeline.core.vocabulary import Array

STRIPES = 24
"""Stripes along the cable in which an edge is traced."""
SATURATION = 8.0
"""Steps count little more beyond this: one glaring spot must not decide the trace."""
BEND = 0.05
"""Cost of stepping a trace by one pixel (squared) from one stripe to the next, in units of a step."""
LEAST_STEPS = (0.5, 0.5, 0.5, 0.1)
"""Steps of brightness, two colour differences (grey levels) and log roughness in even a clean picture."""


def slopes_down(channel: NDArray[np.float32], blur: float) -> NDArray[np.float32]:
    """Derivative of a Gaussian down the columns, scaled so that an ideal step gives its height."""
    x = np.arange(-int(np.ceil(4 * blur)), int(np.ceil(4 * blur)) + 1)
    kernel = x / blur**2 * np.exp(-0.5 * (x / blur) ** 2)
    return cv2.sepFilter2D(
        np.ascontiguousarray(channel), cv2.CV_32F, np.ones(1), kernel, borderType=cv2.BORDER_REPLICATE
    )


def step_strength(colour: NDArray[np.float32], blur: float) -> Array:
    """Size of the steps in each stripe, (STRIPES, h), in units of what texture and noise make."""
    blue, green, red = cv2.split(colour)
    grey = cv2.cvtColor(colour, cv2.COLOR_BGR2GRAY)
    high = np.abs(grey - cv2.GaussianBlur(grey, (0, 0), blur))
    rough = np.log1p(cv2.blur(high, (max(int(colour.shape[1] / STRIPES), 1), max(int(2 * blur), 1))))
    columns = np.linspace(0, colour.shape[1], STRIPES + 1).astype(int)
    total = np.zeros((STRIPES, colour.shape[0]))
    channels = (grey, blue - red, green - (red + blue) / 2, rough)
    for channel, least, wide in zip(channels, LEAST_STEPS, (1, 1, 1, 2), strict=True):
        slopes = slopes_down(channel, wide * blur)
        steps = np.array([slopes[:, a:b].mean(axis=1) for a, b in pairwise(columns)])
        total += (steps / max(float(np.percentile(np.abs(steps), 80)), least)) ** 2
    strength = np.sqrt(total)
    return np.minimum(strength, SATURATION) + 0.02 * np.minimum(strength, 10 * SATURATION)


@dataclass(frozen=True, kw_only=True)
class Traces:
    """Best traces through each row of the middle stripe: strength (h,), and how to walk along them."""

    strength: Array
    forward: Array
    backward: Array
    bend: Array

    def through(self, row: int) -> Array:
        """Rows (STRIPES,) of the best trace through a row of the middle stripe, centres of pixels."""
        middle = len(self.forward) // 2
        rows = np.zeros(len(self.forward), dtype=int)
        rows[middle] = row
        for s in range(middle - 1, -1, -1):
            rows[s] = self._step(self.forward[s], rows[s + 1])
        for s in range(middle + 1, len(rows)):
            rows[s] = self._step(self.backward[s], rows[s - 1])
        return rows + 0.5

    def _step(self, scores: Array, row: int) -> int:
        reach = len(self.bend) // 2
        low, high = max(row - reach, 0), min(row + reach + 1, len(scores))
        return low + int(np.argmax(scores[low:high] + self.bend[low - row + reach : high - row + reach]))


def trace_rows(strength: Array, scale: float) -> Traces:
    """Dynamic programming from both sides to the middle stripe."""
    reach = max(round(7 * scale), 2)
    bend = -BEND / scale**2 * np.arange(-reach, reach + 1.0) ** 2
    count, middle = len(strength), len(strength) // 2
    forward, backward = strength.copy(), strength.copy()
    for s in range(1, count):
        forward[s] += _spread(forward[s - 1], bend)
        backward[count - 1 - s] += _spread(backward[count - s], bend)
    through = (forward[middle] + backward[middle] - strength[middle]) / count
    return Traces(strength=through, forward=forward, backward=backward, bend=bend)


def _spread(scores: Array, bend: Array) -> Array:
    """Best of the neighbouring rows' scores less the cost of stepping there."""
    reach = len(bend) // 2
    padded = np.pad(scores, reach, constant_values=-np.inf)
    return np.max(np.lib.stride_tricks.sliding_window_view(padded, len(bend)) + bend, axis=1)


def peaks(strength: Array, apart: int) -> list[int]:
    """Rows that are strongest within ``apart`` rows on either side, at least half of that from the border."""
    wide = maximum_filter1d(strength, 2 * apart + 1, mode="nearest")
    rows = np.flatnonzero(strength >= wide)
    return [int(row) for row in rows if apart // 2 <= row < len(strength) - apart // 2]
