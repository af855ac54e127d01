"""The traverse: scale, place and roll of every segment, from what neighbours share and from the whole travel.

Each segment was adjusted with its nominal travel taken as exact, for only the ends of the whole travel are
known: between them the robot's speed wanders.  What it found is right up to a scale.  Three things tie the
scales: the robot's way over the frames that two neighbours share, the size of the ring of cameras, which is
the same rig all along, and the travel as a whole, which gives the one scale that pictures cannot.  The
adjustment is that of a traverse between two known points (Ghilani, *Adjustment Computations*, 6th edition,
2017, chapter 16), with scales in the place of angles.

How the robot turns about the cable follows from the cameras' attitudes in the shared frames.

Takes each :class:`AdjustedSegment`; gives a :class:`Placement` each.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pipeline.cable.joint_path import RingPath
from pipeline.core.rotations import vector_from_rotation
from pipeline.core.vocabulary import Array
from pipeline.segments.plan import Segment, TraverseOptions

UNSEEN_SHARE = 0.02
"""How far the robot's speed may be from its mean where no picture tells, relative."""
STEPS = 20
"""Of the adjustment: two are enough to the last digit, its variance factor takes some more."""


@dataclass(frozen=True, kw_only=True)
class AdjustedSegment:
    """What is kept of an adjusted segment.

    Attributes:
        path: the robot's way and the size of its ring.
        rotations: (cameras, frames, 3, 3) cam_from_cable; no cameras where nothing was found.
    """

    path: RingPath
    rotations: Array


@dataclass(frozen=True, kw_only=True)
class Placement:
    """Where a segment lies in the whole cable.

    Attributes:
        scale: of its lengths, as adjusted with its nominal travel.
        scale_sigma: standard deviation of the scale, the travel's own error included.
        start_m: place of its frame's origin, true metres from the first frame of the survey.
        from_m, to_m: the part of the cable that is told from this segment, not from a neighbour.
        roll: added to its azimuths gives those of the first segment, radians.
        link_ppm: how far the scale from the frames shared with the next segment differs from the adjusted
            one; NaN for the last.
    """

    scale: float
    scale_sigma: float
    start_m: float
    from_m: float
    to_m: float
    roll: float
    link_ppm: float

    def here(self, position_m: float, last: bool) -> bool:
        """Whether a place of the cable is told from this segment; the last one has its end as well."""
        return self.from_m <= position_m < self.to_m or (last and position_m >= self.to_m)


def close_traverse(
    segments: tuple[Segment, ...],
    adjusted: tuple[AdjustedSegment, ...],
    travel_m: float,
    travel_sigma_m: float,
    known: TraverseOptions,
) -> tuple[Placement, ...]:
    """Adjust the segments' scales and lay them one behind the other.

    Args:
        segments: at least two, each sharing frames with the next.
        adjusted: each in its own frame.
        travel_m, travel_sigma_m: of the whole survey, first frame to last.
        known: how well rings and links are known beyond what the adjustments tell.
    """
    paths = tuple(a.path for a in adjusted)
    links = [_link(a, b, p, q) for (a, b), (p, q) in zip(pairwise(segments), pairwise(paths), strict=True)]
    hands = [_hand_over(a, b) for a, b in pairwise(segments)]
    lengths = _lengths(segments, paths, hands)
    scales, covariance = _adjusted(paths, links, lengths, travel_m, travel_sigma_m, known)
    between = np.diff(np.log(scales))
    gaps = [1e6 * (ratio - float(b)) for (ratio, _), b in zip(links, between, strict=True)]
    reached = np.concatenate([[0.0], np.cumsum(scales * lengths)])
    starts = [
        reached[n] - scales[n] * path.y_m[_begin(segment, hands, n) - segment.first]
        for n, (segment, path) in enumerate(zip(segments, paths, strict=True))
    ]
    rolls = _rolls(segments, adjusted)
    return tuple(
        Placement(
            scale=float(scales[n]),
            scale_sigma=float(scales[n] * np.sqrt(covariance[n, n])),
            start_m=float(starts[n]),
            from_m=float(reached[n]),
            to_m=float(reached[n + 1]),
            roll=rolls[n],
            link_ppm=float(gaps[n]) if n < len(gaps) else float("nan"),
        )
        for n in range(len(segments))
    )


def unseen_segment(nominal_m: Array, size_m: float) -> AdjustedSegment:
    """What stands for a segment in which nothing was found: its nominal places, known to UNSEEN_SHARE.

    Args:
        nominal_m: (frames,) places along the cable.
        size_m: of the ring, from the other segments.
    """
    spread_m = float(np.linalg.norm(nominal_m - nominal_m.mean()))
    path = RingPath(
        y_m=nominal_m - nominal_m[0],
        covariance_m2=(UNSEEN_SHARE * spread_m) ** 2 * np.eye(len(nominal_m)),
        size_m=size_m,
        size_sigma_m=UNSEEN_SHARE * size_m,
        across_covariance=np.zeros((2 * len(nominal_m), 2 * len(nominal_m))),
    )
    return AdjustedSegment(path=path, rotations=np.zeros((0, len(nominal_m), 3, 3)))


