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

import numpy as np
from numpy.typing import NDArray

from pipeline.cable.frame_files import FEWEST_FRAMES, Scan, frame_event, frame_name, scan_block, write_frames
from pipeline.cable.ordering import OrderOptions, travel_fractions
from pipeline.cable.sources import image_files, is_video, read_frame
from pipeline.cable.survey_records import Block, Survey
from pipeline.core.errors import StageError
from pipeline.core.events import Emit, part
from pipeline.core.parallel import side_by_side, workers_for
from pipeline.core.vocabulary import Array, FrameSequence


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
    scans = side_by_side([partial(scan_block, block) for block in survey.blocks], emit, workers)
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


def _check_counts(blocks: Sequence[Block], scans: Sequence[Scan]) -> None:
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
    scan: Scan,
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
        files = write_frames(block, scan, chosen, folder / block.name / "frames", emit)
    else:
        every = image_files(block)
        files = tuple(every[index] for index in chosen)
        emit(frame_event(block, len(every), len(every)))
    return FrameSequence(
        block=block.name,
        files=files,
        source_indices=chosen,
        source_count=len(scan.sharpness),
        width_px=scan.width_px,
        height_px=scan.height_px,
        fractions=None if fractions is None else fractions[chosen],
    )
