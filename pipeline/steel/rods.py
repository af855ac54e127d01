"""Rods and columns: rough pieces cut at the balls, their points gathered from all tiles, and fitted.

Takes rough pieces and fitted balls; gives rods with covariance, from ball to ball.  Leaves out which of them
are columns and what they are called, see members.py.
"""

import numpy as np
from numpy.typing import NDArray

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array
from pipeline.steel.fitting import Fitted, fit_rod
from pipeline.steel.member_records import MemberOptions, Rod
from pipeline.steel.segments import Pieces
from pipeline.steel.tile_reader import TileReader
from pipeline.steel.vectors import lengths

CLEAR_M = 0.04
"""Rods are measured from this far off the ball's surface: cones, bolts and welds lie between."""
LEAST_POINTS = 150
"""A rod seen at fewer points is not reported."""
LEAST_ARC_DEG = 50.0
"""Nor one of whose circumference less than this is seen."""
AROUND_M = 0.03
"""Points up to this far outside the surface are looked at."""
BIN_M = 0.05
"""Along the axis, points are counted in steps of this length."""


def cut_at_balls(pieces: Pieces, centres: Array, radii: Array) -> Pieces:
    """Cut pieces that run through balls, and pull ends back; centres (n, 3) and radii (n,) of the balls."""
    starts, ends, widths, seeds = [], [], [], []
    for start, end, radius, count in zip(
        pieces.starts, pieces.ends, pieces.radii_m, pieces.seeds, strict=True
    ):
        length = float(np.linalg.norm(end - start))
        axis = (end - start) / length
        along = (centres - start) @ axis if len(centres) else np.zeros(0)
        away = np.linalg.norm(centres - start - along[:, None] * axis, axis=1) if len(centres) else along
        # a ball narrower than the member sits on its end and cuts nothing
        on = (away < 0.08) & (along > -0.1) & (along < length + 0.1) & (radii > 1.1 * radius)
        order = np.argsort(along[on])
        places, reach = along[on][order], radii[on][order] + CLEAR_M
        lows = np.concatenate([[0.0], places + reach])
        highs = np.concatenate([places - reach, [length]])
        for low, high in zip(np.maximum(lows, 0), np.minimum(highs, length), strict=True):
            if high - low > 0.1:
                starts.append(start + low * axis)
                ends.append(start + high * axis)
                widths.append(float(radius))
                seeds.append(float(count) * (high - low) / length)
    return Pieces(
        starts=np.array(starts).reshape(-1, 3),
        ends=np.array(ends).reshape(-1, 3),
        radii_m=np.array(widths),
        seeds=np.array(seeds),
    )


def measure_rod(
    start: Array,
    end: Array,
    radius: float,
    reader: TileReader,
    balls: tuple[Array, Array],
    options: MemberOptions,
) -> Rod | None:
    """Fit a rod whose rough axis runs from ``start`` to ``end`` (3,); None where its points make none.

    Args:
        start, end: metres, site frame.
        radius: rough, metres.
        reader: the registered points.
        balls: centres (n, 3) and radii (n,): their surroundings are left out.
        options: noise and least length.
    """
    stations = reader.tiles.stations
    axis = (end - start) / np.linalg.norm(end - start)
    points = reader.capsule(start - 0.3 * axis, end + 0.3 * axis, radius + AROUND_M)
    for centre, ball_radius in zip(*balls, strict=True):
        if ball_radius > 1.1 * radius:
            points = points.where(lengths(points.places - centre) > ball_radius + CLEAR_M)
    low, high = _extent(points.places, start, axis, radius, float(np.linalg.norm(end - start)))
    along = (points.places - start) @ axis
    points = points.where((along > low) & (along < high))
    if len(points) < LEAST_POINTS:
        return None
    try:
        fitted = fit_rod(points, axis, stations, options)
    except StageError:  # its points lie on no cylinder
        return None
    rod = _rod(fitted)
    good = rod.length_m >= options.least_length_m and rod.length_m > 3 * 2 * rod.radius_m
    good &= rod.points >= LEAST_POINTS and rod.arc_deg >= LEAST_ARC_DEG
    good &= rod.rms_m < 3.0 * options.range_sigma_mm / 1000 and 0.6 < rod.radius_m / radius < 1.6
    return rod if good and _is_alone(points.places, rod) else None


def _extent(places: Array, start: Array, axis: Array, radius: float, length: float) -> tuple[float, float]:
    """Where along the axis the surface begins and ends: it is followed from the rough piece outward."""
    t = (places - start) @ axis
    away = lengths(places - start - t[:, None] * axis)
    t = t[np.abs(away - radius) < 0.015]
    count, edges = np.histogram(t, bins=np.arange(-0.3, length + 0.3 + BIN_M, BIN_M))
    inside = (edges[:-1] >= -1e-9) & (edges[1:] <= length + 1e-9)
    usual = float(np.median(count[inside])) if inside.any() else 0.0
    dense = count > max(0.2 * usual, 3)
    first = int(np.argmax(edges[:-1] >= -1e-9))
    last = max(int(np.sum(edges[1:] <= length + 1e-9)) - 1, first)
    while first > 0 and dense[first - 1]:
        first -= 1
    while last < len(count) - 1 and dense[last + 1]:
        last += 1
    return float(edges[first]), float(edges[last + 1])


def _rod(fitted: Fitted) -> Rod:
    used = fitted.weights > 0.1
    local = fitted.used[used] - fitted.place
    along = local @ fitted.direction
    first, last = np.quantile(along, [0.002, 0.998])
    around = np.degrees(np.arctan2(local @ fitted.frame[1], local @ fitted.frame[0])) % 360
    # the place and the covariance belong to the axis next to the points' centroid
    return Rod(
        name="",
        place=fitted.place,
        direction=fitted.direction,
        frame=fitted.frame,
        radius_m=fitted.radius_m,
        first_m=float(first),
        last_m=float(last),
        noise_covariance=fitted.noise_covariance,
        share=fitted.share,
        covariance=fitted.covariance,
        points=int(used.sum()),
        rms_m=fitted.rms_m,
        arc_deg=5.0 * np.count_nonzero(np.bincount((around / 5).astype(np.int64), minlength=72) > 0),
    )


def _is_alone(places: Array, rod: Rod) -> bool:
    """Tell whether the points lie on the surface, few inside (members are dark inside), few just outside.

    Along the edge of a box a cylinder fits as well, but the box's sides lead away from it.
    """
    away = rod.apart(places) - rod.radius_m
    on = np.count_nonzero(np.abs(away) < 0.008)
    inside = np.count_nonzero(away < -0.4 * rod.radius_m)
    outside = np.count_nonzero((away > 0.012) & (away < AROUND_M))
    return bool(inside < 0.2 * on and outside < 0.25 * on)


def ends_at(
    rod: Rod, centres: Array, radii: Array, miss_m: float = 0.06, hidden_m: float = 0.45
) -> NDArray[np.bool_]:
    """At which balls (centres (n, 3), radii (n,)) a rod ends: its axis passes near, its end lies before."""
    if not len(centres):
        return np.zeros(0, dtype=bool)
    along = rod.along(centres)
    beyond = np.maximum(rod.first_m - along, along - rod.last_m)
    return np.asarray((rod.apart(centres) < miss_m) & (beyond > 0) & (beyond < radii + hidden_m))
