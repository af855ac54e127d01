"""Results appear whole or not at all: written under a temporary name beside their place, then renamed.

Takes contents, or a function that writes to a given path; gives the finished file.  Leaves out formats beyond
text, JSON, CSV and PNG.
"""

import csv
import glob
import json
import os
import re
import shutil
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, is_dataclass
from enum import Enum
from pathlib import Path
from typing import Any
from uuid import uuid4

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.core.errors import StageError

RETRIES_S = (0.05, 0.1, 0.2, 0.4, 0.8)
"""Pauses on Windows before a file that is open elsewhere is replaced after all."""

_ACCESS_DENIED, _SHARING_VIOLATION = 5, 32
"""Windows' own numbers for a file that another program has open."""

PLAIN_FRAMES_BYTES = 256 * 2**20
"""Up to this much a block's frames lie on disk uncompressed."""


@contextmanager
def replacing(path: Path, stage: str = "output") -> Iterator[Path]:
    """Give a temporary name with the same ending in the same folder; rename it to ``path`` at a good end.

    The folder is made where it is missing.  After an error, an interrupt included, nothing is left behind and
    what stood at ``path`` before still stands.  The body may write a file or make a folder.

    Raises:
        StageError: the place cannot be written (errors of the body's own writing included).
    """
    temporary = path.with_name(f".{path.stem}.{uuid4().hex[:8]}.part{path.suffix}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield temporary
        if temporary.is_dir() and path.is_dir():
            shutil.rmtree(path)
        put_in_place(temporary, path)
    except OSError as error:
        where = path if error.filename is None else Path(error.filename)
        if where != path.parent and path.parent not in where.parents and where not in path.parents:
            raise  # another file's trouble, met while this one was written
        raise unwritable(path, error, stage) from error
    finally:
        if temporary.is_dir():
            shutil.rmtree(temporary, ignore_errors=True)
        else:
            _remove(temporary)


def put_in_place(
    temporary: Path, path: Path, pauses_s: tuple[float, ...] = RETRIES_S if os.name == "nt" else ()
) -> None:
    """Rename over what stands there; where another program has it open, try again after each pause.

    Windows refuses to replace a file that is open, and virus scanners open each new one for a moment.

    Raises:
        OSError: it cannot be renamed, or after the last pause is still open.
    """
    for pause_s in pauses_s:
        try:
            os.replace(temporary, path)
        except PermissionError:
            time.sleep(pause_s)
        else:
            return
    os.replace(temporary, path)


def unwritable(path: Path, error: OSError, stage: str = "output") -> StageError:
    """Say that a place cannot be written, and why."""
    reason = (error.strerror or str(error)).lower()
    remedy = "choose another folder or make room there"
    if getattr(error, "winerror", None) in (_ACCESS_DENIED, _SHARING_VIOLATION) and path.exists():
        remedy = "close the program that has it open, or choose another folder"
    return StageError(stage, f"cannot write {path} ({reason})", remedy)


def write_text(path: Path, text: str, stage: str = "output") -> None:
    """Write UTF-8 text with line feeds."""
    with replacing(path, stage) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


def write_bytes(path: Path, content: bytes, stage: str = "output") -> Path:
    """Write bytes; gives the path back."""
    with replacing(path, stage) as temporary:
        temporary.write_bytes(content)
    return path


def write_json(path: Path, value: object, stage: str = "output") -> None:
    """Write JSON; dataclasses, arrays, paths and enums become plain, numbers that are none become null."""
    write_text(path, json.dumps(plain(value), indent=2, ensure_ascii=False, allow_nan=False) + "\n", stage)


def write_csv(
    path: Path, header: Sequence[str], rows: Iterable[Sequence[object]], stage: str = "output"
) -> None:
    """Write a table with one header line; floats in full (they read back the same)."""
    with replacing(path, stage) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)


def write_png(path: Path, image: NDArray[Any], compression: int = 1, stage: str = "output") -> None:
    """Write an 8- or 16-bit image, (h, w) or (h, w, 3) blue-green-red; compression 0 is none, 9 small."""
    # on pictures of a cable one fixed filter is twice as fast as OpenCV's own choice, and 8 % smaller
    filtered = cv2.IMWRITE_PNG_FILTER_UP if compression else cv2.IMWRITE_PNG_FILTER_NONE
    settings = [cv2.IMWRITE_PNG_COMPRESSION, compression, cv2.IMWRITE_PNG_FILTER, filtered]
    good, data = cv2.imencode(".png", image, settings)
    if not good:
        raise StageError(stage, f"{path} cannot be encoded as PNG", "report this as a fault of the program")
    with replacing(path, stage) as temporary:
        temporary.write_bytes(data.tobytes())


def frame_compression(count: int, width_px: int, height_px: int) -> int:
    """How to write that many colour frames of one block as PNG.

    A short sequence is left uncompressed: written eight times and read five times as fast (2 instead of 11 ms
    for 960 x 600), and every stage reads it anew.  A long one would fill the disk, at three times the size.
    """
    return 0 if 3 * count * width_px * height_px < PLAIN_FRAMES_BYTES else 1


def natural_key(path: Path) -> tuple[tuple[str, int], ...]:
    """Sort key by which frame9 comes before frame10."""
    return tuple((text, int(digits or 0)) for text, digits in re.findall(r"(\D*)(\d*)", path.name))


def is_pattern(path: Path) -> bool:
    """Tell whether a path is a glob pattern: it has wildcards, and nothing of just this name exists."""
    return glob.has_magic(str(path)) and not path.exists()


def matching(pattern: Path) -> tuple[Path, ...]:
    """The files that match a glob pattern, in natural order; brackets in existing folders mean themselves."""
    existing = next(parent for parent in pattern.parents if parent.is_dir())
    rest = str(pattern.relative_to(existing))
    found = (existing / name for name in glob.glob(rest, root_dir=existing, recursive=True))
    return tuple(sorted((path for path in found if path.is_file()), key=natural_key))


def plain(value: object) -> Any:  # noqa: ANN401 - JSON is anything
    """Turn records, arrays, paths and enums into what JSON knows; NaN and infinities into None."""
    if is_dataclass(value) and not isinstance(value, type):
        return plain(asdict(value))
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float):
        return value if np.isfinite(value) else None
    if isinstance(value, Enum):
        return value.value
    return str(value) if isinstance(value, Path) else value


def _remove(path: Path) -> None:
    # a folder that lies behind a file, or was never made, has nothing to remove
    if path.parent.is_dir():
        path.unlink(missing_ok=True)
