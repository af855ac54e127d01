"""Columns: how far each leans, which way, and whether that is allowed (the paper's Table 1).

Takes members, the plumb line and, where the survey lists them, the columns to judge; gives their inclination
with sigma.  Plumb is what all levelled stations agree on: the site's z is that of one compensator, and would
lean every column alike.  Leaves out the fits: an axis that was seen over part of the height only is
continued, and its sigma grows.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.stats import norm

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array
from pipeline.steel.joint import Part, joint_covariance
from pipeline.steel.member_records import Members, Rod
from pipeline.steel.records import Plumb
from pipeline.steel.survey_records import ColumnSpec

STAGE = "columns"


@dataclass(frozen=True, kw_only=True)
class ColumnOptions:
    """How columns are judged.

    Attributes:
        north_deg: azimuth of north, counted clockwise from the site's +y.
        limit_mm: how far the top may be off the foot; None: only ``limit_ratio``.
        limit_ratio: n of H / n, e.g. 1000 after a code; None: only ``limit_mm``.  With both, the smaller
            counts.
        place_m: a column is at most this far from where the survey says.
    """

    north_deg: float = 0.0
    limit_mm: float | None = field(default=35.0, metadata={"above": 0.0})
    limit_ratio: float | None = field(default=None, metadata={"above": 0.0})
    place_m: float = field(default=0.5, metadata={"above": 0.0})


@dataclass(frozen=True, kw_only=True)
class Column:
    """A column and its inclination.

    Attributes:
        name: from the survey, or the member's.
        member: name of the fitted cylinder.
        bottom_m, top_m: (3,) its axis at the two heights, site frame.
        height_mm: difference of the two heights.
        tilt_mm: (2,) the top off the plumb line through the foot, towards east and north.
        tilt_covariance: (2, 2), mm^2.
        deviation_mm: amount of the tilt.
        sigma_mm: its standard deviation.
        azimuth_deg: where it leans, clockwise from north.
        ratio: n of 1/n, height over deviation; inf where it stands plumb.
        ratios: (2,) the same towards east and north, as in Table 1.
        limit_mm: that the deviation is held against.
        over: whether the deviation exceeds the limit.
        over_probability: probability that it does, given its sigma.
        seen_m: (lowest, highest) height at which its surface was seen.
        hidden_mm: how much of the judged height was not seen and is extrapolated.
        diameter_mm, rms_mm, points: of the fit.
    """

    name: str
    member: str
    bottom_m: Array
    top_m: Array
    height_mm: float
    tilt_mm: Array
    tilt_covariance: Array
    deviation_mm: float
    sigma_mm: float
    azimuth_deg: float
    ratio: float
    ratios: Array
    limit_mm: float
    over: bool
    over_probability: float
    seen_m: tuple[float, float]
    hidden_mm: float
    diameter_mm: float
    rms_mm: float
    points: int

    @property
    def leans(self) -> tuple[str, ...]:
        """Both components in words, the larger first: ("north 32.1 mm", "east 17.3 mm")."""
        words = [
            (abs(self.tilt_mm[1]), "north" if self.tilt_mm[1] >= 0 else "south"),
            (abs(self.tilt_mm[0]), "east" if self.tilt_mm[0] >= 0 else "west"),
        ]
        return tuple(f"{word} {amount:.1f} mm" for amount, word in sorted(words, key=lambda w: -w[0]))


def measure_columns(
    members: Members, specs: Sequence[ColumnSpec], options: ColumnOptions, plumb: Plumb | None = None
) -> tuple[Column, ...]:
    """Judge the listed columns, or every column found where none is listed.

    Args:
        members: with the columns among them.
        specs: what to judge, or nothing.
        options: limits.
        plumb: the plumb line; None: the site's z, taken as exact.

    Raises:
        StageError: a listed column has no upright cylinder at its place, or no height.
    """
    if not specs:
        return tuple(
            _column(rod.name, rod, _heights(rod), members, plumb, options) for rod in members.columns
        )
    found: list[Column] = []
    missing: list[ColumnSpec] = []
    for spec in specs:
        if spec.top_m - spec.bottom_m <= 0:
            raise StageError(
                STAGE,
                f"column[{spec.name}]: top_m {spec.top_m:g} is not above bottom_m {spec.bottom_m:g}",
                "give the heights between which the axis is judged",
            )
        rod = _at(spec, members, options)
        if rod is None:
            missing.append(spec)
        else:
            judged = (spec.bottom_m, spec.top_m)
            found.append(_column(spec.name, rod, judged, members, plumb, options))
    if missing:
        raise StageError(STAGE, _absent(missing, members, options), _ABSENT_REMEDY)
    return tuple(found)


_ABSENT_REMEDY = (
    "check its place_m (site frame, metres) and structure.column_diameters_mm, or take the entry out"
)


def _absent(missing: list[ColumnSpec], members: Members, options: ColumnOptions) -> str:
    names = ", ".join(f"column[{s.name}] at ({s.place_m[0]:g}, {s.place_m[1]:g})" for s in missing)
    return (
        f"no upright cylinder stands within {options.place_m:g} m of {names}; "
        f"{len(members.columns)} columns were found elsewhere or for other entries"
    )


def _at(spec: ColumnSpec, members: Members, options: ColumnOptions) -> Rod | None:
    """The column next to a listed place, somewhere between the listed heights."""
    best, least = None, options.place_m
    for rod in members.columns:
        low, high = _heights(rod)
        if high < spec.bottom_m or low > spec.top_m:
            continue
        middle = _at_height(rod, 0.5 * (spec.bottom_m + spec.top_m))
        away = float(np.hypot(*(middle[:2] - spec.place_m)))
        if away <= least:
            best, least = rod, away
    return best


def _column(
    name: str,
    rod: Rod,
    judged_m: tuple[float, float],
    members: Members,
    plumb: Plumb | None,
    options: ColumnOptions,
) -> Column:
    low, high = judged_m
    bottom, top = _at_height(rod, low), _at_height(rod, high)
    tilt, covariance = _tilt(rod, judged_m, members, plumb, np.radians(options.north_deg))
    deviation = float(np.hypot(*tilt))
    along = tilt / deviation if deviation > 0 else np.array([0.0, 1.0])
    sigma = float(np.sqrt(along @ covariance @ along))
    height = 1000 * (high - low)
    limits = [options.limit_mm, None if options.limit_ratio is None else height / options.limit_ratio]
    limit = min((v for v in limits if v is not None), default=float("inf"))
    seen = _heights(rod)
    with np.errstate(divide="ignore"):
        ratios = height / np.abs(tilt)
    return Column(
        name=name,
        member=rod.name,
        bottom_m=bottom,
        top_m=top,
        height_mm=height,
        tilt_mm=tilt,
        tilt_covariance=covariance,
        deviation_mm=deviation,
        sigma_mm=sigma,
        azimuth_deg=float(np.degrees(np.arctan2(tilt[0], tilt[1])) % 360),
        ratio=height / deviation if deviation > 0 else float("inf"),
        ratios=ratios,
        limit_mm=limit,
        over=deviation > limit,
        over_probability=float(norm.cdf((deviation - limit) / max(sigma, 1e-9))),
        seen_m=seen,
        hidden_mm=1000 * (max(seen[0] - low, 0.0) + max(high - seen[1], 0.0)),
        diameter_mm=2000 * rod.radius_m,
        rms_mm=1000 * rod.rms_m,
        points=rod.points,
    )


def _tilt(
    rod: Rod, judged_m: tuple[float, float], members: Members, plumb: Plumb | None, north: float
) -> tuple[Array, Array]:
    """(2,) the top off the plumb line through the bottom, east and north, mm, and its (2, 2) covariance.

    To first order in the plumb's lean: the heights are the site's.
    """
    low, high = judged_m
    # rows east, north: north is the azimuth clockwise from +y
    turn = np.array([[np.cos(north), -np.sin(north)], [np.sin(north), np.cos(north)]])
    across = (_at_height(rod, high) - _at_height(rod, low))[:2]
    moves = turn @ (_horizontal_moves(rod, high) - _horizontal_moves(rod, low))
    part = Part(gain=moves, noise=rod.noise_covariance, share=rod.share)
    if plumb is None:
        return 1000 * turn @ across, 1e6 * joint_covariance([part], members)
    across = across - (high - low) * plumb.direction[:2] / plumb.direction[2]
    by_plumb = -(high - low) * turn @ plumb.across[:, :2].T
    return 1000 * turn @ across, 1e6 * joint_covariance([part], members, by_plumb, plumb)


def _heights(rod: Rod) -> tuple[float, float]:
    """Heights between which the surface was seen."""
    low, high = sorted((float(rod.start[2]), float(rod.end[2])))
    return low, high


def _at_height(rod: Rod, height: float) -> Array:
    """(3,) the axis at a height."""
    return rod.place + (height - rod.place[2]) / rod.direction[2] * rod.direction


def _horizontal_moves(rod: Rod, height: float) -> Array:
    """(2, 5): how the axis at a height moves horizontally, per parameter of the cylinder."""
    along = (height - rod.place[2]) / rod.direction[2]
    across = np.array([[1.0, 0.0, along, 0.0, 0.0], [0.0, 1.0, 0.0, along, 0.0]])
    moved = rod.frame[:2].T @ across
    # back to the same height along the axis
    return np.asarray((moved - np.outer(rod.direction / rod.direction[2], moved[2]))[:2])
