"""Deflection: how far the nodes of the bottom chord hang below the supports, against span / 250.

Takes nodes, columns and the span; gives the sag of each node of the bottom chord with its sigma.  The
reference is the plane through the supported nodes (those over columns), or the line through two of them.  A
node is where its rods meet, the ball's centre where they do not tell: an eccentric ball is no deflection, and
the rods tell the place more sharply.  Leaves out the camber that the grid was built with: it is not in the
survey.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.stats import norm

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array
from pipeline.steel.columns import Column
from pipeline.steel.nodes import Node

STAGE = "deflection"


@dataclass(frozen=True, kw_only=True)
class DeflectionOptions:
    """How the deflection is judged.

    Attributes:
        limit: the sag may be span / this.
        chord_m: balls farther than this above or below the supports' plane are not of the bottom chord; None:
            half the smallest height of the grid, found from the balls.
        support_m: a column stands at most this far, seen from above, from the ball that it carries.
    """

    limit: float = field(default=250.0, metadata={"above": 0.0})
    chord_m: float | None = field(default=None, metadata={"above": 0.0})
    support_m: float = field(default=0.4, metadata={"above": 0.0})


@dataclass(frozen=True, kw_only=True)
class Sag:
    """Deflection of one node.

    Attributes:
        node: its name.
        place_m: (3,) where its rods meet, else the centre of its ball; site frame.
        sag_mm: below the supports; negative above them.
        sigma_mm: standard deviation.
        support: whether it is one of the supports.
    """

    node: str
    place_m: Array
    sag_mm: float
    sigma_mm: float
    support: bool


@dataclass(frozen=True, kw_only=True)
class Deflection:
    """Deflection of the grid.

    Attributes:
        nodes: of the bottom chord.
        supports: names of the supported nodes.
        span_m: of the grid.
        limit_mm: span / limit.
        worst: name of the node that hangs lowest.
        worst_mm, worst_sigma_mm: its sag.
        ratio: n of 1/n, span over the largest sag; inf where nothing hangs.
        over: whether the largest sag exceeds the limit.
        over_probability: probability that it does, given its sigma.
    """

    nodes: tuple[Sag, ...]
    supports: tuple[str, ...]
    span_m: float
    limit_mm: float
    worst: str
    worst_mm: float
    worst_sigma_mm: float
    ratio: float
    over: bool
    over_probability: float


def measure_deflection(
    nodes: Sequence[Node], columns: Sequence[Column], span_m: float | None, options: DeflectionOptions
) -> Deflection:
    """Measure how the bottom chord hangs.

    Args:
        nodes: all nodes.
        columns: all columns: the balls over them are the supports.
        span_m: of the grid; None: the shorter side of the supports' rectangle.
        options: limit.

    Raises:
        StageError: fewer than two supported balls.
    """
    supports = [node for node in nodes if _is_support(node, columns, options)]
    if len(supports) < 2:
        raise StageError(
            STAGE,
            f"{len(supports)} nodes stand on columns, and the line or plane of the supports needs two",
            "scan the heads of the columns from more sides, or leave the deflection out",
        )
    places = np.array([_place(n)[0] for n in supports])
    origin, design = places.mean(axis=0), _design(places)
    weight = np.diag([1 / _place(n)[1] for n in supports])
    normal = design.T @ weight @ design
    gain = np.linalg.solve(normal, design.T @ weight)
    plane = gain @ (places[:, 2] - origin[2])
    near = _near_plane(nodes, places, plane, origin, options)
    sags = []
    for node in near:
        here = _place(node)[0]
        row = _row(here - origin, places - origin)
        drop = float(row @ plane - (here[2] - origin[2]))
        sigma = _sigma(node, supports, row @ gain)
        is_support = any(node is s for s in supports)
        sags.append(
            Sag(
                node=node.name,
                place_m=here,
                sag_mm=1000 * drop,
                sigma_mm=1000 * sigma,
                support=is_support,
            )
        )
    worst = max(sags, key=lambda s: s.sag_mm)
    span = _span(places) if span_m is None else span_m
    allowed = 1000 * span / options.limit
    return Deflection(
        nodes=tuple(sags),
        supports=tuple(n.name for n in supports),
        span_m=span,
        limit_mm=allowed,
        worst=worst.node,
        worst_mm=worst.sag_mm,
        worst_sigma_mm=worst.sigma_mm,
        ratio=1000 * span / worst.sag_mm if worst.sag_mm > 0 else float("inf"),
        over=worst.sag_mm > allowed,
        over_probability=float(norm.cdf((worst.sag_mm - allowed) / max(worst.sigma_mm, 1e-9))),
    )


def _is_support(node: Node, columns: Sequence[Column], options: DeflectionOptions) -> bool:
    """Tell whether a column ends right below the node's ball."""
    for column in columns:
        if node.column and node.column == column.member:
            return True
        place, ball_m = _place(node)[0], float(np.nan_to_num(node.diameter_mm / 1000))
        away, rise = float(np.hypot(*(place - column.top_m)[:2])), float(place[2]) - column.seen_m[1]
        if away < options.support_m and 0 < rise < options.support_m + 0.5 * ball_m:
            return True
    return False


