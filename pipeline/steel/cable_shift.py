"""Unrolled surfaces of two cables laid over each other at every turn and slide, by correlation.

Takes clouds about their own axes; gives maps of relief or brightness, where they fit best, and how clearly.
Leaves out what is made of it (``cable_start.py``).

Source: cross-correlation by the Fourier transform, normalised by the overlapping cells (D. Padfield, "Masked
object registration in the Fourier domain", IEEE Trans. Image Processing 21(5), 2012, equation 16).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from pipeline.core.vocabulary import Array

TURN_CELLS = 180
LEAST_COMMON = 0.25
"""Least part of the shorter cloud's cells that must overlap."""
SUMMIT_SIGMA = 0.04
"""A parabola through three cells finds a summit within this share of a cell (measured: 0.03)."""


@dataclass(frozen=True)
class Tube:
    """A cloud about its axis: frame rows u, v, axis; place; radius; (m,) azimuth, along, off; brightness."""

    frame: Array
    place: Array
    radius: float
    azimuth: Array
    along: Array
    off: Array
    bright: Array


def unrolled_map(
    tube: Tube, kind: str, scale: float, step: float, way: int, blur: float
) -> tuple[Array, Array, float] | None:
    """Cells (rows along, turn): mean value less its smooth part, whether seen; and where row 0 lies."""
    values = tube.off * scale if kind == "relief" else tube.bright
    if not len(values):
        return None
    along, azimuth = way * scale * tube.along, way * tube.azimuth
    low = float(along.min())
    rows = int((along.max() - low) / step) + 1
    row = ((along - low) / step).astype(np.int64)
    column = np.floor((azimuth % (2 * np.pi)) / (2 * np.pi) * TURN_CELLS).astype(np.int64) % TURN_CELLS
    cell, size = row * TURN_CELLS + column, rows * TURN_CELLS
    count = np.bincount(cell, minlength=size).reshape(rows, TURN_CELLS)
    total = np.bincount(cell, weights=values, minlength=size).reshape(rows, TURN_CELLS)
    seen = count > 0
    mean = np.where(seen, total / np.maximum(count, 1), 0.0)
    return _detail(mean, seen, blur), seen.astype(float), low


def _detail(values: Array, seen: NDArray[np.bool_], blur: float) -> Array:
    """Less the mean of each lamp-wide surroundings, outliers clipped: shading and sag are no marks."""

    def smooth(image: Array, sigma: float) -> Array:
        return np.asarray(gaussian_filter(image, sigma, mode=("constant", "wrap")))

    wide = max(12.0, 6 * blur)
    weight = smooth(seen.astype(float), wide)
    rest = np.where(seen, values - smooth(values * seen, wide) / np.maximum(weight, 1e-9), 0.0)
    spread = 1.4826 * np.median(np.abs(rest[seen]))
    rest = np.clip(rest, -5 * spread, 5 * spread)
    return np.where(seen, smooth(rest, blur), 0.0)


@dataclass(frozen=True)
class Shift:
    """The best correlation, its rival, and how many independent cells both rest on; where it stands, in rows
    and turned columns, their sigmas, and the best turn at every slide."""

    score: float
    rival: float
    free: float
    rows: float
    columns: float
    rows_sigma: float
    columns_sigma: float
    turns: NDArray[np.int64]

    def turn_at(self, rows: float) -> float:
        """The turn, in columns, that fits best where the slide is given."""
        return float(self.turns[round(rows) % len(self.turns)])


type Found = tuple[Shift, tuple[str, float], int]


def with_rivals(found: list[Found]) -> list[tuple[Shift, float, str, int]]:
    """The better way round of each map, with the best correlation elsewhere: what was laid over what."""
    ranked = []
    for made in {f[1]: None for f in found}:
        ways = sorted((f for f in found if f[1] == made), key=lambda f: -f[0].score)
        best, _, way = ways[0]
        ranked.append((best, max([best.rival, *(f[0].score for f in ways[1:])]), made[0], way))
    return ranked


def sigmas_clear(best: Shift, rival: float) -> float:
    """How far two correlations are apart, by Fisher's transform (Biometrika 10, 1915)."""
    gap = np.arctanh(min(best.score, 0.999)) - np.arctanh(min(rival, 0.999))
    return float(gap * np.sqrt(max(best.free - 3, 1.0) / 2))


def best_shift(mine: tuple[Array, Array, float], theirs: tuple[Array, Array, float], blur: float) -> Shift:
    """The best correlation of two maps so blurred, and the best farther than that could reach from it."""
    away = max(6.0, 4 * blur)
    a, wa, _ = mine
    b, wb, _ = theirs
    rows = a.shape[0] + b.shape[0]

    def spectrum(image: Array) -> NDArray[np.complex128]:
        return np.asarray(np.fft.rfft2(image, (rows, TURN_CELLS)))

    def across(one: NDArray[np.complex128], other: NDArray[np.complex128]) -> Array:
        return np.asarray(np.fft.irfft2(np.conj(one) * other, (rows, TURN_CELLS)))

    fa, fb, fwa, fwb, faa, fbb = (spectrum(i) for i in (a, b, wa, wb, a * a, b * b))
    common = np.maximum(across(fwa, fwb), 1e-6)
    top = across(fa, fb) - across(fa, fwb) * across(fwa, fb) / common
    left = across(faa, fwb) - across(fa, fwb) ** 2 / common
    right = across(fwa, fbb) - across(fwa, fb) ** 2 / common
    score = top / np.sqrt(np.maximum(left * right, 1e-9 * np.max(left) * np.max(right)))
    score[common < LEAST_COMMON * min(wa.sum(), wb.sum())] = -1
    row, column = np.unravel_index(np.argmax(score), score.shape)
    best = float(score[row, column])
    gap_rows = np.abs((np.arange(rows) - row + rows // 2) % rows - rows // 2)
    gap_turn = np.abs((np.arange(TURN_CELLS) - column + TURN_CELLS // 2) % TURN_CELLS - TURN_CELLS // 2)
    elsewhere = np.where((gap_rows[:, None] > away) | (gap_turn[None] > away), score, -1)
    rows_at, rows_sigma = _summit(score[(row - 1) % rows, column], best, score[(row + 1) % rows, column])
    beside = [score[row, (column + d) % TURN_CELLS] for d in (-1, 1)]
    columns_at, columns_sigma = _summit(beside[0], best, beside[1])
    # smoothed cells are not independent, and the parabola itself is a little off
    free = float(common[row, column]) / (4 * np.pi * blur**2)
    spread = np.sqrt(max(1 - best**2, 0.0) / (max(best, 1e-3) * free))
    return Shift(
        score=best,
        rival=float(elsewhere.max()),
        free=free,
        rows=float(row if row < b.shape[0] else row - rows) + rows_at,
        columns=float(column) + columns_at,
        rows_sigma=float(np.hypot(spread * rows_sigma, SUMMIT_SIGMA)),
        columns_sigma=float(np.hypot(spread * columns_sigma, SUMMIT_SIGMA)),
        turns=np.argmax(score, axis=1),
    )


def _summit(before: float, here: float, after: float) -> tuple[float, float]:
    """Where a parabola peaks, and the root of its inverse curvature."""
    bend = before - 2 * here + after
    if bend >= 0:
        return 0.0, 10.0
    return float(np.clip((before - after) / (2 * bend), -0.5, 0.5)), float(min(1 / np.sqrt(-bend), 10.0))
