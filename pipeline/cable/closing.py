"""Stage *closing*: marks that neighbouring blocks share, as image measurements (design, fact 2).

Takes the blocks as they were adjusted alone; gives measurements that close the ring.  Each block is unrolled
onto its own fitted cylinder; where two pictures overlap, marks are matched, and each place goes back to the
pixel that it was looked up from (so the cylinder need not be the true surface).  From there the mark is
followed through its block's frames: one ray from either side would always meet the other, only depth from
both sides ties them.
"""

from dataclasses import dataclass, field, replace
from itertools import combinations

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.cable.adjust import Orientation
from pipeline.cable.surface import BlockSurface
from pipeline.cable.texture import TextureOptions, UnrolledPicture, texture_block
from pipeline.cable.tracking import Gray, Tracker, TrackOptions
from pipeline.cable.unrolled_match import UnrolledMatchOptions, match_unrolled
from pipeline.core.axis import axis_of_cylinder
from pipeline.core.events import Emit, Event, silent
from pipeline.core.fits.cylinder import fit_cylinder
from pipeline.core.vocabulary import Array, FrameSequence

LEAST_VIEWS = 3


@dataclass(frozen=True, kw_only=True)
class ClosingOptions:
    """How shared marks are found.

    Attributes:
        match: how they are matched.
        track: how they are followed.
        limb_deg: half width of the unrolled pictures.
        cell_mm: side of their texels.
    """

    match: UnrolledMatchOptions = field(default_factory=UnrolledMatchOptions)
    track: TrackOptions = field(default_factory=TrackOptions)
    limb_deg: float = 60.0
    cell_mm: float = 0.3


@dataclass(frozen=True, kw_only=True)
class ClosingBlock:
    """What closing needs to know of one block.

    Attributes:
        frames: original frames.
        orientation: adjusted alone.
        azimuth_deg: place of the camera around the axis.
    """

    frames: FrameSequence
    orientation: Orientation
    azimuth_deg: float


@dataclass(frozen=True, kw_only=True)
class SharedMarks:
    """Measurements of marks seen by two blocks.

    Attributes:
        block, frame, mark: (n,) int64 of each measurement.
        pixels: (n, 2) in the original frames.
        points: (k, 3) rough place of each mark, metres.
        pairs: (k, 2) int64 the two blocks of each mark.
    """

    block: NDArray[np.int64]
    frame: NDArray[np.int64]
    mark: NDArray[np.int64]
    pixels: Array
    points: Array
    pairs: NDArray[np.int64]


@dataclass(frozen=True)
class _Unrolled:
    """A block on its own cylinder, and what follows points through its frames."""

    block: ClosingBlock
    surface: BlockSurface
    picture: UnrolledPicture
    tracker: Tracker


def find_shared_marks(blocks: tuple[ClosingBlock, ...], options: ClosingOptions, emit: Emit) -> SharedMarks:
    """Match all blocks with each other.

    Args:
        blocks: adjusted alone.
        options: see there.
        emit: progress.
    """
    pairs = list(combinations(range(len(blocks)), 2))
    total = len(blocks) + len(pairs)
    unrolled = []
    for number, block in enumerate(blocks):
        emit(Event(stage="closing", done=number, total=total))
        unrolled.append(_unroll(block, options))
    parts, count = [_none()], 0
    for number, (first, second) in enumerate(pairs):
        emit(Event(stage="closing", done=len(blocks) + number, total=total))
        part = _marks_of_pair(first, second, unrolled[first], unrolled[second], options)
        parts.append(replace(part, mark=part.mark + count))
        count += len(part.points)
    return SharedMarks(**{name: np.concatenate([getattr(m, name) for m in parts]) for name in vars(parts[0])})


