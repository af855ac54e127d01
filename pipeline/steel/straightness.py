"""How straight the rods of this structure are: by how much their axes pass each other where they meet.

Takes members and the rods of each node; gives one standard deviation for all rods, by which an axis may pass
its node across.  Fitted axes miss each other by their own errors (points' noise, stations' errors), which are
known, and by what rods are bent or set off at their ends, which is not: this is estimated from all nodes
together as a variance component (maximum likelihood of the misses in which the node's place has no part, as
in Koch, Parameter Estimation and Hypothesis Testing, 1999, section 3.6).  What is assumed beforehand counts
as one more observation, so that a structure of two nodes is not believed to be perfect.
"""

from collections.abc import Iterable, Sequence

import numpy as np
from scipy.optimize import brentq

from pipeline.core.vocabulary import Array
from pipeline.steel.joint import Part, joint_covariance
from pipeline.steel.member_records import Members, Rod

CLIPPED = 9.0
"""A miss counts as three sigmas at most: a rod that belongs to another node must not bend all of them."""
LEAST_M, MOST_M = 1e-7, 1.0
"""Between these the standard deviation is looked for."""


def axis_sigma(nodes: Iterable[tuple[Sequence[Rod], Array]], members: Members, assumed_m: float) -> float:
    """Standard deviation (metres, each way across) by which axes pass their nodes, besides their own errors.

    Args:
        nodes: rods of each and its rough place (3,), site frame, metres.
        members: that the rods are among.
        assumed_m: before anything was measured; 0: rods are straight.
    """
    if assumed_m <= 0:
        return 0.0
    misses = [_misses(rods, near, members) for rods, near in nodes if len(rods) >= 2]
    squares = np.concatenate([np.zeros(0), *(s for s, _ in misses)])
    variances = np.concatenate([np.zeros(0), *(v for _, v in misses)])

    def slope(log_sigma: float) -> float:
        """Derivative of the logarithm of the likelihood by the variance."""
        own = np.exp(2 * log_sigma)
        total = variances + own
        told = np.sum((np.minimum(squares / total, CLIPPED) - 1) / total)
        return float(told + (assumed_m**2 / own - 1) / own)

    return float(np.exp(brentq(slope, np.log(LEAST_M), np.log(MOST_M), xtol=1e-3)))


def axis_moves(along: float) -> Array:
    """(2, 5): how an axis moves across itself at a distance along it, per parameter of the cylinder."""
    return np.array([[1.0, 0.0, along, 0.0, 0.0], [0.0, 1.0, 0.0, along, 0.0]])


def axis_offset(rod: Rod, near: Array) -> Array:
    """(2,) where the axis passes a place (3,), across itself, metres."""
    return np.asarray(rod.frame[:2] @ (rod.place + float(rod.along(near)) * rod.direction - near))


def _misses(rods: Sequence[Rod], near: Array, members: Members) -> tuple[Array, Array]:
    """Independent parts of the axes' misses at a node, squared, and their variances if rods were straight."""
    design = np.concatenate([rod.frame[:2] for rod in rods])
    offsets = np.concatenate([axis_offset(rod, near) for rod in rods])
    parts = []
    for number, rod in enumerate(rods):
        gain = np.zeros((2 * len(rods), 5))
        gain[2 * number : 2 * number + 2] = axis_moves(float(rod.along(near)))
        parts.append(Part(gain=gain, noise=rod.noise_covariance, share=rod.share))
    covariance = joint_covariance(parts, members)
    # what no place of the node can explain; unbent rods' variance adds the same to each of its directions
    left, sizes, _ = np.linalg.svd(design)
    free = left[:, np.count_nonzero(sizes > 1e-3 * sizes[0]) :]
    variances, turn = np.linalg.eigh(free.T @ covariance @ free)
    return (turn.T @ free.T @ offsets) ** 2, np.maximum(variances, 0)
