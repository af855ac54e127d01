"""The outline of the cable in a frame: two sub-pixel edges, and the mask between them.

Takes one grey or colour image and the image direction of travel; gives the edges as points in pixels.  Two long
smooth edges are traced through the whole picture (dynamic programming over stripes, so texture on the cable
does not lead them astray) and then refined column by column.  Leaves out what the lens does to the edges
(:mod:`pipeline.cable.plumb_lines`).

Inside this module the cable runs along the image's x; pictures with travel up or down are transposed.
"""

from dataclasses import dataclass
from math import sqrt, tau

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import grey_dilation

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array, TravelDirection

Image = NDArray[np.uint8]


@dataclass(frozen=True, kw_only=True)
class SilhouetteOptions:
    """How edges are found.  Lengths are for a picture of 960 columns and grow with it.

    Attributes:
        step_px: distance between edge points along the cable.
        width_px: image columns that are averaged for one edge point.
        blur_px: standard deviation of the Gaussian across the edge.
        reach_px: how far from the traced edge the exact one is looked for.
        least_contrast: grey levels (of 255) that an edge must have on average.
        least_prominence: an edge must be this many times stronger than the picture's median trace.
        width_tolerance: the cable's width may differ from the expected one by this share.
    """

    step_px: float = 8.0
    width_px: float = 9.0
    blur_px: float = 1.5
    reach_px: float = 5.0
    least_contrast: float = 4.0
    least_prominence: float = 2.0
    width_tolerance: float = 0.25


@dataclass(frozen=True, kw_only=True)
class Silhouette:
    """The two edges of the cable in one frame.

    Attributes:
        first: (n, 2) pixels on the upper edge (left edge where the travel is up or down).
        second: (m, 2) pixels on the other edge.
        contrast: mean step of the edges, grey levels.
    """

    first: Array
    second: Array
    contrast: float


STRIPES = 24
"""Stripes along the cable in which an edge is traced."""
SATURATION = 25.0
"""Grey levels above which an edge counts as no stronger: one glaring spot must not decide the trace."""
BEND = 0.15
"""Cost, in grey levels, of stepping a trace by one pixel (squared) from one stripe to the next."""


def find_silhouette(
    image: Image,
    travel_in_image: TravelDirection,
    options: SilhouetteOptions | None = None,
    expected_width_px: float | None = None,
    name: str = "the picture",
) -> Silhouette:
    """Find both edges of the cable.

    Args:
        image: (h, w) or (h, w, 3), uint8.
        travel_in_image: the cable runs along this direction.
        options: see there.
        expected_width_px: width of the cable in the picture, roughly; chooses between several long edges.
            None takes the outermost ones.
        name: video and frame, for the error.

    Raises:
        StageError: no cable is seen from side to side of the picture.
    """
    choice = options or SilhouetteOptions()
    upright = travel_in_image in (TravelDirection.UP, TravelDirection.DOWN)
    grey = _grey(image).T if upright else _grey(image)
    scale = max(grey.shape[1] / 960, 0.25)
    blur = choice.blur_px * scale
    slopes = _slopes(grey, blur)
    traces = _pair(slopes, choice, scale, expected_width_px)
    if traces is None:
        raise StageError(
            "lens",
            f"{name} shows no cable from side to side",
            "take out such frames, or check travel_in_image and the light",
        )
    found = [_refine(slopes, trace, choice, scale) for trace in traces]
    edges = [points[:, ::-1] if upright else points for points, _ in found]
    return Silhouette(first=edges[0], second=edges[1], contrast=float(np.mean([c for _, c in found])))


def mask_between(silhouette: Silhouette, width_px: int, height_px: int, inset_px: float = 0.0) -> Image:
    """255 between the edges, 0 outside, (height_px, width_px); ``inset_px`` keeps away from the edges."""
    along = 0 if np.ptp(silhouette.first[:, 0]) >= np.ptp(silhouette.first[:, 1]) else 1
    count, across_count = (width_px, height_px) if along == 0 else (height_px, width_px)
    centres, rows = np.arange(count) + 0.5, np.arange(across_count)[:, None] + 0.5
    limits = []
    for points in (silhouette.first, silhouette.second):
        # a parabola bridges gaps and reaches the picture's border, where an edge has no points
        curve = np.polynomial.Polynomial.fit(points[:, along], points[:, 1 - along], 3)
        limits.append(curve(centres))
    inside = (rows > limits[0] + inset_px) & (rows < limits[1] - inset_px)
    mask = inside.astype(np.uint8) * 255
    return np.ascontiguousarray(mask if along == 0 else mask.T)


def cable_mask(
    image: Image,
    travel_in_image: TravelDirection,
    inset_px: float = 0.0,
    options: SilhouetteOptions | None = None,
    name: str = "the picture",
) -> Image:
    """Mask of the cable in a picture, (h, w) uint8; errors as :func:`find_silhouette`."""
    silhouette = find_silhouette(image, travel_in_image, options, name=name)
    return mask_between(silhouette, image.shape[1], image.shape[0], inset_px)


def _grey(image: Image) -> NDArray[np.float32]:
    grey = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    return grey.astype(np.float32)


