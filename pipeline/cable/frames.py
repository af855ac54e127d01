"""Stage *frames*: from videos or image folders to the frames that are worked on, in the order of travel.

Takes the survey; gives one :class:`~pipeline.core.vocabulary.FrameSequence` a block.  Frames of a video are
written as PNG, images stay where they are; those that need not lie in order are put in order first
(``ordering.py``).  The first and the last image are always taken, since the travel
is known between them.  Synchronised blocks get the same frame numbers.  Leaves out any correction of the
images.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from math import ceil, floor
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.cable.ordering import OrderOptions, travel_fractions
from pipeline.cable.sources import Image, image_files, is_video, read_frame, read_frames
from pipeline.cable.survey_records import Block, Survey
from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event, part
from pipeline.core.files import write_png
from pipeline.core.parallel import side_by_side, workers_for
from pipeline.core.vocabulary import Array, FrameSequence, TravelDirection

FEWEST_FRAMES = 3
"""Two frames give a model but no check on it."""


@dataclass(frozen=True, kw_only=True)
class FrameOptions:
    """Which frames are taken.

    Attributes:
        spacing_mm: wanted distance between frames along the cable; 0 takes every frame.  The nearest whole
            number of source frames is used.
        sharpness_window: width of the window around each wanted place in which the sharpest frame is taken,
            in spacings; 0 takes the frame at the place itself.
        most_frames: never more frames a block than this; 0 is no limit.
        order: of images that need not lie in the order of travel.
    """

    spacing_mm: float = field(default=15.0, metadata={"minimum": 0.0})
    sharpness_window: float = field(default=0.5, metadata={"minimum": 0.0, "maximum": 1.0})
    most_frames: int = field(default=0, metadata={"minimum": 0})
    order: OrderOptions = field(default_factory=OrderOptions)


@dataclass(frozen=True, kw_only=True)
class _Scan:
    """What one look through a source tells: (n,) sharpness and the image size."""

    sharpness: Array
    width_px: int
    height_px: int


def extract_frames(
    survey: Survey, options: FrameOptions, folder: Path, emit: Emit
) -> tuple[FrameSequence, ...]:
    """Choose the frames of all blocks, and write those of videos to ``folder/BLOCK/frames/NNNNNN.png``.

    The number in the name is the frame's number in its video.  All sources are looked through before anything
    is written; frames that an earlier choice left in that folder are removed.

    Raises:
        StageError: a source is unreadable, broken or too short; synchronised blocks differ in length; the
            lens of a block does not fit its images; images without order cannot be put in order.
    """
    workers = workers_for(len(survey.blocks))
    scans = side_by_side([partial(_scan, block) for block in survey.blocks], emit, workers)
    for block, scan in zip(survey.blocks, scans, strict=True):
        block.lens(scan.width_px, scan.height_px)  # tells now, and not stages later, what does not fit
    values = [scan.sharpness for scan in scans]
    if survey.robot.synchronised:
        _check_counts(survey.blocks, scans)
        values = [combined_sharpness(values)] * len(scans)
    sizes = [(scan.width_px, scan.height_px) for scan in scans]
    fractions = travel_fractions(survey, sizes, options.order, part(emit, 0.5, 1.0))
    rows = zip(survey.blocks, scans, values, fractions, strict=True)
    return tuple(
        side_by_side([partial(_sequence, survey, options, folder, *row) for row in rows], emit, workers)
    )


def every_frame(block: Block) -> FrameSequence:
    """All frames of a block's source, in the order of their names, named as the chosen ones would be.

    Those of a video are named but not written: for what needs names and places only (POS).

    Raises:
        StageError: the source holds no images, or its first one cannot be read.
    """
    first = read_frame(block, 0)
    if is_video(block):
        files = tuple(block.source / frame_name(index) for index in range(first.promised))
    else:
        files = image_files(block)
    return FrameSequence(
        block=block.name,
        files=files,
        source_indices=np.arange(len(files)),
        source_count=len(files),
        width_px=first.image.shape[1],
        height_px=first.image.shape[0],
    )


def frame_name(index: int) -> str:
    """Name of a video's frame as a file."""
    return f"{index:06d}.png"


def sharpness(image: Image, travel: TravelDirection) -> float:
    """Sharpness of an image of the cable, comparable between images of one video.

    Variance of the Laplacian (Pech-Pacheco et al., ICPR 2000) over the middle third across the travel, where
    the cable is, in units of the squared brightness.  The median over eight tiles along the travel, so that
    one scratch, label or glint does not decide.
    """
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    if travel in (TravelDirection.UP, TravelDirection.DOWN):
        grey = grey.T
    third = grey.shape[0] // 3
    band = cv2.GaussianBlur(np.ascontiguousarray(grey[third : 2 * third + 1]), (0, 0), 1.0)
    edges = cv2.Laplacian(band, cv2.CV_32F)
    tiles = zip(np.array_split(edges, 8, axis=1), np.array_split(band, 8, axis=1), strict=True)
    return float(np.median([edge.var() / (float(part.mean()) + 1.0) ** 2 for edge, part in tiles]))


def combined_sharpness(blocks: Sequence[Array]) -> Array:
    """Sharpness of each moment over all blocks, (n,): that of its worst image, in its block's median."""
    relative = np.stack([values / max(float(np.median(values)), 1e-12) for values in blocks])
    return relative.min(axis=0)


