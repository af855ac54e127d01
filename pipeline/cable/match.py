"""Stage *match*: tie points along the sequence of one block, verified by epipolar geometry.

Takes the undistorted frames, their lens, the POS and the cable's rough radius; gives tie points in the
pixels of the *original* frames (what the camera measured, whatever the lens is later found to be).  Leaves
out points that
neighbouring blocks share: those come from the unrolled pictures, in mosaic.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pipeline.cable.sheets import Filmed
from pipeline.cable.tracking import Tracker, TrackOptions
from pipeline.core.axis import AxisCurve
from pipeline.core.division import pixels_to_rays, rays_to_pixels, undistorted_lens
from pipeline.core.epipolar import (
    calibration_matrix,
    fundamental_from_orientation,
    infinite_homography,
    reconstruct_projective,
    sampson_distances,
    second_epipole,
)
from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event, part
from pipeline.core.fundamental import FundamentalOptions, estimate_fundamental
from pipeline.core.pictures import read_grey
from pipeline.core.vocabulary import Array, FrameSequence, Lens, Poses, PosPriors

STRAIGHT = AxisCurve(origin_y_m=0.0, coefficients=np.zeros((2, 1)))
"""The y axis."""
MOST_PAIRS = 1000
"""So many pairs, spread evenly, tell the geometry to a tenth of the noise; all are judged by it."""


@dataclass(frozen=True, kw_only=True)
class MatchOptions:
    """How tie points are found and verified.

    Attributes:
        track: choice and following of points.
        epipolar_px: largest reprojection error of a pair's projective reconstruction.
        epipolar_step: frames between the two pictures of a verified pair.
        least_views: points seen in fewer frames are dropped.
        least_points: fewer points than this in a frame are an error.
        seed: of the random choice inside the estimation.
    """

    track: TrackOptions = field(default_factory=TrackOptions)
    epipolar_px: float = field(default=0.8, metadata={"above": 0.0})
    epipolar_step: int = field(default=3, metadata={"minimum": 1})
    least_views: int = field(default=3, metadata={"minimum": 2})
    least_points: int = field(default=25, metadata={"minimum": 8})
    seed: int = field(default=1, metadata={"minimum": 0})


@dataclass(frozen=True, kw_only=True)
class TiePoints:
    """Image measurements of one block, points numbered along the cable.

    Attributes:
        frame, point: (n,) int64 of each measurement.
        pixels: (n, 2) in the original frames.
        starts: (m, 3) rough positions in the cable frame, metres.
        epipolar_px: (pairs,) median Sampson distance of each verified pair from its estimated geometry.
        pos_epipolar_px: (pairs,) the same from the geometry that the POS predicts.
        rejected: share of measurements that the epipolar check threw out.
    """

    frame: NDArray[np.int64]
    point: NDArray[np.int64]
    pixels: Array
    starts: Array
    epipolar_px: Array
    pos_epipolar_px: Array
    rejected: float


def match_block(
    frames: FrameSequence,
    lens: Lens,
    pos: PosPriors,
    azimuth_deg: float,
    radius_m: float,
    options: MatchOptions,
    emit: Emit,
    axis: AxisCurve = STRAIGHT,
) -> TiePoints:
    """Find and verify the tie points of one block.

    Args:
        frames: original frames.
        lens: theirs.
        pos: predicted orientations.
        azimuth_deg: place of the camera around the axis.
        radius_m: rough radius of the cable.
        options: see there.
        emit: progress, one event a frame, then one a verified pair.
        axis: of the cable, where it is known better than that it lies on the y axis.

    Raises:
        StageError: a frame has too little texture to be tied to its neighbours.
    """
    filmed = Filmed(
        read=lambda frame: read_grey(frames.files[frame], "match"),
        lens=lens,
        poses=pos.poses,
        azimuth_deg=azimuth_deg,
        axis=axis,
        radius_m=radius_m,
    )
    frame, point, pixels, starts = _tracked(frames, filmed, options.track, part(emit, 0.0, 0.7))
    pinhole, verify_part = undistorted_lens(lens), part(emit, 0.7, 1.0)
    straightened = rays_to_pixels(pinhole, pixels_to_rays(lens, pixels))

    def tell(pair: int, pairs: int) -> None:
        verify_part(Event(stage="match", block=frames.block, done=pair, total=pairs))

    keep, estimated, predicted = _verify(frame, point, straightened, pinhole, pos.poses, options, tell)
    rejected = float(1 - keep.mean()) if len(keep) else 1.0
    frame, point, pixels, starts = _prune(frame[keep], point[keep], pixels[keep], starts, options)
    _check_texture(frame, frames, options)
    return TiePoints(
        frame=frame,
        point=point,
        pixels=pixels,
        starts=starts,
        epipolar_px=estimated,
        pos_epipolar_px=predicted,
        rejected=rejected,
    )


def _tracked(
    frames: FrameSequence, filmed: Filmed, options: TrackOptions, emit: Emit
) -> tuple[NDArray[np.int64], NDArray[np.int64], Array, Array]:
    """Frame, point and pixels of all measurements, and the points' rough places."""
    tracker, tracks = Tracker(filmed, options), []
    for home in range(len(frames)):
        emit(Event(stage="match", block=frames.block, done=home, total=len(frames)))
        tracks.append(tracker.track(home))
    offsets = np.cumsum([0, *(len(t.starts) for t in tracks)])[:-1]
    frame = np.concatenate([t.frame for t in tracks])
    point = np.concatenate([t.point + o for t, o in zip(tracks, offsets, strict=True)])
    pixels = np.concatenate([t.pixels for t in tracks])
    return frame, point, pixels, np.concatenate([t.starts for t in tracks])