def _slopes(grey: NDArray[np.float32], blur: float) -> NDArray[np.float32]:
    """Derivative of a Gaussian down the columns, scaled so that an ideal step gives its height."""
    reach = int(np.ceil(4 * blur))
    x = np.arange(-reach, reach + 1)
    kernel = x / blur**2 * np.exp(-0.5 * (x / blur) ** 2) / (sqrt(tau) * blur) * (sqrt(tau) * blur)
    return cv2.sepFilter2D(
        np.ascontiguousarray(grey), cv2.CV_32F, np.ones(1), kernel, borderType=cv2.BORDER_REPLICATE
    )


def _pair(
    slopes: NDArray[np.float32], choice: SilhouetteOptions, scale: float, expected_width_px: float | None
) -> tuple[tuple[Array, float], tuple[Array, float]] | None:
    """Two traces, upper first: each one row per stripe, and the sign of its step."""
    height, width = slopes.shape
    columns = np.linspace(0, width, STRIPES + 1).astype(int)
    stripes = np.array([slopes[:, a:b].mean(axis=1) for a, b in zip(columns[:-1], columns[1:], strict=True)])
    found = []
    for sign in (1.0, -1.0):
        traces = _traces(np.clip(sign * stripes, 0, SATURATION), scale)
        floor = choice.least_prominence * float(np.median(traces.strength))
        for row in _peaks(traces.strength, int(round(8 * scale))):
            if traces.strength[row] >= max(choice.least_contrast, floor):
                found.append((traces.strength[row], row, sign, traces))
    strongest = max((strength for strength, *_ in found), default=0.0)
    rows = sorted((item for item in found if item[0] >= 0.4 * strongest), key=lambda item: item[1])
    pairs = [(a, b) for i, a in enumerate(rows) for b in rows[i + 1 :] if b[1] - a[1] > 0.04 * height]
    if expected_width_px is not None:
        limit = choice.width_tolerance * expected_width_px
        pairs = [pair for pair in pairs if abs(pair[1][1] - pair[0][1] - expected_width_px) <= limit]
    if not pairs:
        return None
    if expected_width_px is not None:
        best = max(pairs, key=lambda pair: pair[0][0] + pair[1][0])
    else:
        best = max(pairs, key=lambda pair: pair[1][1] - pair[0][1])
    upper, lower = ((item[3].through(item[1]), item[2]) for item in best)
    return upper, lower


@dataclass(frozen=True, kw_only=True)
class _Traces:
    """Best traces through each row of the middle stripe: strength (h,), and how to walk along them."""

    strength: Array
    forward: Array
    backward: Array
    reach: int

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
        low, high = max(row - self.reach, 0), min(row + self.reach + 1, len(scores))
        penalty = BEND * (np.arange(low, high) - row) ** 2
        return low + int(np.argmax(scores[low:high] - penalty))


def _traces(stripes: NDArray[np.float32], scale: float) -> _Traces:
    """Dynamic programming from both sides to the middle stripe."""
    reach = max(int(round(7 * scale)), 2)
    bend = -BEND / scale**2 * np.arange(-reach, reach + 1) ** 2
    count, middle = len(stripes), len(stripes) // 2
    forward, backward = stripes.astype(float), stripes.astype(float)
    for s in range(1, count):
        forward[s] += _spread(forward[s - 1], bend)
        backward[count - 1 - s] += _spread(backward[count - s], bend)
    strength = (forward[middle] + backward[middle] - stripes[middle]) / count
    return _Traces(strength=strength, forward=forward, backward=backward, reach=reach)


def _spread(scores: Array, bend: Array) -> Array:
    return grey_dilation(scores, footprint=np.ones(len(bend), bool), structure=bend, mode="nearest")


def _peaks(strength: Array, apart: int) -> list[int]:
    """Rows that are strongest within ``apart`` rows on either side."""
    wide = grey_dilation(strength, size=2 * apart + 1, mode="nearest")
    return [int(row) for row in np.flatnonzero((strength >= wide) & (strength > 0))]


def _refine(
    slopes: NDArray[np.float32], trace: tuple[Array, float], choice: SilhouetteOptions, scale: float
) -> tuple[Array, float]:
    """Edge points (n, 2) to a fraction of a pixel, and their mean step."""
    rows, sign = trace
    height, width = slopes.shape
    half, reach = max(int(choice.width_px * scale) // 2, 1), max(choice.reach_px * scale, 3.0)
    centres = np.arange(half, width - half, max(choice.step_px * scale, 1.0)).astype(int)
    averaged = cv2.blur(sign * slopes, (2 * half + 1, 1))[:, centres]
    stripe_centres = (np.arange(STRIPES) + 0.5) * width / STRIPES
    expected = np.interp(centres + 0.5, stripe_centres, rows) - 0.5
    far = np.abs(np.arange(height)[:, None] - expected) > reach
    window = np.where(far, -np.inf, averaged)
    peak = np.clip(np.argmax(window, axis=0), 1, height - 2)
    column = np.arange(len(centres))
    before, at, after = (averaged[peak + d, column] for d in (-1, 0, 1))
    curvature = before - 2 * at + after
    # a maximum at the rim of the window is no maximum: its curvature or its offset gives it away
    offset = 0.5 * (before - after) / np.where(curvature < 0, curvature, np.nan)
    strong = at > max(0.35 * float(np.median(at)), choice.least_contrast / 2)
    good = strong & (np.abs(np.nan_to_num(offset, nan=9.0)) <= 0.5)
    points = np.column_stack([centres + 0.5, peak + offset + 0.5])[good]
    return points, float(np.mean(at[good])) if good.any() else 0.0
