"""A cable's photo model and a scan of it brought together by their unrolled surfaces.

Takes two elongated clouds, the scale of one nearly known; gives a placement and what fixed it.  Both are
unrolled about their own axes; relief (what the radius differs from a smooth tube's) and brightness are laid
over each other at every turn and slide, and either way round, by correlation.  The scale is the ratio of the
radii.  A clean cable fixes neither turn nor slide: that is said, not guessed.
"""

from dataclasses import dataclass, replace

import numpy as np

from pipeline.core.errors import StageError
from pipeline.core.fits import Cylinder, fit_cylinder
from pipeline.core.vocabulary import Array
from pipeline.steel.cable_shift import (
    TURN_CELLS,
    Shift,
    Tube,
    best_shift,
    sigmas_clear,
    unrolled_map,
    with_rivals,
)
from pipeline.steel.fuse_records import FuseOptions, Placement

MOST_ROWS = 1024
LEAST_SCORE, CLEAR_PEAK, CLEAR_SIGMAS = 0.36, 0.04, 3.5
"""A correlation is believed from here on, if it stands out from the best elsewhere by this, and by so many
sigmas of what the cells can tell."""
MOST_POINTS = 200_000
MAPS = (("brightness", 0.7), ("relief", 0.7), ("relief", 4.0))
"""What is laid over each other, blurred by so many cells: dents that drown in a scan's noise cell by cell
stand out of it once it is smoothed to their size."""


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
    for kind, blur in MAPS:
        theirs = unrolled_map(second, kind, 1.0, step, 1, blur)
        if theirs is None:
            continue
        for way in (1, -1):
            mine = unrolled_map(first, kind, scale, step, way, blur)
            if mine is not None:
                found.append((best_shift(mine, theirs, blur), (kind, blur), way))
    # the clearest, not the highest: ribs that wind around fit well in many places
    ranked = with_rivals(found)
    clear = any(_is_clear(f[0], f[1]) for f in ranked)
    # what is unclear may still be half right: ribs lead a screw
    best, rival, kind, way = max(
        ranked,
        key=lambda f: (_is_clear(f[0], f[1]), sigmas_clear(f[0], f[1])) if clear else (False, f[0].score),
    )
    return _placed(first, second, scale, replace(best, rival=rival), way, kind if clear else "", step)


def _is_clear(best: Shift, rival: float) -> bool:
    stands_out = best.score > LEAST_SCORE and best.score - rival > CLEAR_PEAK
    return stands_out and sigmas_clear(best, rival) > CLEAR_SIGMAS


def _tube(points: Array, bright: Array, name: str) -> Tube:
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
    return Tube(
        frame,
        tube.point,
        float(tube.radius),
        np.arctan2(local[:, 1], local[:, 0]),
        local[:, 2],
        rho - tube.radius,
        bright[::every][near] if len(bright) else bright,
    )


def _placed(
    first: Tube, second: Tube, scale: float, shift: Shift, way: int, held: str, step: float
) -> CableStart:
    # the other way round: v and axis are mirrored together, azimuth and along change sign
    flip = np.diag([1.0, way, way])
    theirs, mine = second.along, way * scale * first.along
    along_sigma, turn_sigma = shift.rows_sigma * step, 2 * np.pi * shift.columns_sigma / TURN_CELLS
    slide, columns = float(theirs.min() - mine.min() + shift.rows * step), shift.columns
    if not held:
        slide = float(theirs.min() + theirs.max() - mine.min() - mine.max()) / 2
        columns = shift.turn_at((slide - float(theirs.min() - mine.min())) / step)
        # even probability over all that is possible
        along_sigma, turn_sigma = float(np.ptp(theirs) + np.ptp(mine)) / np.sqrt(12), np.pi / np.sqrt(3)
    turn = 2 * np.pi * columns / TURN_CELLS
    cosine, sine = np.cos(turn), np.sin(turn)
    about = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1.0]])
    rotation = second.frame.T @ about @ flip @ first.frame
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
