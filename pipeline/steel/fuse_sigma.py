"""How well two clouds hold each other: covariance of the seven parameters, and what nothing determines.

Takes laid points; gives covariance and directions.

Neighbouring residuals err alike (a photo model bends, a depth map is off by patches, a station stands a
little beside its place), so dividing by the root of the number of points would be dishonest.  The covariance
is how far the result moves when one patch after the other is left out: the delete-a-group jackknife, which
unlike the plain sandwich does not forget that patches with leverage bend the fit towards themselves (A. C.
Cameron and D. L. Miller, "A practitioner's guide to cluster-robust inference", J. Human Resources 50(2),
2015, section VI.B).  Patches grow until few are left; the largest answer counts, and what the residuals show
in the largest patches stands for bends as long as the cloud.

Whether a motion is determined must not rest on noise either: rough normals of a perfect cylinder seem to hold
its turn.  The information is therefore the product of the *two* clouds' own normals, whose noises are
independent and cancel; what stays is relief that both show.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.core.rotations import cross_matrix
from pipeline.core.vocabulary import Array
from pipeline.steel.fuse_records import Direction
from pipeline.steel.point_match import Laid, extent, unit_jacobian, unit_of
from pipeline.steel.scanned_surface import cube_of

LEAST_PATCHES = 10
"""Fewer patches say nothing about their scatter."""
LONG_WAVES = 8.0
"""What is left of the distances in the largest patches is part of a bend as long as the cloud, most of which
the seven parameters took up unseen: it counts as if there were so many independent places only."""
CLEARLY = 4.0
"""Information must exceed its own standard deviation so many times."""


@dataclass(frozen=True, kw_only=True)
class Held:
    """Covariance (7, 7) in radians, metres and relative scale; directions, best first; (7, h) the
    undetermined motions, orthonormal, in metres at the cloud's edge; the patch size that counted, metres."""

    covariance: Array
    directions: tuple[Direction, ...]
    undetermined: Array
    patch_m: float


@dataclass(frozen=True, kw_only=True)
class StartSigma:
    """What a start is worth.

    Attributes:
        name: what held it; "" where nothing did.
        spread: (7, 7) covariance of (rotation, translation, relative scale) about ``place``.
        place: (3,) metres.
    """

    name: str
    spread: Array
    place: Array

    def covariance(self, centre: Array, extent_m: float) -> Array:
        """(7, 7) about another centre, in metres at the cloud's edge."""
        away = centre - self.place
        move = np.eye(7)
        move[3:6, :3] = -cross_matrix(away)
        move[3:6, 6] = away
        unit = unit_of(extent_m)
        return np.asarray(move @ self.spread @ move.T * np.outer(unit, unit))


def judge(laid: Laid, undetermined_m: float, start: StartSigma, axis: Array | None) -> Held:
    """Covariance and directions of a laid cloud.

    Args:
        laid: at the solution.
        undetermined_m: a motion with a larger sigma is undetermined by the points.
        start: what held the cloud before them, and holds it still where they do not.
        axis: (3,) direction of a cable, for the words; None for anything else.
    """
    unit = extent(laid)
    away = laid.places - laid.centre
    by_scan = unit_jacobian(away, laid.scan_normals, unit)
    by_photo = unit_jacobian(away, laid.photo_normals, unit)
    weighted = by_scan * laid.weights[:, None]
    common = (weighted.T @ by_photo + by_photo.T @ weighted) / 2
    values, motions = np.linalg.eigh(common)
    values, motions = values[::-1], motions[:, ::-1]
    covariance, patch = _clustered(laid, by_scan, weighted.T @ by_scan, unit)
    certain = _certain(laid, by_scan @ motions, by_photo @ motions, values, unit)
    sigmas = np.sqrt(np.einsum("ij,ik,kj->j", motions, covariance, motions))
    # where noise made up part of the information, the sigma was taken too small by that part
    apparent = np.einsum("ij,ik,kj->j", motions, weighted.T @ by_scan, motions)
    sigmas = sigmas * np.maximum(apparent / np.maximum(values, 1e-12), 1.0)
    from_start = motions.T @ start.covariance(laid.centre, unit) @ motions
    known = certain & (sigmas < undetermined_m) & (sigmas < np.sqrt(np.diag(from_start)))
    sigmas = np.where(known, sigmas, np.sqrt(np.diag(from_start)))
    kept = np.where(
        known[:, None] & known,
        motions.T @ covariance @ motions,
        np.where(known[:, None] | known, 0, from_start),
    )
    grow = sigmas / np.sqrt(np.maximum(np.diag(kept), 1e-300))
    full = motions @ (kept * np.outer(grow, grow)) @ motions.T
    directions = tuple(
        Direction(
            motion=motions[:, k] / unit_of(unit),
            sigma_mm=1000 * float(sigmas[k]),
            held_by="points" if known[k] else start.name,
            words=_words(motions[:, k], axis),
        )
        for k in range(7)
    )
    return Held(
        covariance=full / np.outer(unit_of(unit), unit_of(unit)),
        directions=directions,
        undetermined=motions[:, ~known],
        patch_m=patch,
    )


