"""Ball nodes: spheres at the places where rods meet.

Takes the registered points around such a place and the rods near it; gives the fitted sphere, or None where
there is none.  Balls without rods (sphere targets) are not looked for.  Leaves out the node's centre from its
rods, see nodes.py.
"""

import numpy as np
from numpy.typing import NDArray

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array
from pipeline.steel.fitting import Fitted, fit_ball
from pipeline.steel.member_records import MemberOptions, NominalSizes
from pipeline.steel.rays import Rays, meet_sphere
from pipeline.steel.records import StationPose
from pipeline.steel.segments import Pieces
from pipeline.steel.tile_reader import TileReader
from pipeline.steel.tile_records import SitePoints
from pipeline.steel.vectors import lengths

LEAST_POINTS = 40
"""A ball seen at fewer points is not reported."""
SAMPLES = 400
"""Spheres through four points that are tried."""
WELD_M = 0.012
"""Nearer than this to a rod is no clean ball surface: welds, and beams that meet both."""
SHELL_M = 0.02
"""Points farther than this off the ball, along their rays, are not of it."""
LARGEST_RADIUS_M = 0.35
"""Of a ball whose size is not given."""
OFF_M = 0.08
"""A ball's centre lies within this of the place where its rods meet."""


def find_ball(
    place: Array,
    reader: TileReader,
    pieces: Pieces,
    nominal: NominalSizes,
    options: MemberOptions,
    seed: int,
) -> Fitted | None:
    """Look for a ball around a place.

    Args:
        place: (3,) where rods meet.
        reader: the registered points.
        pieces: all rough rods.
        nominal: sizes.
        options: noise and shares.
        seed: of the sampling.
    """
    windows = _windows(place, pieces, nominal, options)
    reach = max(high for _, high in windows) + OFF_M
    around = reader.box(place - reach, place + reach)
    around = around.where(lengths(around.places - place) < reach)
    least = min(low for low, _ in windows)
    clear = around.where(~_on_rods(around.places, place, pieces, least))
    if len(clear) < LEAST_POINTS // 2:
        return None
    stations = reader.tiles.stations
    start = _consensus(clear.places, place, windows, options.range_sigma_mm / 1000, seed)
    if start is None:
        return None
    centre, radius = start
    try:
        for _ in range(3):
            free = around.where(_on_ball(around, centre, radius, pieces, stations))
            found = fit_ball(free, centre, radius, stations, options)
            centre, radius = found.place, found.radius_m
    except StageError:  # too few points of it, or all in one small spot: then it cannot be measured
        return None
    good = bool(len(found.used) >= LEAST_POINTS and np.linalg.norm(centre - place) < OFF_M)
    good &= any(low <= radius <= high for low, high in windows)
    good &= bool(found.rms_m < 2.0 * options.range_sigma_mm / 1000) and _fills(
        free.places, centre, radius, options
    )
    return found if good else None


def _windows(
    place: Array, pieces: Pieces, nominal: NominalSizes, options: MemberOptions
) -> list[tuple[float, float]]:
    """Radii (lower, upper) that a ball here may have: more than its rods have."""
    if nominal.balls_mm:
        share = options.nominal_share
        return [(d / 2000 * (1 - share), d / 2000 * (1 + share)) for d in nominal.balls_mm]
    ends = np.concatenate([pieces.starts, pieces.ends])
    near = np.linalg.norm(ends - place, axis=1) < 0.6
    thin = np.sort(np.tile(pieces.radii_m, 2)[near])[: max(int(near.sum()) - 1, 1)]
    low = 1.15 * float(np.median(thin)) if len(thin) else 0.03
    return [(low, max(LARGEST_RADIUS_M, 1.5 * low))]