def _unroll(block: ClosingBlock, options: ClosingOptions) -> _Unrolled:
    orientation = block.orientation
    cylinder = fit_cylinder(orientation.points, direction=(0.0, 1.0, 0.0))
    along = orientation.poses.centres[:, 1]
    limb = np.deg2rad(options.limb_deg)
    cell = options.cell_mm / 1000
    azimuth = np.deg2rad(block.azimuth_deg) + np.arange(-limb, limb, cell / cylinder.radius)
    y_m = np.arange(along.min() - 0.02, along.max() + 0.02, cell)
    shape = (len(y_m), len(azimuth))
    surface = BlockSurface(
        axis=axis_of_cylinder(cylinder),
        azimuth=azimuth,
        y_m=y_m,
        radius_m=np.full(shape, cylinder.radius, dtype=np.float32),
        measured=np.ones(shape, dtype=bool),
        score=np.ones(shape, dtype=np.float32),
    )
    choice = TextureOptions(texel_mm=options.cell_mm)
    picture = texture_block(block.frames, orientation, surface, options.cell_mm, choice, silent)

    def read(frame: int) -> Gray:
        file = block.frames.files[frame]
        return np.asarray(cv2.imread(str(file), cv2.IMREAD_GRAYSCALE), dtype=np.uint8)

    tracker = Tracker(
        read,
        orientation.lens,
        orientation.poses,
        block.azimuth_deg,
        (surface.axis, cylinder.radius),
        options.track,
    )
    return _Unrolled(block, surface, picture, tracker)


def _marks_of_pair(
    first: int, second: int, a: _Unrolled, b: _Unrolled, options: ClosingOptions
) -> SharedMarks:
    matches = match_unrolled(a.picture, b.picture, float(a.surface.radius_m[0, 0]), options.match)
    if not len(matches.first):
        return _none()
    points, seen_first = _follow(first, a, matches.first)
    _, seen_second = _follow(second, b, matches.second)
    both = SharedMarks(
        **{
            name: np.concatenate([getattr(seen_first, name), getattr(seen_second, name)])
            for name in ("block", "frame", "mark", "pixels")
        },
        points=points,
        pairs=np.tile([first, second], (len(points), 1)),
    )
    views = [np.bincount(both.mark[both.block == n], minlength=len(points)) for n in (first, second)]
    return _kept(both, (views[0] >= LEAST_VIEWS) & (views[1] >= LEAST_VIEWS))


def _follow(number: int, unrolled: _Unrolled, places: Array) -> tuple[Array, SharedMarks]:
    """Rough points (k, 3) and every measurement of marks at places (k, 2) of azimuth and y."""
    tracker = unrolled.tracker
    where = tracker.places(places[:, 0], places[:, 1])
    home = np.abs(places[:, 1:] - unrolled.block.orientation.poses.centres[:, 1]).argmin(axis=1)
    parts = [_none()]
    for k in np.unique(home):
        mine = np.flatnonzero(home == k)
        track = tracker.follow(int(k), where[mine])
        parts.append(
            replace(
                parts[0],
                block=np.full(len(track.point), number),
                frame=track.frame,
                mark=mine[track.point],
                pixels=track.pixels,
            )
        )
    names = ("block", "frame", "mark", "pixels")
    whole = {name: np.concatenate([getattr(p, name) for p in parts]) for name in names}
    return tracker.surface(where), replace(parts[0], **whole)


def _kept(marks: SharedMarks, keep: NDArray[np.bool_]) -> SharedMarks:
    """Only the marks where ``keep`` (k,) is true, numbered anew."""
    number = np.cumsum(keep) - 1
    rows = keep[marks.mark]
    return SharedMarks(
        block=marks.block[rows],
        frame=marks.frame[rows],
        mark=number[marks.mark[rows]],
        pixels=marks.pixels[rows],
        points=marks.points[keep],
        pairs=marks.pairs[keep],
    )


def _none() -> SharedMarks:
    whole = np.zeros(0, dtype=np.int64)
    return SharedMarks(
        block=whole,
        frame=whole,
        mark=whole,
        pixels=np.zeros((0, 2)),
        points=np.zeros((0, 3)),
        pairs=np.zeros((0, 2), dtype=np.int64),
    )
