"""How segments bend against each other, and the axis of the whole cable as one curve.

Takes each :class:`AxisPart`: a segment's axis in its own frame, and the attitudes that its cameras had in it.
The cameras of the frames that two neighbours share stood but once: by how much further they lean out of the
one axis than out of the other, these lean out of each other.  Gives the :class:`WholeAxis`.  Nothing closes
the chain, so errors add up along it; a segment in which nothing was found breaks it.

Leans are small (of one segment out of the next, and of all out of the chord); turns about the cable need not
be.  What lies across the cable is a complex number, x + i z; lengths across it are mm, leans mm per m.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.core.vocabulary import Array
from pipeline.segments.plan import Segment
from pipeline.segments.traverse import AdjustedSegment, Placement

type Complex = NDArray[np.complex128]

HAND_OVER_POINTS = 20
"""Where two neighbours' curves are compared, over the frames that they share."""


@dataclass(frozen=True, kw_only=True)
class AxisPart:
    """One segment's share of the axis.

    Attributes:
        segment, adjusted, placement: of the segment.
        rotation: (3, 3) aligned_from_adjusted: lays its fitted axis on y.
        y_m: (n,) places along the whole cable, at least two, over all of the segment.
        centre_mm: (n, 2) the axis there, x and z of the segment's aligned frame.
    """

    segment: Segment
    adjusted: AdjustedSegment
    placement: Placement
    rotation: Array
    y_m: Array
    centre_mm: Array

    @property
    def turned(self) -> complex:
        """Turns what lies across the cable from the segment's azimuths to the whole's."""
        return complex(np.exp(-1j * self.placement.roll))

    @property
    def curve_mm(self) -> Complex:
        """(n,) its axis, in the whole's azimuths."""
        return self.turned * (self.centre_mm[:, 0] + 1j * self.centre_mm[:, 1])

    @property
    def frames_m(self) -> Array:
        """(frames,) where they were, along the whole cable."""
        return self.placement.start_m + self.placement.scale * self.adjusted.path.y_m


@dataclass(frozen=True, kw_only=True)
class WholeAxis:
    """The axis of an unbroken chain of segments, and what its segments lean by.

    Attributes:
        y_m: (n,) places along the cable, each told by one segment.
        centre_mm: (n, 2) distance from the straight line that fits best, x and z of the whole.
        bow_mm: (n, 2) distance from the chord between the first place and the last.
        sigma_mm: (n,) standard deviation of the bow, along x and along z.
        straightness_mm_per_m: largest distance from the straight line that fits best, over the length.
        bend_mm_per_m: (segments - 1, 2) by how much each segment's fitted axis leans towards x and z, out of
            that of the segment before.
        bend_sigma_mm_per_m: (segments - 1,) standard deviation of either.
    """

    y_m: Array
    centre_mm: Array
    bow_mm: Array
    sigma_mm: Array
    straightness_mm_per_m: float
    bend_mm_per_m: Array
    bend_sigma_mm_per_m: Array


def whole_axis(parts: Sequence[AxisPart], *, to_the_end: bool) -> WholeAxis:
    """Lay the segments' axes behind each other.

    Args:
        parts: neighbours, each sharing frames with the next.
        to_the_end: whether the last one is that of the survey, and tells all it has.
    """
    chain = _Chain(parts, to_the_end=to_the_end)
    bends = np.array([_bend(one, other) for one, other in pairwise(parts)], dtype=complex)
    axis_mm = chain.laid([p.curve_mm for p in parts], bends)
    share = (chain.y_m - chain.y_m[0]) / (chain.y_m[-1] - chain.y_m[0])
    within = (share > 0) & (share < 1)
    variance = within * (1 + share**2 + (1 - share) ** 2) * np.mean([_noise_mm(p) ** 2 for p in parts])
    bend_variance = np.zeros(len(bends))
    for number in range(len(parts)):
        curves, leans = _errors(parts, number)
        variance += np.sum(_bow(share, chain.laid(curves, leans)) ** 2, axis=0)
        bend_variance += np.sum(leans**2, axis=0)
    line = np.column_stack([np.ones_like(share), share])
    away = axis_mm - line @ (np.linalg.pinv(line) @ axis_mm)
    return WholeAxis(
        y_m=chain.y_m,
        centre_mm=_both(away),
        bow_mm=_both(_bow(share, axis_mm)),
        sigma_mm=np.sqrt(variance),
        straightness_mm_per_m=float(np.abs(away).max() / (chain.y_m[-1] - chain.y_m[0])),
        bend_mm_per_m=_both(bends),
        bend_sigma_mm_per_m=np.sqrt(bend_variance),
    )


