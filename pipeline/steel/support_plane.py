"""What a grid's deflection is measured from: the supported nodes and the plane or level line through them.

Takes nodes and columns; gives the plane, how it follows its supports, and which nodes belong to the chord
that it carries.  Leaves out sags and verdicts (deflection.py).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.core.vocabulary import Array
from pipeline.steel.columns import Column
from pipeline.steel.joint import Part
from pipeline.steel.nodes import Node


@dataclass(frozen=True)
class SupportPlane:
    """The plane through the supports; where they lie on one line, level across it.

    Attributes:
        supports: the nodes that it goes through.
        places: (n, 3) theirs, site frame, metres.
        up: (3,) which way heights are counted, its z is 1.
        gain: (k, n) how its k parameters follow the supports' heights.
    """

    supports: tuple[Node, ...]
    places: Array
    up: Array
    gain: Array

    def shares(self, place: Array) -> Array:
        """(n,) how the plane's height at a place follows the supports' heights."""
        origin = self.places.mean(axis=0)
        return np.asarray(_row(place - origin, self.places - origin) @ self.gain)

    def rise_m(self, place: Array) -> float:
        """How far a place lies above."""
        origin = self.places.mean(axis=0)
        return float((place - origin) @ self.up - self.shares(place) @ ((self.places - origin) @ self.up))


def plane_through(supports: Sequence[Node], up: Array) -> SupportPlane:
    """The plane by least squares, each support weighted with the variance of its height."""
    places = np.array([node_place(node) for node in supports])
    local = places - places.mean(axis=0)
    design = np.array([_row(p, local) for p in local])
    weight = np.diag([1 / _height_variance(node) for node in supports])
    gain = np.linalg.solve(design.T @ weight @ design, design.T @ weight)
    return SupportPlane(supports=tuple(supports), places=places, up=up, gain=gain)


def node_place(node: Node) -> Array:
    """(3,) where a node is, metres: where its rods meet, else the centre of its ball."""
    return node.rods_m if _by_rods(node) else node.ball_m


def node_part(node: Node, gain: Array) -> Part:
    """The part of a linear function that follows a node's place by (m, 3)."""
    if _by_rods(node):
        return Part(gain=gain, noise=node.rods_noise, share=node.rods_share)
    return Part(gain=gain @ np.eye(3, 4), noise=node.ball_noise, share=node.ball_share)


def is_support(node: Node, columns: Sequence[Column], reach_m: float) -> bool:
    """Tell whether a column ends right below the node's ball, seen from above within ``reach_m``."""
    for column in columns:
        if node.column and node.column == column.member:
            return True
        place, ball_m = node_place(node), float(np.nan_to_num(node.diameter_mm / 1000))
        away, rise = float(np.hypot(*(place - column.top_m)[:2])), float(place[2]) - column.seen_m[1]
        if away < reach_m and 0 < rise < reach_m + 0.5 * ball_m:
            return True
    return False


def bottom_chord(nodes: Sequence[Node], plane: SupportPlane, reach_m: float | None) -> list[Node]:
    """The nodes near the supports' plane: up to ``reach_m``, or up to the gap before the next layer."""
    rise = np.array([plane.rise_m(node_place(node)) for node in nodes])
    if reach_m is None:
        ordered = np.sort(rise)
        steps = np.diff(ordered)
        # the first wide step above the supports parts the chords
        wide = [k for k in range(len(steps)) if steps[k] > 0.4 and ordered[k + 1] > 0.2]
        reach_m = 0.5 * float(ordered[wide[0]] + ordered[wide[0] + 1]) if wide else float("inf")
    return [node for node, r in zip(nodes, rise, strict=True) if abs(r) < max(reach_m, 0.05)]


def span_of(supports: Array) -> float:
    """Shorter side of the rectangle around (n, 3) supports, along their main directions; metres."""
    local = (supports - supports.mean(axis=0))[:, :2]
    _, _, axes = np.linalg.svd(local, full_matrices=False)
    sides = np.ptp(local @ axes.T, axis=0)
    return float(sides.min() if sides.min() > 0.05 * sides.max() else sides.max())


def _by_rods(node: Node) -> bool:
    return bool(np.isfinite(node.rods_m).all())


def _height_variance(node: Node) -> float:
    return float((node.rods_covariance if _by_rods(node) else node.ball_covariance)[2, 2])


def _row(local: Array, supports: Array) -> Array:
    """Height of the reference at a place: a plane, or along one line where the supports lie on one."""
    _, spread, axes = np.linalg.svd(supports[:, :2], full_matrices=False)
    if len(supports) < 3 or spread[1] < 0.05 * spread[0]:
        return np.array([1.0, float(local[:2] @ axes[0])])
    return np.array([1.0, *local[:2]])