def _place(node: Node) -> tuple[Array, float]:
    """Where a node is, (3,) metres, and the variance of its height, m^2."""
    if np.isfinite(node.rods_m).all():
        return node.rods_m, float(node.rods_covariance[2, 2])
    return node.ball_m, float(node.ball_covariance[2, 2])


def _design(places: Array) -> Array:
    """Rows of the reference's equations about the supports' mean."""
    local = places - places.mean(axis=0)
    return np.array([_row(p, local) for p in local])


def _row(local: Array, supports: Array) -> Array:
    """Height of the reference at a place: a plane, or along one line where the supports lie on one."""
    _, spread, axes = np.linalg.svd(supports[:, :2], full_matrices=False)
    if len(supports) < 3 or spread[1] < 0.05 * spread[0]:
        return np.array([1.0, float(local[:2] @ axes[0])])
    return np.array([1.0, *local[:2]])


def _near_plane(
    nodes: Sequence[Node], supports: Array, plane: Array, origin: Array, options: DeflectionOptions
) -> list[Node]:
    """The nodes of the bottom chord: those near the supports' reference, the next layer being far."""
    rise = np.array(
        [
            p[2] - origin[2] - _row(p - origin, supports - origin) @ plane
            for p in (_place(n)[0] for n in nodes)
        ]
    )
    if options.chord_m is not None:
        reach = options.chord_m
    else:
        ordered = np.sort(rise)
        steps = np.diff(ordered)
        # the first wide step above the supports parts the chords
        wide = [k for k in range(len(steps)) if steps[k] > 0.4 and ordered[k + 1] > 0.2]
        reach = 0.5 * float(ordered[wide[0]] + ordered[wide[0] + 1]) if wide else float("inf")
    return [node for node, r in zip(nodes, rise, strict=True) if abs(r) < max(reach, 0.05)]


def _sigma(node: Node, supports: list[Node], shares: Array) -> float:
    """Standard deviation of a node's sag, metres; a support is itself part of the reference."""
    total, own = 0.0, 1.0
    for support, share in zip(supports, shares.tolist(), strict=True):
        if support is node:
            own -= share
        else:
            total += share**2 * _place(support)[1]
    return float(np.sqrt(total + own**2 * _place(node)[1]))


def _span(supports: Array) -> float:
    """Shorter side of the rectangle around the supports, along their main directions; metres."""
    local = (supports - supports.mean(axis=0))[:, :2]
    _, _, axes = np.linalg.svd(local, full_matrices=False)
    sides = np.ptp(local @ axes.T, axis=0)
    return float(sides.min() if sides.min() > 0.05 * sides.max() else sides.max())