def _bend(one: AxisPart, other: AxisPart) -> complex:
    """By how much the other's axis leans out of the one's: mean of all cameras over the frames they share."""
    shared = np.arange(other.segment.first, one.segment.last + 1)
    first = one.adjusted.rotations[:, shared - one.segment.first]
    second = other.adjusted.rotations[:, shared - other.segment.first]
    axis_in_cameras = first @ one.rotation[1]
    axis_in_other = np.einsum("cfji,cfj->cfi", second, axis_in_cameras) @ other.rotation.T
    x, y, z = axis_in_other.mean(axis=(0, 1))
    return -1000 * complex(x, z) / float(y) * other.turned


class _Chain:
    """Lays curves of the parts one behind the other.

    Attributes:
        y_m: (n,) places along the cable: of each part, those between its hand-overs.
    """

    def __init__(self, parts: Sequence[AxisPart], *, to_the_end: bool) -> None:
        self._places_m = [p.y_m for p in parts]
        self._told = [
            np.array([p.placement.here(y, to_the_end and p is parts[-1]) for y in p.y_m], dtype=bool)
            for p in parts
        ]
        self.y_m = np.concatenate([y[told] for y, told in zip(self._places_m, self._told, strict=True)])
        self._means = []
        for one, other in pairwise(parts):
            around_m = np.linspace(other.frames_m[0], one.frames_m[-1], HAND_OVER_POINTS)
            self._means.append((_mean_over(one.y_m, around_m), _mean_over(other.y_m, around_m)))

    def laid(self, curves: Sequence[NDArray[Any]], bends: NDArray[Any]) -> NDArray[Any]:
        """The curves (..., n of the part), each leaning out of the one before by ``bends`` (..., parts - 1).

        Where one hands over to the next, this goes on from it, on the mean over the frames that they share.
        """
        laid: list[NDArray[Any]] = [curves[0]]
        lean = np.zeros(bends.shape[:-1])
        for number, (before, here) in enumerate(self._means, start=1):
            lean = lean + bends[..., number - 1]
            line = curves[number] + lean[..., None] * self._places_m[number]
            laid.append(line + (laid[-1] @ before - line @ here)[..., None])
        return np.concatenate([line[..., t] for line, t in zip(laid, self._told, strict=True)], axis=-1)


def _mean_over(y_m: Array, around_m: Array) -> Array:
    """Weights (n,) of a curve's values at ``y_m`` in its mean over some places."""
    return np.array([np.interp(around_m, y_m, one).mean() for one in np.eye(len(y_m))])


def _errors(parts: Sequence[AxisPart], number: int) -> tuple[list[Array], Array]:
    """What one segment's errors do to curves (k, n) and bends (k, parts - 1), in k independent ways.

    The columns of a square root of its covariance, each of one standard deviation.  The axis is carried by
    the cameras: where the adjustment shifts or turns them, it shifts and turns the cable that they see.  The
    segment's fitted axis takes away a shift and a lean of the whole.  Errors of the frames that two segments
    share are taken for independent, although both see the same pictures: that is careful.
    """
    part = parts[number]
    frames_m, covariance = part.frames_m, part.adjusted.path.across_covariance
    values, vectors = np.linalg.eigh(covariance)
    places, leans = np.split(1000 * vectors * np.sqrt(np.maximum(values, 0)), 2)
    design = np.column_stack([np.ones(len(frames_m)), frames_m])
    offset_and_lean = np.linalg.pinv(design) @ places
    places, leans = places - design @ offset_and_lean, leans - offset_and_lean[1]
    curves = [np.zeros((len(values), len(p.y_m))) for p in parts]
    curves[number] = np.array([np.interp(part.y_m, frames_m, column) for column in places.T])
    bends = np.zeros((len(values), len(parts) - 1))
    if number:
        shared = parts[number - 1].segment.last - part.segment.first + 1
        bends[:, number - 1] = -leans[:shared].mean(axis=0)
    if number < len(parts) - 1:
        shared = part.segment.last - parts[number + 1].segment.first + 1
        bends[:, number] = leans[-shared:].mean(axis=0)
    return curves, bends


def _noise_mm(part: AxisPart) -> float:
    """Of a single place, along x or z, from how its neighbours' mean misses it; a bend does not count."""
    if len(part.y_m) < 3:
        return 0.0
    missed = part.centre_mm[1:-1] - (part.centre_mm[:-2] + part.centre_mm[2:]) / 2
    return float(np.median(np.abs(missed)) / 0.6745 / np.sqrt(1.5))


def _bow(share: Array, axis: NDArray[Any]) -> NDArray[Any]:
    """Distance (..., n) from the chord between the first place and the last."""
    return axis - axis[..., :1] * (1 - share) - axis[..., -1:] * share


def _both(across: Complex) -> Array:
    return np.stack([across.real, across.imag], axis=-1)
