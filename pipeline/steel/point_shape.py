"""How well targets are known along their rays and across, where the survey gives one sigma for both.

Takes the adjusted observations; gives the covariances of those points that were stated alike in all
directions, with as much of it along the ray as their residuals show.  A target noted from a single point is
mostly uncertain along the ray, the centre of a sphere through many points a little more across: one sigma for
both makes the result half as good and its own sigmas too small (``docs/decisions-steel.md``).  Leaves out the
size of it all, which is the kind's variance component.

Two components of one observation, as in Förstner (see ``variance.py``): in each direction P the weighted
squares of the residuals over what they should be, sum v' P v / sum tr P (Q - H).
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pipeline.steel.network import Network
from pipeline.steel.registration_options import RegisterOptions
from pipeline.steel.state import Component, Group
from pipeline.steel.variance import Tested

ALIKE = 1e-6
"""Stated variances that differ by less than this part are meant to be one."""
LEAST_SHARE, MOST_SHARE = 0.05, 0.9
"""Part of a target's variance that may lie along the ray; alike in all directions it is a third."""


def stated_alike(group: Group) -> NDArray[np.bool_]:
    """(n,) points whose covariance is one variance times the identity."""
    if group.component is not Component.POINT:
        return np.zeros(len(group.station), dtype=bool)
    variance = np.einsum("nii->n", group.cofactor) / 3
    off = np.abs(group.cofactor - variance[:, None, None] * np.eye(3)).max(axis=(1, 2))
    return np.asarray(off < ALIKE * variance)


def reshaped(
    group: Group,
    alike: NDArray[np.bool_],
    test: Tested,
    factor: float,
    network: Network,
    options: RegisterOptions,
) -> Group:
    """The group with new shapes for the points marked ``alike`` (n,); each keeps its mean variance.

    Args:
        group: as adjusted.
        alike: which observations to reshape.
        test: of the group.
        factor: variance of unit weight of points at the adjustment.
        network: where the points were seen.
        options: see there.
    """
    good = alike & (test.weight == 1) & (test.checked > 0)
    if not good.any():
        return group
    seen = network.places[group.observation]
    rays = seen / np.maximum(np.linalg.norm(seen, axis=1, keepdims=True), 1e-12)
    along = rays[:, :, None] * rays[:, None, :]
    mean = np.einsum("nii->n", group.cofactor) / 3
    variances, prior = [], options.prior_redundancy
    for direction in (along, np.eye(3) - along):
        size = np.einsum("nij,nji->n", direction, group.cofactor)
        square = np.einsum("ni,nij,nj->n", test.residuals, direction, test.residuals)
        left = np.einsum("nij,nji->n", direction, factor * group.cofactor - test.adjusted)
        # of targets stated better and worse, in units of what was stated
        weight = good / (factor * mean)
        told = (np.sum(weight * square) + prior) / (np.sum(weight * left) + prior)
        variances.append(told * float(np.median(size[good] / mean[good])))
    share = float(np.clip(variances[0] / sum(variances), LEAST_SHARE, MOST_SHARE))
    shape = 3 * share * along + 1.5 * (1 - share) * (np.eye(3) - along)
    cofactor = np.where(alike[:, None, None], mean[:, None, None] * shape, group.cofactor)
    return replace(group, cofactor=cofactor)
