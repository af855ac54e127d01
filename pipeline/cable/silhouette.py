"""The outline of the cable in a frame: two sub-pixel edges, and the mask between them.

Takes one grey or colour image and the image direction of travel; gives the edges as points in pixels.  Two
long smooth edges are traced through the whole picture (dynamic programming over stripes, so texture on the
cable does not lead them astray) in brightness, colour and roughness together, since a grey cable before a
grey sky differs in one of them only.  They are then refined column by column in the mixture of the colours
that tells cable from background best.  Leaves out what the lens does to the edges
(:mod:`pipeline.cable.plumb_lines`).

Inside this module the cable runs along the image's x; pictures with travel up or down are transposed.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.cable.edge_traces import STRIPES, peaks, slopes_down, step_strength, trace_rows
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
        least_strength: an edge's mean step over the whole picture, in units of the steps that texture and
            noise make in that picture; traces through pure texture reach about 2.
        width_tolerance: the cable's width may differ from the expected one by this share.
    """

    step_px: float = 8.0
    width_px: float = 9.0
    blur_px: float = 1.5
    reach_px: float = 5.0
    least_strength: float = 3.5
    width_tolerance: float = 0.25


@dataclass(frozen=True, kw_only=True)
class Silhouette:
    """The two edges of the cable in one frame.

    Attributes:
        first: (n, 2) pixels on the upper edge (left edge where the travel is up or down).
        second: (m, 2) pixels on the other edge.
        contrast: mean step of each edge in units of the noise and texture beside it.
    """

    first: Array
    second: Array
    contrast: tuple[float, float]


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
    colour = (image if image.ndim == 3 else image[:, :, None].repeat(3, axis=2)).astype(np.float32)
    colour = np.ascontiguousarray(colour.transpose(1, 0, 2)) if upright else colour
    scale = max(colour.shape[1] / 960, 0.25)
    traces = _pair(step_strength(colour, choice.blur_px * scale), choice, scale, expected_width_px)
    if traces is None:
        raise StageError(
            "lens",
            f"{name} shows no cable with both edges from side to side",
            "take out such frames, or check travel_in_image, standoff_m, diameter_mm and the light",
        )
    found = [
        _refine(colour, rows, inward, choice, scale) for rows, inward in zip(traces, (1, -1), strict=True)
    ]
    edges = [points[:, ::-1] if upright else points for points, _ in found]
    return Silhouette(first=edges[0], second=edges[1], contrast=(found[0][1], found[1][1]))


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


def _pair(
    strength: Array, choice: SilhouetteOptions, scale: float, expected_width_px: float | None
) -> tuple[Array, Array] | None:
    """Rows (STRIPES,) of the upper and of the lower edge, pixel edges counted from the top."""
    traces = trace_rows(strength, scale)
    height = strength.shape[1]
    rows = [
        row
        for row in peaks(traces.strength, round(8 * scale))
        if traces.strength[row] > choice.least_strength
    ]
    pairs = [(a, b) for i, a in enumerate(rows) for b in rows[i + 1 :] if b - a > 0.04 * height]
    if expected_width_px is not None:
        limit = choice.width_tolerance * expected_width_px
        pairs = [(a, b) for a, b in pairs if abs(b - a - expected_width_px) <= limit]
        pairs.sort(key=lambda pair: traces.strength[pair[0]] + traces.strength[pair[1]])
    else:
        pairs.sort(key=lambda pair: pair[1] - pair[0])
    return (traces.through(pairs[-1][0]), traces.through(pairs[-1][1])) if pairs else None


