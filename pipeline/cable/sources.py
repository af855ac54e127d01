"""The images of a block, one after the other, from a video, a folder or a glob pattern.

Takes a :class:`~pipeline.cable.survey_records.Block`; gives its images one at a time, each checked, so that
memory stays that of one image.  Leaves out which of them are used (``frames.py``).
"""

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.cable.survey_records import Block
from pipeline.core.errors import StageError
from pipeline.core.files import is_pattern, matching, natural_key

IMAGE_ENDINGS = frozenset({".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".webp"})

BLANK_SPREAD = 2
"""An image whose grey values all lie this close together shows nothing."""

_COUNTED_ENDINGS = frozenset({".mp4", ".m4v", ".mov", ".avi"})
"""Containers that store the number of frames; others give it by way of the duration, one more or less."""

Image = NDArray[np.uint8]


@dataclass(frozen=True, kw_only=True)
class Frame:
    """One image of a source.

    Attributes:
        index: number in the source, from 0.
        image: (h, w, 3) uint8, blue-green-red.
        promised: number of images that the source claims to hold, for progress.
    """

    index: int
    image: Image
    promised: int


def is_video(block: Block) -> bool:
    """Tell whether the block's source is one file, a video, and not a set of images."""
    return block.source.is_file()


def image_files(block: Block) -> tuple[Path, ...]:
    """The image files of a block whose source is a folder or a pattern, in natural order.

    Raises:
        StageError: there is none.
    """
    if is_pattern(block.source):
        files = matching(block.source)
    else:
        inside = (path for path in block.source.iterdir() if path.suffix.lower() in IMAGE_ENDINGS)
        files = tuple(sorted((p for p in inside if not p.name.startswith(".")), key=natural_key))
    if not files:
        raise _error(
            f"{block.source} of {block.name} holds no images",
            f"put images there ({', '.join(sorted(IMAGE_ENDINGS))}) or correct block[{block.name}].source",
        )
    return files


def read_frames(block: Block) -> Iterator[Frame]:
    """Read all images of a block in order.

    Raises:
        StageError: the video is broken or truncated; an image is unreadable, blank or of another size.
    """
    size: tuple[int, ...] | None = None
    for frame, name in _video_frames(block) if is_video(block) else _image_frames(block):
        size = size or frame.image.shape[:2]
        _check(frame.image, name, size)
        yield frame


def read_frame(block: Block, index: int) -> Frame:
    """Read one image of a block, the same as :func:`read_frames` gives, without those before it.

    Raises:
        StageError: there is no such frame, or it cannot be read.
    """
    if not is_video(block):
        files = image_files(block)
        _check_index(block, index, len(files))
        return Frame(index=index, image=_read_image(files[index]), promised=len(files))
    video = _open_video(block.source)
    try:
        promised = _promised(video)
        _check_index(block, index, promised)
        video.set(cv2.CAP_PROP_POS_FRAMES, index)
        good, image = video.read()
    finally:
        video.release()
    if not good:
        raise _error(f"frame {index} of {block.source} cannot be read", "copy the video again from the robot")
    return Frame(index=index, image=_as_bytes(image), promised=promised)


def count_frames(block: Block) -> int:
    """Number of images that a block's source claims to hold.

    Raises:
        StageError: a folder without images, or no video.
    """
    if not is_video(block):
        return len(image_files(block))
    video = _open_video(block.source)
    try:
        return _promised(video)
    finally:
        video.release()


def _promised(video: Any) -> int:  # noqa: ANN401 - cv2 has no types
    """By the container; where that says nothing, by looking through, which leaves the video at its end."""
    told = int(video.get(cv2.CAP_PROP_FRAME_COUNT))
    if told > 0:
        return told
    count = 0
    while video.grab():
        count += 1
    return count


def _check_index(block: Block, index: int, count: int) -> None:
    if not 0 <= index < count:
        raise _error(
            f"{block.source} has no frame {index}, for it holds {count}",
            f"choose one from 0 to {max(count - 1, 0)}",
        )


def _image_frames(block: Block) -> Iterator[tuple[Frame, str]]:
    files = image_files(block)
    for index, path in enumerate(files):
        yield Frame(index=index, image=_read_image(path), promised=len(files)), str(path)


def _read_image(path: Path) -> Image:
    # through Python's own reading, which also opens names that OpenCV cannot
    data = np.frombuffer(path.read_bytes(), dtype=np.uint8)
    image = cv2.imdecode(data, cv2.IMREAD_COLOR) if len(data) else None
    if image is None:
        raise _error(f"{path} cannot be read as an image", "replace the file or take it out of the folder")
    return _as_bytes(image)


def _video_frames(block: Block) -> Iterator[tuple[Frame, str]]:
    video = _open_video(block.source)
    try:
        promised = int(video.get(cv2.CAP_PROP_FRAME_COUNT))
        count = 0
        while True:
            good, image = video.read()
            if not good:
                break
            name = f"frame {count} of {block.source}"
            yield Frame(index=count, image=_as_bytes(image), promised=max(promised, count + 1)), name
            count += 1
    finally:
        video.release()
    _check_complete(block.source, count, promised)


def _open_video(path: Path) -> Any:  # noqa: ANN401 - cv2 has no types
    # what FFmpeg has to say would run into the progress on stderr; the count below tells all that matters
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_ERROR)
    video = cv2.VideoCapture(str(path))
    if not video.isOpened():
        raise _error(
            f"{path} cannot be opened as a video; it is truncated, damaged or of an unknown kind",
            "copy it again from the robot or convert it to H.264 in MP4",
        )
    return video


def _check_complete(path: Path, count: int, promised: int) -> None:
    if count == 0:
        raise _error(f"{path} holds no frame that can be read", "copy the video again from the robot")
    slack = 0 if path.suffix.lower() in _COUNTED_ENDINGS else 1
    if count < promised - slack:
        raise _error(
            f"{path} is truncated or damaged: it promises {promised} frames and only {count} can be read",
            "copy the video again from the robot",
        )


def _check(image: Image, name: str, size: tuple[int, ...]) -> None:
    if image.shape[:2] != size:
        raise _error(
            f"{name} is {image.shape[1]} x {image.shape[0]}, the images before it are {size[1]} x {size[0]}",
            "give one block images of one size",
        )
    if int(image.max()) - int(image.min()) <= BLANK_SPREAD:
        raise _error(f"{name} is blank, all of one grey value", "leave that part of the recording out")


def _as_bytes(image: NDArray[Any]) -> Image:
    return image if image.dtype == np.uint8 else cv2.convertScaleAbs(image, alpha=1 / 257)


def _error(cause: str, remedy: str) -> StageError:
    return StageError("frames", cause, remedy)