def _verify(
    frame: NDArray[np.int64],
    point: NDArray[np.int64],
    pixels: Array,
    pinhole: Lens,
    poses: Poses,
    options: MatchOptions,
    tell: Callable[[int, int], None],
) -> tuple[NDArray[np.bool_], Array, Array]:
    """Check pairs of frames a few steps apart by their pictures alone (equation 11 and Algorithm 1).

    A measurement whose point is seen neither so many frames earlier nor later is checked against the next
    frame: points near the ends of the block and of the picture have no wider pair.

    Returns:
        Which measurements stay, and each pair's median distance from the estimated and the predicted
        geometry.
    """
    keep, checked = np.ones(len(frame), dtype=bool), np.zeros(len(frame), dtype=bool)
    estimated, predicted = [], []
    rows = [np.flatnonzero(frame == k) for k in range(len(poses))]
    wide = min(options.epipolar_step, len(poses) - 1)
    steps = tuple(dict.fromkeys((wide, 1)))
    for number, step in enumerate(steps):
        seen = checked.copy()
        for first, second in zip(range(len(poses) - step), range(step, len(poses)), strict=True):
            tell(number * len(poses) + first, len(steps) * len(poses))
            _, a, b = np.intersect1d(point[rows[first]], point[rows[second]], return_indices=True)
            a, b = rows[first][a], rows[second][b]
            if len(a) < options.least_points or (seen[a] & seen[b]).all():
                continue
            F, bad = _judge(pixels[a], pixels[b], options)
            keep[a[bad & ~seen[a]]] = False
            keep[b[bad & ~seen[b]]] = False
            checked[a] = checked[b] = True
            if step == wide:
                known = _predicted_fundamental(pinhole, poses, first, second)
                estimated.append(float(np.median(sampson_distances(F, pixels[a], pixels[b]))))
                predicted.append(float(np.median(sampson_distances(known, pixels[a], pixels[b]))))
    return keep, np.array(estimated), np.array(predicted)


def _judge(first: Array, second: Array, options: MatchOptions) -> tuple[Array, NDArray[np.bool_]]:
    """The fundamental matrix of one pair of frames, and which of their common points contradict it."""
    choice = FundamentalOptions(noise_sigma=options.epipolar_px / 2.5, seed=options.seed)
    some = np.linspace(0, len(first) - 1, min(len(first), MOST_PAIRS)).astype(int)
    F = estimate_fundamental(first[some], second[some], choice).F
    return F, ~(reconstruct_projective(F, first, second).residuals_px <= options.epipolar_px)


def _predicted_fundamental(pinhole: Lens, poses: Poses, first: int, second: int) -> Array:
    """The fundamental matrix of two frames from their orientation, equations (7), (8) and (11)."""
    K, rotations, centres = calibration_matrix(pinhole), poses.rotations, poses.centres
    A = infinite_homography(K, K, rotations[first], rotations[second])
    return fundamental_from_orientation(
        A, second_epipole(K, rotations[second], centres[first], centres[second])
    )


def _prune(
    frame: NDArray[np.int64],
    point: NDArray[np.int64],
    pixels: Array,
    starts: Array,
    options: MatchOptions,
) -> tuple[NDArray[np.int64], NDArray[np.int64], Array, Array]:
    """Drop points with too few views and number the others along the cable."""
    views = np.bincount(point, minlength=len(starts))
    chosen = np.flatnonzero(views >= options.least_views)
    chosen = chosen[np.argsort(starts[chosen, 1], kind="stable")]
    number = np.full(len(starts), -1)
    number[chosen] = np.arange(len(chosen))
    stay = number[point] >= 0
    return frame[stay], number[point[stay]], pixels[stay], starts[chosen]


def _check_texture(frame: NDArray[np.int64], frames: FrameSequence, options: MatchOptions) -> None:
    counts = np.bincount(frame, minlength=len(frames))
    poorest = int(np.argmin(counts))
    if counts[poorest] < options.least_points:
        name = frames.files[poorest].name
        raise StageError(
            "match",
            f"{frames.block}: frame {name} shares only {counts[poorest]} points with the others",
            "check that it is sharp, that the cable fills the picture and that travel_in_image is right; "
            "where images lie out of order or at uneven steps, or the POS file is poor, set ordered = false "
            "for the block and leave out its pos",
        )
