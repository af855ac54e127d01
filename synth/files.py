"""Small files, each written under a temporary name and renamed, so that what is there is whole."""

from pathlib import Path

import cv2
import numpy as np
import OpenEXR
from numpy.typing import NDArray

from pipeline.core.errors import StageError


def write_text(path: Path, text: str) -> None:
    """Write a text file."""
    temporary = path.with_name(path.name + ".part")
    temporary.write_text(text, encoding="utf-8")
    temporary.replace(path)


def write_png(path: Path, picture: NDArray[np.uint8]) -> None:
    """Write (height, width, 3 or 4) red, green, blue(, alpha); OpenCV wants blue first."""
    path.parent.mkdir(parents=True, exist_ok=True)
    code = cv2.COLOR_RGBA2BGRA if picture.shape[2] == 4 else cv2.COLOR_RGB2BGR
    temporary = path.with_name(path.stem + ".part.png")
    if not cv2.imwrite(str(temporary), cv2.cvtColor(picture, code), [cv2.IMWRITE_PNG_COMPRESSION, 1]):
        raise StageError("render", f"{path} cannot be written", "check the space on the disk")
    temporary.replace(path)


def read_png(path: Path) -> NDArray[np.uint8]:
    """Read (height, width, 3) red, green, blue back."""
    picture = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if picture is None:
        raise StageError("render", f"{path} cannot be read back", "delete it and start again")
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB), np.uint8)


def write_depth(path: Path, depth: NDArray[np.float32]) -> None:
    """Write a one-channel OpenEXR ``Z``: metres along the optical axis, 0 beside the cable."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(path.stem + ".part.exr")
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, {"Z": depth}) as exr:
        exr.write(str(temporary))
    temporary.replace(path)