def _rolls(segments: tuple[Segment, ...], adjusted: tuple[AdjustedSegment, ...]) -> list[float]:
    """Each segment's azimuths in the first one's, radians: turn by turn over the frames that two share."""
    rolls = [0.0]
    for (one, other), (a, b) in zip(pairwise(segments), pairwise(adjusted), strict=True):
        shared = np.arange(other.first, one.last + 1)
        first, second = a.rotations[:, shared - one.first], b.rotations[:, shared - other.first]
        if not first.size or not second.size:
            rolls.append(rolls[-1])
            continue
        other_from_one = np.swapaxes(second, -1, -2) @ first
        rolls.append(rolls[-1] - float(vector_from_rotation(other_from_one)[..., 1].mean()))
    return rolls


def _hand_over(one: Segment, other: Segment) -> int:
    """The frame where one segment ends and the next begins to tell: the middle one of those they share."""
    return (other.first + one.last) // 2


def _begin(segment: Segment, hands: list[int], number: int) -> int:
    return hands[number - 1] if number else segment.first


def _lengths(segments: tuple[Segment, ...], paths: tuple[RingPath, ...], hands: list[int]) -> Array:
    """Way between the hand-overs of each segment, in its own scale."""
    ends = [*hands, segments[-1].last]
    return np.array(
        [
            path.y_m[end - segment.first] - path.y_m[_begin(segment, hands, n) - segment.first]
            for n, (segment, path, end) in enumerate(zip(segments, paths, ends, strict=True))
        ]
    )


def _link(one: Segment, other: Segment, first: RingPath, second: RingPath) -> tuple[float, float]:
    """Logarithm of the second segment's scale over the first's from the frames they share, and its sigma.

    A straight line through the shared frames' places in both, of their joint covariance.
    """
    shared = range(other.first, one.last + 1)
    a = np.array([k - one.first for k in shared])
    b = np.array([k - other.first for k in shared])
    x, y = first.y_m[a], second.y_m[b]
    design = np.column_stack([np.ones_like(x), x - x.mean()])
    weight = np.linalg.inv(first.covariance_m2[np.ix_(a, a)] + second.covariance_m2[np.ix_(b, b)])
    covariance = np.linalg.inv(design.T @ weight @ design)
    slope = (covariance @ design.T @ weight @ y)[1]
    return -float(np.log(slope)), float(np.sqrt(covariance[1, 1])) / float(slope)


def _adjusted(
    paths: tuple[RingPath, ...],
    links: list[tuple[float, float]],
    lengths: Array,
    travel_m: float,
    travel_sigma_m: float,
    known: TraverseOptions,
) -> tuple[Array, Array]:
    """Scales (n,) and the covariance of their logarithms (n, n); the last unknown is the ring's true size.

    What rings and links contradict each other by, they are not worth: the variance factor of both together is
    estimated with the scales, and never taken below one.  A component for each would need far more segments:
    with four it believes one of the two and blames the other, at random.
    """
    count = len(paths)
    rings, between = np.arange(count), np.arange(count, 2 * count - 1)
    design = np.zeros((2 * count, count + 1))
    design[rings, rings], design[rings, count] = 1.0, -1.0
    design[between, rings[:-1]], design[between, rings[1:]] = -1.0, 1.0
    sizes = np.log([p.size_m for p in paths])
    observed = np.array([*-sizes, *(ratio for ratio, _ in links)])
    sigma = np.empty(2 * count)
    sigma[rings] = [np.hypot(p.size_sigma_m / p.size_m, known.ring_ppm / 1e6) for p in paths]
    sigma[between] = [np.hypot(s, known.link_ppm / 1e6) for _, s in links]
    # the travel binds: an error of its own beside what is known of it would be none of the pictures'
    sigma[-1] = max(travel_sigma_m / travel_m, 1e-9)
    unknown, factor = np.append(np.zeros(count), sizes.mean()), 1.0
    for _ in range(STEPS):
        parts = np.exp(unknown[:count]) * lengths
        design[-1, :count] = parts / travel_m
        wrong = np.append(observed - design[:-1] @ unknown, 1 - parts.sum() / travel_m)
        worth = np.append(factor * sigma[:-1], sigma[-1])
        weighted = design / worth[:, None]
        covariance = np.linalg.inv(weighted.T @ weighted)
        step = covariance @ weighted.T @ (wrong / worth)
        unknown = unknown + step
        left = (wrong - design @ step)[:-1] / sigma[:-1]
        factor = max(float(np.sqrt(left @ left / (count - 1))), 1.0)  # redundancy: one less than segments
    return np.exp(unknown[:count]), covariance[:count, :count]
