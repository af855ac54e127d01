"""Members, nodes and deflection of a run as rows of the report.  Computes nothing but units."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from pipeline.report.steel.structure_rows import (
    BallRow,
    DeflectionRow,
    DeflectionSummary,
    MemberRow,
    NodeRow,
    Place,
)
from pipeline.steel.deflection import Deflection
from pipeline.steel.member_records import Members, Rod
from pipeline.steel.nodes import Node


def rods_of(rods: Sequence[Rod]) -> tuple[MemberRow, ...]:
    """Rods or columns."""
    return tuple(
        MemberRow(
            name=rod.name,
            start_m=place(rod.start),
            end_m=place(rod.end),
            radius_mm=1000 * rod.radius_m,
            radius_sigma_mm=1000 * float(np.sqrt(rod.covariance[4, 4])),
            rms_mm=1000 * rod.rms_m,
            points=rod.points,
        )
        for rod in rods
    )


def balls_of(members: Members) -> tuple[BallRow, ...]:
    """All balls."""
    return tuple(
        BallRow(
            name=ball.name,
            centre_m=place(ball.centre),
            radius_mm=1000 * ball.radius_m,
            sigma_mm=1000 * float(np.sqrt(np.mean(np.diag(ball.covariance)[:3]))),
            rms_mm=1000 * ball.rms_m,
            points=ball.points,
        )
        for ball in members.balls
    )


def nodes_of(nodes: Sequence[Node]) -> tuple[NodeRow, ...]:
    """All nodes, those without eccentricity (one rod) included."""
    return tuple(
        NodeRow(
            name=node.name,
            ball_m=place(node.ball_m),
            radius_mm=node.diameter_mm / 2,
            rods_m=place(node.rods_m),
            by_perpendiculars_m=place(node.perpendicular_m),
            eccentricity_mm=place(node.eccentricity_mm),
            size_mm=node.amount_mm,
            sigma_mm=node.sigma_mm,
            significant=node.significant,
            rods=node.rods,
        )
        for node in nodes
    )


def deflection_of(deflection: Deflection) -> DeflectionSummary:
    """The grid against its limit."""
    return DeflectionSummary(
        span_m=deflection.span_m,
        limit_mm=deflection.limit_mm,
        largest_mm=deflection.worst_mm,
        largest_node=deflection.worst,
        largest_sigma_mm=deflection.worst_sigma_mm,
        over_limit=deflection.over,
        rows=tuple(
            DeflectionRow(
                node=sag.node,
                position_m=place(sag.place_m),
                deflection_mm=sag.sag_mm,
                sigma_mm=sag.sigma_mm,
                support=sag.support,
            )
            for sag in deflection.nodes
        ),
    )


def place(values: ArrayLike) -> Place:
    """Three numbers."""
    x, y, z = np.asarray(values, dtype=float).tolist()
    return x, y, z
