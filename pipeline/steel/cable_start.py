"""A cable's photo model and a scan of it brought together by their unrolled surfaces.

Takes two elongated clouds, the scale of one nearly known; gives a placement and what fixed it.  Both are
unrolled about their own axes; relief (what the radius differs from a smooth tube's) and brightness are laid
over each other at every turn and slide, and either way round, by correlation.  The scale is the ratio of the
radii.  A clean cable fixes neither turn nor slide: that is said, not guessed.

Source: cross-correlation by the Fourier transform, normalised by the overlapping cells (D. Padfield, "Masked
object registration in the Fourier domain", IEEE Trans. Image Processing 21(5), 2012, equation 16).
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from pipeline.core.errors import StageError
from pipeline.core.fits import Cylinder, fit_cylinder
from pipeline.core.vocabulary import Array
from pipeline.steel.fuse_records import FuseOptions, Placement

TURN_CELLS = 180
MOST_ROWS = 1024
LEAST_COMMON = 0.25
"""Least part of the shorter cloud's cells that must overlap."""
CLEAR_PEAK = 0.12
"""The best correlation must stand out from the best elsewhere by this."""
MOST_POINTS = 200_000
CELLS_ALIKE = 6.2
"""So many cells count as one after a blur of 0.7 cells: 4 pi 0.7^2."""
SUMMIT_SIGMA = 0.04
"""A parabola through three cells finds a summit within this share of a cell (measured: 0.03)."""


@dataclass(frozen=True, kw_only=True)
class CableStart:
    """How a cable's clouds lie to each other.

    Attributes:
        placement: seven parameters.
        axis: (3,) of the cable, site frame; place: (3,) on it, metres.
        held_by: "relief", "brightness" or "" where nothing tells the turn and the slide.
        score, rival: correlation at the best place, and at the best of the others.
        along_sigma_m, turn_sigma_rad: of slide and turn: of the correlation's summit, or where nothing tells
            them, of any turn and of any slide that leaves an overlap.
    """

    placement: Placement
    axis: Array
    place: Array
    held_by: str
    score: float
    rival: float
    along_sigma_m: float
    turn_sigma_rad: float


@dataclass(frozen=True)
class _Tube:
    """A cloud about its axis: frame rows u, v, axis; place; radius; (m,) azimuth, along, off; brightness."""

    frame: Array
    place: Array
    radius: float
    azimuth: Array
    along: Array
    off: Array
    bright: Array


