"""Nodes: where the rods of a ball meet, and how far the ball is off that place (section 2.2).

Takes members; gives for each ball the centre of its rods by least squares with covariance, the paper's centre
by common perpendiculars, and the eccentricity with its sigma and whether it is significant.  Leaves out the
fits.

The least-squares centre minimises the squared distances from the rods' axes, each weighted with the
covariance of its axis at the node (Mahalanobis distance).  Errors that ball and rods share, those of the
stations both were seen from, cancel in the eccentricity as far as they do: see StationShare.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.stats import chi2

from pipeline.core.vocabulary import Array
from pipeline.steel.joint import Part, joint_covariance, together
from pipeline.steel.member_records import Ball, Joint, Members, Rod, StationShare
from pipeline.steel.perpendiculars import CentreRule, perpendicular_centre
from pipeline.steel.straightness import axis_moves, axis_offset, axis_sigma

_NO_SHARE = StationShare(stations=np.zeros(0, dtype=np.int64), gains=np.zeros((0, 3, 7)))


@dataclass(frozen=True, kw_only=True)
class NodeOptions:
    """How eccentricities are judged.

    Attributes:
        false_alarm: probability of even one false alarm among all nodes that have no eccentricity.
        axis_sigma_mm: how far a rod's axis may pass the node without that being an eccentricity, as assumed
            before the rods of this structure told how straight they are (``straightness.py``).
    """

    false_alarm: float = field(default=0.01, metadata={"above": 0.0, "maximum": 0.5})
    axis_sigma_mm: float = field(default=0.1, metadata={"minimum": 0.0})


@dataclass(frozen=True, kw_only=True)
class Node:
    """A node of the grid.

    Attributes:
        name: of its ball.
        ball_m: (3,) centre of the ball, site frame; NaN where it was not seen.
        ball_covariance: (3, 3), m^2.
        ball_noise: (4, 4) of (x, y, z, radius) of it what the points' noise leaves.
        ball_share: how the same four follow the stations' errors.
        diameter_mm: of the ball.
        rods: their names.
        column: name of the column below, or "".
        rods_m: (3,) where the rods meet by least squares; NaN with fewer than two rods that cross.
        rods_covariance: (3, 3), m^2.
        rods_noise: (3, 3) of it what the points' noise and the axes' passing each other leave.
        rods_share: how the meeting place follows the stations' errors.
        axes_rms_mm: root mean square distance of the axes from there.
        perpendicular_m: (3,) where they meet after the paper; NaN where no two cross.
        perpendicular_rule: how it was found.
        eccentricity_mm: (3,) ball minus rods.
        eccentricity_covariance: (3, 3), mm^2.
        amount_mm: length of the eccentricity.
        sigma_mm: standard deviation of that length, along it.
        chi_square: of the eccentricity against none, 3 degrees of freedom.
        critical: what chi_square must exceed to be significant.
        significant: whether it does.
    """

    name: str
    ball_m: Array
    ball_covariance: Array
    ball_noise: Array
    ball_share: StationShare
    diameter_mm: float
    rods: tuple[str, ...]
    column: str
    rods_m: Array
    rods_covariance: Array
    rods_noise: Array
    rods_share: StationShare
    axes_rms_mm: float
    perpendicular_m: Array
    perpendicular_rule: CentreRule
    eccentricity_mm: Array
    eccentricity_covariance: Array
    amount_mm: float
    sigma_mm: float
    chi_square: float
    critical: float
    significant: bool


def measure_nodes(members: Members, options: NodeOptions) -> tuple[Node, ...]:
    """Measure the nodes at all balls, and where rods meet without a ball that was seen.

    What is not known is NaN: the eccentricity of a ball with fewer than two rods that cross; ball, diameter
    and eccentricity of a joint whose ball was not seen.
    """
    by_name = {rod.name: rod for rod in members.rods}
    count = max(sum(len(ball.rods) >= 2 for ball in members.balls), 1)
    critical = float(chi2.isf(options.false_alarm / count, 3))
    balls = [*members.balls, *(_unseen(joint) for joint in members.joints)]
    rods = [[by_name[name] for name in ball.rods] for ball in balls]
    places = [*(b.centre for b in members.balls), *(j.place for j in members.joints)]
    axis_sigma_m = axis_sigma(zip(rods, places, strict=True), members, options.axis_sigma_mm / 1000)
    return tuple(
        _node(ball, own, members, critical, axis_sigma_m, near)
        for ball, own, near in zip(balls, rods, places, strict=True)
    )


def _unseen(joint: Joint) -> Ball:
    """A ball of which only the rods are known."""
    nothing = np.full((4, 4), np.nan)
    none = StationShare(stations=np.zeros(0, dtype=np.int64), gains=np.zeros((0, 4, 7)))
    return Ball(
        name=joint.name,
        centre=np.full(3, np.nan),
        radius_m=float("nan"),
        noise_covariance=nothing,
        share=none,
        covariance=nothing,
        rods=joint.rods,
        column=joint.column,
        points=0,
        rms_m=float("nan"),
    )


def _node(
    ball: Ball, rods: list[Rod], members: Members, critical: float, axis_sigma_m: float, near: Array
) -> Node:
    centre, gains, scatter, rms = _least_squares(rods, near, axis_sigma_m)
    paper = perpendicular_centre(
        np.array([r.place for r in rods]).reshape(-1, 3), np.array([r.direction for r in rods]).reshape(-1, 3)
    )
    meeting = [
        Part(gain=gain, noise=rod.noise_covariance, share=rod.share)
        for rod, gain in zip(rods, gains, strict=True)
    ]
    passing = Part(gain=np.eye(3), noise=scatter, share=_NO_SHARE)
    own = Part(gain=-np.eye(3, 4), noise=ball.noise_covariance, share=ball.share)
    covariance = joint_covariance([own, passing, *meeting], members)
    away = ball.centre - centre
    amount = float(np.linalg.norm(away))
    known = bool(np.isfinite(away).all())
    square = float(away @ np.linalg.solve(covariance, away)) if known else float("nan")
    along = away / amount if known and amount > 0 else np.full(3, np.nan)
    return Node(
        name=ball.name,
        ball_m=ball.centre,
        ball_covariance=ball.covariance[:3, :3],
        ball_noise=ball.noise_covariance,
        ball_share=ball.share,
        diameter_mm=2000 * ball.radius_m,
        rods=ball.rods,
        column=ball.column,
        rods_m=centre,
        rods_covariance=joint_covariance([passing, *meeting], members),
        rods_noise=sum((p.gain @ p.noise @ p.gain.T for p in meeting), scatter),
        rods_share=together([(p.share, p.gain) for p in (passing, *meeting)]),
        axes_rms_mm=1000 * rms,
        perpendicular_m=paper.centre,
        perpendicular_rule=paper.rule,
        eccentricity_mm=1000 * away,
        eccentricity_covariance=1e6 * covariance,
        amount_mm=1000 * amount,
        sigma_mm=1000 * float(np.sqrt(along @ covariance @ along)),
        chi_square=square,
        critical=critical,
        significant=known and square > critical,
    )


def _least_squares(
    rods: list[Rod], near: Array, axis_sigma_m: float
) -> tuple[Array, list[Array], Array, float]:
    """The place next to all axes.

    Returns:
        (3,) place; for each rod (3, 5) how the place follows its parameters; (3, 3) covariance from the axes
        passing each other by more than their own sigmas say; root mean square distance of the axes.
    """
    unknown = np.full(3, np.nan)
    if len(rods) < 2:
        return unknown, [np.zeros((3, 5)) for _ in rods], np.full((3, 3), np.nan), float("nan")
    across = [rod.frame[:2] for rod in rods]
    moves = [axis_moves(float(rod.along(near))) for rod in rods]
    offsets = [axis_offset(rod, near) for rod in rods]
    own = [h @ rod.covariance @ h.T + axis_sigma_m**2 * np.eye(2) for rod, h in zip(rods, moves, strict=True)]
    extra = 0.0
    for _ in range(8):
        weights = [np.linalg.inv(c + extra * np.eye(2)) for c in own]
        normal = sum((b.T @ w @ b for b, w in zip(across, weights, strict=True)), np.zeros((3, 3)))
        if np.linalg.cond(normal) > 1e6:  # the rods lie in one line: nothing holds the place along it
            return unknown, [np.zeros((3, 5)) for _ in rods], np.full((3, 3), np.nan), float("nan")
        gains = [np.linalg.solve(normal, b.T @ w) for b, w in zip(across, weights, strict=True)]
        step = sum((k @ m for k, m in zip(gains, offsets, strict=True)), np.zeros(3))
        misses = [m - b @ step for b, m in zip(across, offsets, strict=True)]
        square = sum(float(e @ w @ e) for e, w in zip(misses, weights, strict=True))
        freedom = 2 * len(rods) - 3
        if square <= freedom * 1.0001:
            break
        # the axes pass each other by more than their sigmas: what is missing is added (to first order)
        slope = sum(float(e @ w @ w @ e) for e, w in zip(misses, weights, strict=True))
        extra += (square - freedom) / max(slope, 1e-30)
    scatter = sum(((axis_sigma_m**2 + extra) * k @ k.T for k in gains), np.zeros((3, 3)))
    rms = float(np.sqrt(np.mean([e @ e for e in misses])))
    full = [k @ h for k, h in zip(gains, moves, strict=True)]
    return near + step, full, scatter, rms
