"""Pictures on disk, read whole or refused with a sentence."""

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.core.errors import StageError

type Picture = NDArray[np.uint8]


def read_colour(file: Path, stage: str) -> Picture:
    """Read a picture as (h, w, 3), blue-green-red.

    Raises:
        StageError: the file is missing or no picture.
    """
    return _read(file, stage, cv2.IMREAD_COLOR)


def read_grey(file: Path, stage: str) -> Picture:
    """Read a picture as (h, w).

    Raises:
        StageError: the file is missing or no picture.
    """
    return _read(file, stage, cv2.IMREAD_GRAYSCALE)


def _read(file: Path, stage: str, kind: int) -> Picture:
    # not by cv2.imread: on Windows it finds no path with letters outside the system's code page
    data = np.frombuffer(file.read_bytes(), np.uint8) if file.is_file() else np.empty(0, np.uint8)
    picture = cv2.imdecode(data, kind) if data.size else None
    if picture is None:
        raise StageError(stage, f"{file} cannot be read as an image", "restore the file or take it out")
    return np.asarray(picture, dtype=np.uint8)
