"""A source looked through once, and its chosen frames written.

Takes a block's video or pictures; gives how sharp each is, and the files of those that are chosen.  Which are
chosen is told in ``frames.py``.
"""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.cable.sources import Frame, Image, is_video, read_frames
from pipeline.cable.survey_records import Block
from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event
from pipeline.core.files import frame_compression, write_png
from pipeline.core.vocabulary import Array, TravelDirection

FEWEST_FRAMES = 3
"""Two frames give a model but no check on it."""
HELD_BYTES = 64 * 2**20
"""A video of up to this size stays in memory, decoded, until its frames are chosen and written."""


@dataclass(frozen=True, kw_only=True)
class Scan:
    """What one look through a source tells: (n,) sharpness, the image size, the images where they are few."""

    sharpness: Array
    width_px: int
    height_px: int
    images: tuple[Image, ...]


def scan_block(block: Block, emit: Emit) -> Scan:
    """Look through a block's source; the first half of the stage's work.

    Raises:
        StageError: the source is unreadable, broken or too short.
    """
    values, height_px, width_px = [], 0, 0
    images: list[Image] = []
    for frame in read_frames(block):
        values.append(sharpness(frame.image, block.travel_in_image))
        height_px, width_px = frame.image.shape[:2]
        if is_video(block) and frame.image.nbytes * len(values) <= HELD_BYTES:
            images.append(frame.image)
        emit(frame_event(block, frame.index + 1, 2 * frame.promised))
    if len(values) < FEWEST_FRAMES:
        raise StageError(
            "frames",
            f"{block.source} of {block.name} holds {len(values)} frames",
            f"give at least {FEWEST_FRAMES}",
        )
    held = tuple(images) if len(images) == len(values) else ()
    return Scan(sharpness=np.array(values), width_px=width_px, height_px=height_px, images=held)


def write_frames(
    block: Block, scan: Scan, chosen: NDArray[np.int64], folder: Path, emit: Emit
) -> tuple[Path, ...]:
    """Write the chosen frames (k,) of a video as PNG into the folder and take away what else lies there.

    Raises:
        StageError: the video cannot be read again, or the folder cannot be written.
    """
    files = {int(index): folder / frame_name(int(index)) for index in chosen}
    compression = frame_compression(len(chosen), scan.width_px, scan.height_px)
    count = len(scan.sharpness)
    held = (Frame(index=index, image=image, promised=count) for index, image in enumerate(scan.images))
    for frame in held if scan.images else read_frames(block):
        if frame.index in files:
            write_png(files[frame.index], frame.image, compression, stage="frames")
        emit(frame_event(block, frame.promised + frame.index + 1, 2 * frame.promised))
    for stray in set(folder.glob("[0-9]*.png")) - set(files.values()):
        stray.unlink()
    return tuple(files.values())


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


def frame_event(block: Block, done: int, total: int) -> Event:
    """Progress of the stage in one block."""
    return Event(stage="frames", done=done, total=total, block=block.name)
