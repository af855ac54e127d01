"""The profile across a ridge, averaged along it: height, width, and what a window took off its crest.

Takes heights at distances from the crest.  Leaves out where the crest runs
(:mod:`pipeline.cable.relief_ridges`).
"""

import itertools
from dataclasses import dataclass

import numpy as np

from pipeline.core.vocabulary import Array

HALF_MM = 16.0
"""Half the width that a profile covers."""

_STEP_MM = 0.5


@dataclass(frozen=True, kw_only=True)
class Profile:
    """Mean heights (k,) over distances across the ridge (k,), with their standard deviations (k,)."""

    across_mm: Array
    height_mm: Array
    sigma_mm: Array

    @staticmethod
    def of(across: Array, values: Array) -> "Profile":
        """Mean of the middle half of each step's cells, as good as the median and finer."""
        edges = np.arange(-HALF_MM, HALF_MM + _STEP_MM / 2, _STEP_MM)
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
            return Profile(across_mm=middle, height_mm=0 * middle, sigma_mm=0 * middle + np.inf)
        return Profile(
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
        near = np.abs(self.across_mm) < HALF_MM / 2
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

    def flattened_mm(self, window_mm: float) -> float:
        """How much a window of that side would take off the crest if it were laid over it once more.

        To first order what one that does not follow the relief has taken off already (van Cittert 1931, one
        step); one that follows it perfectly takes nothing.
        """
        steps = round(window_mm / _STEP_MM) | 1
        if steps < 2:
            return 0.0
        again = np.convolve(self.height_mm, np.ones(steps) / steps, mode="same")
        crest = int(np.argmin(np.abs(self.across_mm - self.crest_mm())))
        return float(max(self.height_mm[crest] - again[crest], 0.0))
