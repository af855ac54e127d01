"""Deflection: how far the nodes of the bottom chord hang below the supports, against span / 250.

Takes nodes, columns, the plumb line and the span; gives the sag of each node of the bottom chord with its
sigma.  The reference is the plane through the supported nodes (those over columns), or the level line through
two of them.  A node is where its rods meet, the ball's centre where they do not tell: an eccentric ball is no
deflection, and the rods tell the place more sharply.  What node and supports have in common, as their
stations' errors, cancels in the sag as far as it does.  Leaves out the camber that the grid was built with:
it is not in the survey.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.stats import norm

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array
from pipeline.steel.columns import Column
from pipeline.steel.joint import joint_covariance
from pipeline.steel.member_records import Members
from pipeline.steel.nodes import Node
from pipeline.steel.records import Plumb
from pipeline.steel.support_plane import (
    SupportPlane,
    bottom_chord,
    is_support,
    node_part,
    node_place,
    plane_through,
    span_of,
)

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
    nodes: Sequence[Node],
    columns: Sequence[Column],
    members: Members,
    span_m: float | None,
    options: DeflectionOptions,
    plumb: Plumb | None = None,
) -> Deflection:
    """Measure how the bottom chord hangs.

    Args:
        nodes: all nodes.
        columns: all columns: the balls over them are the supports.
        members: that the nodes come from.
        span_m: of the grid; None: the shorter side of the supports' rectangle.
        options: limit.
        plumb: which way is up; None: the site's z, taken as exact.

    Raises:
        StageError: fewer than two supported balls.
    """
    supports = tuple(node for node in nodes if is_support(node, columns, options.support_m))
    if len(supports) < 2:
        raise StageError(
            STAGE,
            f"{len(supports)} nodes stand on columns, and the line or plane of the supports needs two",
            "scan the heads of the columns from more sides, or leave the deflection out",
        )
    # heights along the plumb line, lengths in plan as they are: to first order in its lean
    up = np.array([0.0, 0.0, 1.0]) if plumb is None else plumb.direction / plumb.direction[2]
    plane = plane_through(supports, up)
    chord = bottom_chord(nodes, plane, options.chord_m)
    return _judged(tuple(_sag(node, plane, members, plumb) for node in chord), plane, span_m, options)


def _sag(node: Node, plane: SupportPlane, members: Members, plumb: Plumb | None) -> Sag:
    """One node's sag and its sigma; a support is itself part of the reference."""
    here = node_place(node)
    involved = [*plane.supports, *([] if any(node is s for s in plane.supports) else [node])]
    weights = np.zeros(len(involved))
    weights[: len(plane.supports)] = plane.shares(here)
    weights[next(k for k, other in enumerate(involved) if other is node)] -= 1
    parts = [node_part(other, w * plane.up[None]) for other, w in zip(involved, weights, strict=True)]
    by_plumb = None
    if plumb is not None:
        # heights follow the plumb line's slopes by how far the places lie apart
        by_plumb = weights[None] @ np.array([node_place(other) for other in involved]) @ plumb.across.T
    covariance = joint_covariance(parts, members, by_plumb, plumb)
    return Sag(
        node=node.name,
        place_m=here,
        sag_mm=-1000 * plane.rise_m(here),
        sigma_mm=1000 * float(np.sqrt(covariance[0, 0])),
        support=len(involved) == len(plane.supports),
    )


def _judged(
    sags: tuple[Sag, ...], plane: SupportPlane, span_m: float | None, options: DeflectionOptions
) -> Deflection:
    """The largest sag against the limit."""
    worst = max(sags, key=lambda s: s.sag_mm)
    span = span_of(plane.places) if span_m is None else span_m
    allowed = 1000 * span / options.limit
    return Deflection(
        nodes=sags,
        supports=tuple(node.name for node in plane.supports),
        span_m=span,
        limit_mm=allowed,
        worst=worst.node,
        worst_mm=worst.sag_mm,
        worst_sigma_mm=worst.sigma_mm,
        ratio=1000 * span / worst.sag_mm if worst.sag_mm > 0 else float("inf"),
        over=worst.sag_mm > allowed,
        over_probability=float(norm.cdf((worst.sag_mm - allowed) / max(worst.sigma_mm, 1e-9))),
    )