def is_elongated(points: Array, times: float) -> bool:
    """Whether a cloud is so many times longer than wide."""
    spread = np.sqrt(np.linalg.eigvalsh(np.cov(points[:: len(points) // 50_000 + 1].T)))
    return bool(spread[2] > times * spread[1])


def start_from_unrolled(
    photo: Array, photo_bright: Array, scan: Array, scan_bright: Array, options: FuseOptions
) -> CableStart:
    """Bring two clouds of a cable together.

    Args:
        photo: (n, 3) photo frame; photo_bright: (n,) grey values or (0,).
        scan: (m, 3) metres; scan_bright: (m,) intensities or (0,).
        options: see there.

    Raises:
        StageError: a cloud is no cable, or the radii contradict the scale.
    """
    first, second = _tube(photo, photo_bright, "photo model"), _tube(scan, scan_bright, "scan")
    scale = second.radius / first.radius
    if options.scale_sigma_share and abs(scale - 1) > max(5 * options.scale_sigma_share, 0.02):
        raise StageError(
            "fuse",
            f"the radius is {1000 * first.radius:.1f} mm in photos, {1000 * second.radius:.1f} in the scan",
            "check that both show the same cable, and the unit of the scan",
        )
    length = np.ptp(second.along), scale * np.ptp(first.along)
    step = max(max(length) / MOST_ROWS, 2 * np.pi * second.radius / TURN_CELLS)
    found = []
    for kind in ("brightness", "relief"):
        theirs = _map(second, kind, 1.0, step, 1)
        if theirs is None:
            continue
        for way in (1, -1):
            mine = _map(first, kind, scale, step, way)
            if mine is not None:
                found.append((_best_shift(mine, theirs), kind, way))
    best, kind, way = max(found, key=lambda f: f[0].score)
    rival = max([best.rival, *(f[0].score for f in found if f[1] == kind and f[2] != way)])
    clear = best.score - rival > CLEAR_PEAK and best.score > 3 * CLEAR_PEAK
    return _placed(first, second, scale, replace(best, rival=rival), way, kind if clear else "", step)


def _tube(points: Array, bright: Array, name: str) -> _Tube:
    some = points[:: len(points) // 20_000 + 1]
    _, _, axes = np.linalg.svd(some - some.mean(axis=0), full_matrices=False)
    tube: Cylinder = fit_cylinder(some, direction=axes[0])
    spread = np.median(np.abs(tube.distances(some)))
    if spread > 0.1 * tube.radius:
        raise StageError("fuse", f"the {name} is no cable and has no spheres", "give pairs of places by hand")
    direction = tube.direction * np.sign(tube.direction[np.argmax(np.abs(tube.direction))])
    u = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    u /= np.linalg.norm(u)
    frame = np.stack([u, np.cross(direction, u), direction])
    every = len(points) // MOST_POINTS + 1
    local = (points[::every] - tube.point) @ frame.T
    rho = np.hypot(local[:, 0], local[:, 1])
    near = np.abs(rho - tube.radius) < 0.3 * tube.radius
    local, rho = local[near], rho[near]
    return _Tube(
        frame,
        tube.point,
        float(tube.radius),
        np.arctan2(local[:, 1], local[:, 0]),
        local[:, 2],
        rho - tube.radius,
        bright[::every][near] if len(bright) else bright,
    )


def _map(tube: _Tube, kind: str, scale: float, step: float, way: int) -> tuple[Array, Array, float] | None:
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
    return _detail(mean, seen), seen.astype(float), low


def _detail(values: Array, seen: NDArray[np.bool_]) -> Array:
    """Less the mean of each lamp-wide surroundings, outliers clipped: shading and sag are no marks."""

    def smooth(image: Array, sigma: float) -> Array:
        return np.asarray(gaussian_filter(image, sigma, mode=("constant", "wrap")))

    weight = smooth(seen.astype(float), 12.0)
    rest = np.where(seen, values - smooth(values * seen, 12.0) / np.maximum(weight, 1e-9), 0.0)
    spread = 1.4826 * np.median(np.abs(rest[seen]))
    rest = np.clip(rest, -5 * spread, 5 * spread)
    return np.where(seen, smooth(rest, 0.7), 0.0)


@dataclass(frozen=True)
class _Shift:
    """The best correlation and its rival; where it stands, in rows and turned columns, and their sigmas."""

    score: float
    rival: float
    rows: float
    columns: float
    rows_sigma: float
    columns_sigma: float


def _best_shift(
    mine: tuple[Array, Array, float], theirs: tuple[Array, Array, float], away: int = 6
) -> _Shift:
    """The best correlation, and the best farther than ``away`` cells from it."""
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
    free = float(common[row, column]) / CELLS_ALIKE
    spread = np.sqrt(max(1 - best**2, 0.0) / (max(best, 1e-3) * free))
    return _Shift(
        score=best,
        rival=float(elsewhere.max()),
        rows=float(row if row < b.shape[0] else row - rows) + rows_at,
        columns=float(column) + columns_at,
        rows_sigma=float(np.hypot(spread * rows_sigma, SUMMIT_SIGMA)),
        columns_sigma=float(np.hypot(spread * columns_sigma, SUMMIT_SIGMA)),
    )


def _summit(before: float, here: float, after: float) -> tuple[float, float]:
    """Where a parabola peaks, and the root of its inverse curvature."""
    bend = before - 2 * here + after
    if bend >= 0:
        return 0.0, 10.0
    return float(np.clip((before - after) / (2 * bend), -0.5, 0.5)), float(min(1 / np.sqrt(-bend), 10.0))


def _placed(
    first: _Tube, second: _Tube, scale: float, shift: _Shift, way: int, held: str, step: float
) -> CableStart:
    # the other way round: v and axis are mirrored together, azimuth and along change sign
    flip = np.diag([1.0, way, way])
    turn = 2 * np.pi * shift.columns / TURN_CELLS
    cosine, sine = np.cos(turn), np.sin(turn)
    about = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1.0]])
    rotation = second.frame.T @ about @ flip @ first.frame
    theirs, mine = second.along, way * scale * first.along
    along_sigma, turn_sigma = shift.rows_sigma * step, 2 * np.pi * shift.columns_sigma / TURN_CELLS
    slide = float(theirs.min() - mine.min() + shift.rows * step)
    if not held:
        slide = float(theirs.min() + theirs.max() - mine.min() - mine.max()) / 2
        # even probability over all that is possible
        along_sigma, turn_sigma = float(np.ptp(theirs) + np.ptp(mine)) / np.sqrt(12), np.pi / np.sqrt(3)
    translation = second.place + slide * second.frame[2] - scale * rotation @ first.place
    return CableStart(
        placement=Placement(scale=scale, rotation=rotation, translation=translation),
        axis=second.frame[2],
        place=second.place,
        held_by=held,
        score=shift.score,
        rival=shift.rival,
        along_sigma_m=along_sigma,
        turn_sigma_rad=turn_sigma,
    )