def _mixtures(
    colour: NDArray[np.float32], rows: Array, inward: int, scale: float
) -> list[NDArray[np.float32]]:
    """Mixtures (3,) of the colours in which cable and background differ, best first if pixels had no blur.

    Fisher's discriminant (R. A. Fisher, Annals of Eugenics 7, 1936), and again with more and more scatter
    added, which leads to the plain difference of the means; and brightness alone, since video keeps colour at
    half the resolution.  Scaled so that the pooled scatter of a pixel is 1 and the step inwards is positive.
    """
    near, far = max(int(3 * scale), 2), max(int(12 * scale), 6)
    samples = []
    for side in (inward, -inward):
        at = np.clip(rows.astype(int) + side * np.arange(near, far)[:, None], 0, len(colour) - 1)
        samples.append(colour[at, np.arange(len(rows))].reshape(-1, 3).astype(float))
    scatter = np.mean([np.cov(sample, rowvar=False) for sample in samples], axis=0)
    difference = samples[0].mean(axis=0) - samples[1].mean(axis=0)
    found = [np.linalg.solve(scatter + ridge * np.eye(3), difference) for ridge in (0.25, 25.0, 2500.0)]
    found.append(np.array([0.114, 0.587, 0.299]))
    sizes = [np.sqrt(max(float(mixture @ scatter @ mixture), 1e-12)) for mixture in found]
    signs = [np.sign(mixture @ difference) or 1.0 for mixture in found]
    return [(m * sign / size).astype(np.float32) for m, sign, size in zip(found, signs, sizes, strict=True)]


def _refine(
    colour: NDArray[np.float32], stripe_rows: Array, inward: int, choice: SilhouetteOptions, scale: float
) -> tuple[Array, float]:
    """Edge points (n, 2) to a fraction of a pixel, and their mean step in units of the scatter.

    Of the mixtures, the one whose points lie closest to a smooth curve is taken.
    """
    height, width = colour.shape[:2]
    stripe_centres = (np.arange(STRIPES) + 0.5) * width / STRIPES
    rows = np.interp(np.arange(width) + 0.5, stripe_centres, stripe_rows)
    margin = int(16 * scale + 6 * choice.blur_px * scale)
    top, bottom = max(int(rows.min()) - margin, 0), min(int(rows.max()) + margin + 1, height)
    strip = colour[top:bottom]
    found = [
        _edge_points(strip @ mixture, rows - top, inward, choice, scale)
        for mixture in _mixtures(strip, rows - top, inward, scale)
    ]
    points, step = min(found, key=lambda item: _scatter(item[0]) * width / max(len(item[0]), 1))
    return points + np.array([0.0, top]), step


def _edge_points(
    mixed: NDArray[np.float32], rows: Array, inward: int, choice: SilhouetteOptions, scale: float
) -> tuple[Array, float]:
    """Where the mixed colour steps most, near the traced rows (w,): points (n, 2) and their mean step."""
    height, width = mixed.shape
    half, reach = max(int(choice.width_px * scale) // 2, 1), max(choice.reach_px * scale, 3.0)
    centres = np.arange(half, width - half, max(choice.step_px * scale, 1.0)).astype(int)
    averaged = cv2.blur(inward * slopes_down(mixed, choice.blur_px * scale), (2 * half + 1, 1))[:, centres]
    far = np.abs(np.arange(height)[:, None] + 0.5 - rows[centres]) > reach
    peak = np.clip(np.argmax(np.where(far, -np.inf, averaged), axis=0), 1, height - 2)
    before, at, after = (averaged[peak + d, np.arange(len(centres))] for d in (-1, 0, 1))
    curvature = before - 2 * at + after
    # the largest value at the rim of the window is no maximum: curvature or offset gives it away
    offset = 0.5 * (before - after) / np.where(curvature < 0, curvature, np.nan)
    good = (at > 0.35 * float(np.median(at))) & (at > 0) & (np.abs(np.nan_to_num(offset, nan=9.0)) <= 0.5)
    points = np.column_stack([centres + 0.5, peak + offset + 0.5])[good]
    return points, float(np.mean(at[good])) if good.any() else 0.0


def _scatter(points: Array) -> float:
    """Median distance from a smooth curve through the points."""
    if len(points) < 12:
        return np.inf
    curve = np.polynomial.Polynomial.fit(points[:, 0], points[:, 1], 5)
    return float(np.median(np.abs(points[:, 1] - curve(points[:, 0]))))