def _on_rods(points: Array, place: Array, pieces: Pieces, clear_m: float) -> NDArray[np.bool_]:
    """Which points lie on the members around a place, each followed up to ``clear_m`` before it."""
    on = np.zeros(len(points), dtype=bool)
    for start, axis, length, radius in _members_at(place, pieces):
        goal, t = float((place - start) @ axis), (points - start) @ axis
        away = lengths(points - start - t[:, None] * axis)
        low, high = min(-0.05, goal + clear_m), max(length + 0.05, goal - clear_m)
        on |= (away < 1.15 * radius + 0.008) & (t > low) & (t < high) & (np.abs(t - goal) > clear_m)
    return on


def _members_at(place: Array, pieces: Pieces) -> list[tuple[Array, Array, float, float]]:
    """Start, axis, length and radius of the members that come near a place."""
    along = pieces.ends - pieces.starts
    length = np.linalg.norm(along, axis=1)
    axis = along / length[:, None]
    reach = np.clip(np.sum((place - pieces.starts) * axis, axis=1), 0, length)
    near = np.linalg.norm(pieces.starts + reach[:, None] * axis - place, axis=1) < 1.0
    return [
        (pieces.starts[k], axis[k], float(length[k]), float(pieces.radii_m[k])) for k in np.flatnonzero(near)
    ]


def _on_ball(
    points: SitePoints, centre: Array, radius: float, pieces: Pieces, stations: tuple[StationPose, ...]
) -> NDArray[np.bool_]:
    """Which points were measured on a ball, away from the rods that go into it.

    Judged by where each ray meets the ball, not by the point: next to a rod the point's noise would choose.
    """
    rays = Rays.of(points, stations)
    meeting = meet_sphere(np.array([0.0, 0.0, 0.0, radius]), rays, centre)
    met = rays.origins + meeting.ranges[:, None] * rays.directions
    on = np.abs(rays.ranges - meeting.ranges) < SHELL_M
    for start, axis, length, width in _members_at(centre, pieces):
        outward = axis if (centre - start) @ axis < 0.5 * length else -axis
        out = (met - centre) @ outward
        away = lengths(met - start - ((met - start) @ axis)[:, None] * axis)
        # a column may be thicker than the ball it carries: it hides the ball's foot
        hidden = away < width + WELD_M if width < 0.9 * radius else out > 0.85 * radius
        on &= ~(hidden & (out > 0))
    return on


def _consensus(
    points: Array, place: Array, windows: list[tuple[float, float]], noise_m: float, seed: int
) -> tuple[Array, float] | None:
    """The sphere through four of the points that most of them lie on (random sample consensus)."""
    rng = np.random.default_rng(seed)
    local = points - place
    chosen = local[rng.integers(0, len(points), (SAMPLES, 4))]
    design = np.concatenate([2 * chosen, np.ones((SAMPLES, 4, 1))], axis=2)
    regular = np.abs(np.linalg.det(design)) > 1e-9
    if not regular.any():
        return None
    solved = np.linalg.solve(design[regular], np.sum(chosen[regular] ** 2, axis=2)[..., None])[..., 0]
    centres = solved[:, :3]
    radii = np.sqrt(np.maximum(solved[:, 3] + np.sum(centres**2, axis=1), 0))
    good = np.any([(radii > low) & (radii < high) for low, high in windows], axis=0)
    good &= np.linalg.norm(centres, axis=1) < OFF_M
    if not good.any():
        return None
    centres, radii = centres[good], radii[good]
    some = local[rng.permutation(len(local))[:1500]]
    distance = np.abs(lengths(some[None] - centres[:, None]) - radii[:, None])
    best = int(np.argmax(np.sum(np.clip(1 - (distance / (3 * noise_m)) ** 2, 0, None), axis=1)))
    return centres[best] + place, float(radii[best])


def _fills(points: Array, centre: Array, radius: float, options: MemberOptions) -> bool:
    """Tell whether most points not far off the sphere lie on it: a figure that only touches it fails."""
    distance = np.abs(np.linalg.norm(points - centre, axis=1) - radius)
    on = np.count_nonzero(distance < 3 * options.range_sigma_mm / 1000)
    near = np.count_nonzero(distance < 0.35 * radius)
    return bool(on > 0.5 * near)