def select_frames(values: Array, travel_m: float, options: FrameOptions) -> NDArray[np.int64]:
    """Choose frames by spacing and sharpness; the first and the last are always among them.

    Args:
        values: (n,) sharpness of the source's frames.
        travel_m: path between the first and the last frame.
        options: spacing and window.

    Returns:
        (m,) frame numbers, strictly increasing.

    Raises:
        StageError: fewer than three frames remain.
    """
    intervals = len(values) - 1
    step = max(1, round(options.spacing_mm / 1000 / travel_m * intervals))
    parts = max(1, round(intervals / step))
    if options.most_frames:
        parts = min(parts, max(1, options.most_frames - 1))
    if parts + 1 < FEWEST_FRAMES:
        raise _too_few(parts + 1, len(values))
    wanted = np.linspace(0, intervals, parts + 1)
    reach = options.sharpness_window * intervals / parts / 2
    chosen = [_sharpest(values, place, reach) for place in wanted[1:-1]]
    return np.array([0, *chosen, intervals], dtype=np.int64)


def select_spread(
    values: Array, fractions: Array, travel_m: float, options: FrameOptions
) -> NDArray[np.int64]:
    """Choose among images taken at uneven steps: the sharpest in every half spacing, and both ends.

    Args:
        values: (n,) sharpness of the images.
        fractions: (n,) where along the travel they were taken.
        travel_m: path between the outermost two.
        options: spacing and largest number.

    Returns:
        (m,) image numbers in the order of travel.

    Raises:
        StageError: fewer than three images remain.
    """
    order = np.argsort(fractions, kind="stable")
    inner, limits = order[1:-1], []
    if options.spacing_mm:
        limits.append(ceil(2000 * travel_m / options.spacing_mm))
    if options.most_frames:
        limits.append(options.most_frames - 2)
    cells = max(min(limits), 0) if limits else 0
    cell = np.minimum(fractions[inner] * cells, cells - 1).astype(int) if limits else np.arange(len(inner))
    inside = [inner[cell == c] for c in range(cells if limits else len(inner))]
    best = [max(images, key=lambda k: float(values[k])) for images in inside if len(images)]
    if len(best) + 2 < FEWEST_FRAMES:
        raise _too_few(len(best) + 2, len(order))
    return np.array([order[0], *best, order[-1]], dtype=np.int64)


def _sharpest(values: Array, place: float, reach: float) -> int:
    centre = round(place)
    # strictly inside half a spacing, or two places could choose the same frame
    window = range(ceil(place - reach), floor(place + reach) + 1)
    near = [i for i in window if abs(i - place) < reach] or [centre]
    return max(near, key=lambda i: (values[i], -abs(i - centre)))


def _too_few(left: int, count: int) -> StageError:
    return StageError(
        "frames",
        f"options.frames leave {left} of {count} frames",
        f"lower spacing_mm or raise most_frames so that at least {FEWEST_FRAMES} remain",
    )


def _scan(block: Block, emit: Emit) -> _Scan:
    values, height_px, width_px = [], 0, 0
    for frame in read_frames(block):
        values.append(sharpness(frame.image, block.travel_in_image))
        height_px, width_px = frame.image.shape[:2]
        emit(_event(block, frame.index + 1, 2 * frame.promised))
    if len(values) < FEWEST_FRAMES:
        raise StageError(
            "frames",
            f"{block.source} of {block.name} holds {len(values)} frames",
            f"give at least {FEWEST_FRAMES}",
        )
    return _Scan(sharpness=np.array(values), width_px=width_px, height_px=height_px)


def _check_counts(blocks: Sequence[Block], scans: Sequence[_Scan]) -> None:
    first = len(scans[0].sharpness)
    for block, scan in zip(blocks, scans, strict=True):
        count = len(scan.sharpness)
        if count != first:
            raise StageError(
                "frames",
                f"{blocks[0].name} has {first} frames and {block.name} has {count}, "
                "but robot.synchronised = true says that they share one clock",
                "give recordings of the same moments or set robot.synchronised = false",
            )


def _sequence(
    survey: Survey,
    options: FrameOptions,
    folder: Path,
    block: Block,
    scan: _Scan,
    values: Array,
    fractions: Array | None,
    emit: Emit,
) -> FrameSequence:
    travel_m = survey.cable.travel_m
    if fractions is None:
        chosen = select_frames(values, travel_m, options)
    else:
        chosen = select_spread(values, fractions, travel_m, options)
    if is_video(block):
        files = _write_frames(block, chosen, folder / block.name / "frames", emit)
    else:
        every = image_files(block)
        files = tuple(every[index] for index in chosen)
        emit(_event(block, len(every), len(every)))
    return FrameSequence(
        block=block.name,
        files=files,
        source_indices=chosen,
        source_count=len(scan.sharpness),
        width_px=scan.width_px,
        height_px=scan.height_px,
        fractions=None if fractions is None else fractions[chosen],
    )


def _write_frames(block: Block, chosen: NDArray[np.int64], folder: Path, emit: Emit) -> tuple[Path, ...]:
    files = {int(index): folder / frame_name(int(index)) for index in chosen}
    for frame in read_frames(block):
        if frame.index in files:
            write_png(files[frame.index], frame.image, stage="frames")
        emit(_event(block, frame.promised + frame.index + 1, 2 * frame.promised))
    for stray in set(folder.glob("[0-9]*.png")) - set(files.values()):
        stray.unlink()
    return tuple(files.values())


def _event(block: Block, done: int, total: int) -> Event:
    return Event(stage="frames", done=done, total=total, block=block.name)
