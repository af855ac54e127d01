"""Stage *closing*: marks that neighbouring blocks share, as image measurements (design, fact 2).

Takes the blocks as they were adjusted alone; gives measurements that close the ring.  Each block is unrolled
onto its own fitted cylinder; where two pictures overlap, marks are matched, and each place goes back to the
pixel that it was looked up from (so the cylinder need not be the true surface).  From there the mark is
followed through its block's frames: one ray from either side would always meet the other, only depth from
both sides ties them.
"""

from dataclasses import dataclass, field, replace
from functools import partial
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from pipeline.cable.adjust import Orientation
from pipeline.cable.sheets import Filmed
from pipeline.cable.surface import BlockSurface
from pipeline.cable.texture import TextureOptions, UnrolledPicture, texture_block
from pipeline.cable.tracking import Tracker, TrackOptions
from pipeline.cable.unrolled_match import Correspondences, UnrolledMatchOptions, match_unrolled
from pipeline.core.axis import axis_of_cylinder
from pipeline.core.events import Emit, Event, part
from pipeline.core.fits.cylinder import fit_cylinder
from pipeline.core.parallel import side_by_side, workers_for
from pipeline.core.pictures import read_grey
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


@dataclass(frozen=True)
class _Side:
    """Marks as one block shows them: (k, 2) places of azimuth and y, (k,) their numbers."""

    places: Array
    marks: NDArray[np.int64]


@dataclass(frozen=True, kw_only=True)
class _Seen:
    """Measurements of one block's marks, the fields as in :class:`SharedMarks`."""

    block: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    frame: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    mark: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    pixels: Array = field(default_factory=lambda: np.zeros((0, 2)))


def find_shared_marks(blocks: tuple[ClosingBlock, ...], options: ClosingOptions, emit: Emit) -> SharedMarks:
    """Match all blocks with each other.

    Args:
        blocks: adjusted alone.
        options: see there.
        emit: progress, one event a frame.
    """
    pairs = list(combinations(range(len(blocks)), 2))
    workers = workers_for(len(blocks))
    unrolled = side_by_side([partial(_unroll, b, options) for b in blocks], emit, workers)
    matches = side_by_side(
        [partial(_match, unrolled[a], unrolled[b], options) for a, b in pairs], emit, workers
    )
    numbers = np.cumsum([0, *(len(m.first) for m in matches)])
    sides: list[list[_Side]] = [[] for _ in blocks]
    for (first, second), match, number in zip(pairs, matches, numbers, strict=False):
        marks = number + np.arange(len(match.first))
        sides[first].append(_Side(match.first, marks))
        sides[second].append(_Side(match.second, marks))
    jobs = [partial(_follow, n, unrolled[n], _joined(side)) for n, side in enumerate(sides)]
    seen = side_by_side(jobs, emit, workers)
    whole = {
        name: np.concatenate([getattr(s, name) for s in seen])
        for name in ("block", "frame", "mark", "pixels")
    }
    points = [
        u.tracker.sheets.surface(u.tracker.sheets.places(*m.first.T))
        for (u, _), m in zip(combinations(unrolled, 2), matches, strict=True)
    ]
    everything = SharedMarks(
        **whole,
        points=np.concatenate([np.zeros((0, 3)), *points]),
        pairs=np.repeat(np.array(pairs, dtype=np.int64).reshape(-1, 2), np.diff(numbers), axis=0),
    )
    return _kept(everything, _seen_from_both(everything))


def _seen_from_both(marks: SharedMarks) -> NDArray[np.bool_]:
    """(k,) whether both blocks of a mark followed it."""
    sides = []
    for side in (0, 1):
        mine = marks.block == marks.pairs[marks.mark, side]
        sides.append(np.bincount(marks.mark[mine], minlength=len(marks.points)) >= LEAST_VIEWS)
    return sides[0] & sides[1]


def _telling(block: ClosingBlock, emit: Emit) -> Emit:
    """An emit for the steps of other stages that serve this one."""
    return lambda event: emit(replace(event, stage="closing", block=block.frames.block))


def _unroll(block: ClosingBlock, options: ClosingOptions, emit: Emit) -> _Unrolled:
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
    # matching takes out local brightness itself
    choice = TextureOptions(texel_mm=options.cell_mm, even_exposure=False)
    picture = texture_block(
        block.frames, orientation, surface, options.cell_mm, choice, _telling(block, part(emit, 0.0, 0.5))
    )
    filmed = Filmed(
        read=lambda frame: read_grey(block.frames.files[frame], "closing"),
        lens=orientation.lens,
        poses=orientation.poses,
        azimuth_deg=block.azimuth_deg,
        axis=surface.axis,
        radius_m=cylinder.radius,
    )
    return _Unrolled(block, surface, picture, Tracker(filmed, options.track))


def _match(a: _Unrolled, b: _Unrolled, options: ClosingOptions, _: Emit) -> Correspondences:
    return match_unrolled(a.picture, b.picture, float(a.surface.radius_m[0, 0]), options.match)


def _joined(sides: list[_Side]) -> _Side:
    """The marks that a block shares with all others."""
    return _Side(
        places=np.concatenate([np.zeros((0, 2)), *(s.places for s in sides)]),
        marks=np.concatenate([np.zeros(0, dtype=np.int64), *(s.marks for s in sides)]),
    )


def _follow(number: int, unrolled: _Unrolled, side: _Side, emit: Emit) -> _Seen:
    """Every measurement of a block's marks."""
    tracker, emit = unrolled.tracker, _telling(unrolled.block, part(emit, 0.5, 1.0))
    where = tracker.sheets.places(side.places[:, 0], side.places[:, 1])
    along = unrolled.block.orientation.poses.centres[:, 1]
    home = np.abs(side.places[:, 1:] - along).argmin(axis=1)
    parts = [_Seen()]
    for k in np.unique(home):
        emit(Event(stage="closing", done=int(k), total=len(along)))
        mine = np.flatnonzero(home == k)
        track = tracker.follow(int(k), where[mine])
        parts.append(
            _Seen(
                block=np.full(len(track.point), number),
                frame=track.frame,
                mark=side.marks[mine[track.point]],
                pixels=track.pixels,
            )
        )
    return _Seen(**{name: np.concatenate([getattr(p, name) for p in parts]) for name in vars(parts[0])})


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