def _clustered(laid: Laid, rows: Array, normal: Array, unit: float) -> tuple[Array, float]:
    """Clustered covariance in metres at the edge, the largest over patch sizes, and that patch's size."""
    pulls = rows * (laid.weights * laid.distances)[:, None]
    ridge = 1e-9 * np.trace(normal) * np.eye(7)
    best, best_patch, widest = np.zeros((7, 7)), 0.0, np.zeros(7)
    size = unit / 32
    while size < 2 * unit:
        patch = cube_of(laid.places, size)
        count = int(patch.max()) + 1
        if count < LEAST_PATCHES:
            break
        covariance = _jackknife(rows, pulls, laid.weights, patch, normal + ridge)
        widest = np.maximum(widest, np.diag(covariance))
        if np.trace(covariance) > np.trace(best):
            best, best_patch = covariance, size
        size *= np.sqrt(2)
    if not best.any():
        # everything within a few patches: as if each were one observation
        return np.linalg.inv(normal + ridge) * laid.noise_m**2 * len(rows) / LEAST_PATCHES, size
    grow = np.sqrt(widest / np.maximum(np.diag(best), 1e-300))
    long = (
        np.linalg.inv(normal + ridge) * laid.weights.sum() * _long_wave(laid, size / np.sqrt(2)) / LONG_WAVES
    )
    return best * np.outer(grow, grow) + long, best_patch


def _long_wave(laid: Laid, patch_m: float) -> float:
    """Variance of the mean distance in the largest patches, m^2, made good for the seven parameters."""
    patch = cube_of(laid.places, patch_m)
    weight = np.bincount(patch, laid.weights)
    mean = np.bincount(patch, laid.weights * laid.distances) / np.maximum(weight, 1e-9)
    full = weight > 0.1 * weight.mean()
    count = np.count_nonzero(full)
    return float(np.sum(mean[full] ** 2) / max(count - 7, count / 3))


def _jackknife(rows: Array, pulls: Array, weights: Array, patch: NDArray[np.int64], normal: Array) -> Array:
    """Covariance (7, 7) from leaving out one patch after the other."""
    count = int(patch.max()) + 1
    mine = np.empty((count, 7, 7))
    for i in range(7):
        for j in range(i + 1):
            mine[:, i, j] = mine[:, j, i] = np.bincount(patch, weights * rows[:, i] * rows[:, j])
    sums = np.stack([np.bincount(patch, column) for column in pulls.T], axis=1)
    # where a patch alone holds a motion, it is not left out altogether
    moves = np.linalg.solve(normal - 0.95 * mine, sums[..., None])[..., 0]
    return np.asarray(moves.T @ moves * (count - 1) / count)


def _certain(laid: Laid, by_scan: Array, by_photo: Array, values: Array, unit: float) -> np.ndarray:
    """(7,) whether the clouds' common information along each motion exceeds its own uncertainty."""
    share = laid.weights[:, None] * by_scan * by_photo
    patch = cube_of(laid.places, unit / 16)
    sums = np.stack([np.bincount(patch, column) for column in share.T], axis=1)
    return np.asarray(values > CLEARLY * np.sqrt(np.sum(sums**2, axis=0) - values**2 / len(sums)).clip(0))


def _words(motion: Array, axis: Array | None) -> str:
    """What the motion mainly is."""
    parts = {"turn": motion[:3], "shift": motion[3:6]}
    sizes = {name: float(np.linalg.norm(vector)) for name, vector in parts.items()}
    if abs(motion[6]) > max(sizes.values()):
        return "the scale"
    name = max(sizes, key=lambda key: sizes[key])
    towards = parts[name] / sizes[name]
    if axis is not None and abs(towards @ axis) > 0.9:
        return "a turn about the cable's axis" if name == "turn" else "a shift along the cable's axis"
    towards = towards * np.sign(towards[np.argmax(np.abs(towards))])
    place = ", ".join(f"{value:.2f}" for value in towards)
    return f"a {'turn about' if name == 'turn' else 'shift along'} ({place})"
