"""POS files: CSV ``name,x,y,z,pitch,yaw,roll``, one row a frame.

x, y, z are the projection centre in the cable frame, metres.  The angles are deviations from the nominal
attitude in degrees: world_from_cam = nominal * Ry(yaw) * Rx(pitch) * Rz(roll), right-handed about the
camera's own axes (x right, y down, z forward).  Columns ``sigma_x`` ... ``sigma_roll`` may follow, in the
same units.

A name is the image's file name, with or without its ending, or the frame's number in the source, from 0.
Rows of frames that were not selected are passed over.
"""

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pipeline.cable.sources import IMAGE_ENDINGS
from pipeline.cable.survey_records import Block
from pipeline.core.errors import StageError
from pipeline.core.files import write_csv
from pipeline.core.rotations import (
    deviation_from_pos_angles,
    nominal_cam_from_world,
    pos_angles_from_deviation,
    poses_from_centres,
)
from pipeline.core.vocabulary import FrameSequence, PosPriors

PLACE = ("x", "y", "z")
ANGLES = ("pitch", "yaw", "roll")
VALUES = (*PLACE, *ANGLES)
SIGMAS = tuple(f"sigma_{name}" for name in VALUES)


@dataclass(frozen=True, kw_only=True)
class _Row:
    """One line of the file: its number, the frame's name, the numbers by column."""

    line: int
    name: str
    values: Mapping[str, float]


def read_pos(
    path: Path, block: Block, frames: FrameSequence, sigma_deg: float = 0.1, sigma_mm: float = 1.0
) -> PosPriors:
    """Read the POS of a block's frames.

    Args:
        path: the CSV file.
        block: gives the nominal attitude.
        frames: the frames that need a POS.
        sigma_deg, sigma_mm: standard deviations where the file gives none.

    Raises:
        StageError: the file, its columns, a name or a number does not fit, or a frame has no row.
    """
    rows = _read_rows(path)
    chosen = _rows_of_frames(path, rows, frames)
    angles = np.array([[row.values[name] for name in ANGLES] for row in chosen])
    centres = np.array([[row.values[name] for name in PLACE] for row in chosen])
    cam_from_nominal = np.swapaxes(deviation_from_pos_angles(angles), 1, 2)
    rotations = cam_from_nominal @ nominal_cam_from_world(block.angle_deg, block.travel_in_image)
    turn = [[row.values.get(f"sigma_{name}", sigma_deg) for name in ANGLES] for row in chosen]
    place = [[row.values.get(f"sigma_{name}", sigma_mm / 1000) for name in PLACE] for row in chosen]
    return PosPriors(
        poses=poses_from_centres(rotations, centres), sigmas=np.hstack([np.radians(turn), np.array(place)])
    )


def write_pos(path: Path, block: Block, frames: FrameSequence, priors: PosPriors) -> None:
    """Write the POS of a block's frames with its sigmas; reading it gives the same.

    Raises:
        StageError: the place cannot be written.
    """
    nominal = nominal_cam_from_world(block.angle_deg, block.travel_in_image)
    angles = pos_angles_from_deviation(nominal @ np.swapaxes(priors.poses.rotations, 1, 2))
    turn, place = np.degrees(priors.sigmas[:, :3]), priors.sigmas[:, 3:]
    table = np.hstack([priors.poses.centres, angles, place, turn])
    rows = ([file.name, *row] for file, row in zip(frames.files, table.tolist(), strict=True))
    write_csv(path, ["name", *VALUES, *SIGMAS], rows, stage="pos")


@dataclass(frozen=True, kw_only=True)
class PosMatch:
    """Which rows of a POS file belong to which frames.

    Attributes:
        names: of the rows, as written.
        frames: (rows,) number of the row's frame in its source; -1 where it is no frame of this block, -2
            where an earlier row has taken its frame.
        without_row: numbers of the frames that have no row, ascending.
    """

    names: tuple[str, ...]
    frames: tuple[int, ...]
    without_row: tuple[int, ...]


NO_FRAME, TAKEN = -1, -2


def match_pos(path: Path, frames: FrameSequence) -> PosMatch:
    """Tell which rows found their frame, for a person to look at; refuses nothing that can be shown.

    Args:
        path: the CSV file.
        frames: all frames of the block's source.

    Raises:
        StageError: the file, its columns or a number does not fit.
    """
    rows, resolve = _read_rows(path), _Names(frames)
    found: list[int] = []
    taken: set[int] = set()
    for row in rows:
        key = resolve(row.name)
        number = key if isinstance(key, int) else NO_FRAME
        found.append(TAKEN if number in taken else number)
        if number >= 0:
            taken.add(number)
    without = sorted(set(frames.source_indices.tolist()) - taken)
    return PosMatch(names=tuple(row.name for row in rows), frames=tuple(found), without_row=tuple(without))


def _read_rows(path: Path) -> list[_Row]:
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except OSError as error:
        reason = (error.strerror or "unknown reason").lower()
        raise _error(f"{path} cannot be read ({reason})", "correct the path") from error
    except UnicodeDecodeError as error:
        raise _error(f"{path} is no UTF-8 text", "save it as CSV in UTF-8") from error
    table = [
        (number, [cell.strip() for cell in cells])
        for number, cells in enumerate(csv.reader(lines), start=1)
        if any(cell.strip() for cell in cells)
    ]
    if not table:
        raise _error(f"{path} is empty", f"give the columns name,{','.join(VALUES)}")
    header = table[0][1]
    _check_header(path, header)
    return [_row(path, number, header, cells) for number, cells in table[1:]]


def _check_header(path: Path, header: Sequence[str]) -> None:
    for name in ("name", *VALUES):
        if name not in header:
            raise _error(f"{path} has no column {name}", f"begin it with name,{','.join(VALUES)}")
    for name in header:
        if name not in ("name", *VALUES, *SIGMAS):
            raise _error(
                f"{path} has the unknown column {name}", f"known beyond the seven: {','.join(SIGMAS)}"
            )
        if header.count(name) > 1:
            raise _error(f"{path} has the column {name} twice", "keep one of them")


def _row(path: Path, number: int, header: Sequence[str], cells: Sequence[str]) -> _Row:
    if len(cells) != len(header):
        raise _error(
            f"{path} line {number} has {len(cells)} values for {len(header)} columns", "complete that line"
        )
    texts = dict(zip(header, cells, strict=True))
    name = texts.pop("name")
    if not name:
        raise _error(f"{path} line {number} has no name", "give the name of its image")
    values = {key: _number(path, number, key, text) for key, text in texts.items()}
    return _Row(line=number, name=name, values=values)


def _number(path: Path, line: int, key: str, text: str) -> float:
    where = f"{path} line {line}: {key}"
    if not text:
        raise _error(f"{where} is empty", "give a number")
    try:
        value = float(text)
    except ValueError:
        raise _error(f'{where} is "{text}"', "give a number") from None
    if not math.isfinite(value):
        raise _error(f"{where} is {text}", "give a finite number or leave the whole file out")
    if key in SIGMAS and value <= 0:
        raise _error(f"{where} is {text}", "give a standard deviation above zero")
    return value


def _rows_of_frames(path: Path, rows: Sequence[_Row], frames: FrameSequence) -> list[_Row]:
    """The row of each frame, in the order of the frames."""
    if len(rows) > frames.source_count:
        raise _error(
            f"{path} has {len(rows)} rows, but {frames.block} has only {frames.source_count} frames",
            "give the POS file of this block",
        )
    resolve = _Names(frames)
    found: dict[int | str, _Row] = {}
    for row in rows:
        key = resolve(row.name)
        if key is None:
            raise _error(
                f"{path} line {row.line} names {row.name}, which is no frame of {frames.block}",
                f"name the image file or a frame from 0 to {frames.source_count - 1}",
            )
        if key in found:
            raise _error(
                f"{path} line {row.line} names {row.name} again after line {found[key].line}",
                "keep one row a frame",
            )
        found[key] = row
    for index, file in zip(frames.source_indices.tolist(), frames.files, strict=True):
        if index not in found:
            raise _error(f"{path} has no row for {file.name} (frame {index})", "add it")
    return [found[index] for index in frames.source_indices.tolist()]


class _Names:
    """Which frame a name in a POS file means.

    Calling it gives the frame's number in the source, or the name itself for an image beside the frames that
    was not selected, or None for what is no frame at all.
    """

    def __init__(self, frames: FrameSequence) -> None:
        self._count = frames.source_count
        pairs = list(zip(frames.files, frames.source_indices.tolist(), strict=True))
        self._by_name = {name: index for file, index in pairs for name in (file.name, file.stem)}
        numbered = all(file.stem.isdecimal() for file in frames.files)
        self._by_number = {int(file.stem): index for file, index in pairs} if numbered else {}
        self._numbers_are_indices = all(number == index for number, index in self._by_number.items())
        self._beside: set[str] = set()
        for folder in {file.parent for file in frames.files}:
            for file in folder.iterdir() if folder.is_dir() else ():
                number = {str(int(file.stem))} if file.stem.isdecimal() else set()
                self._beside |= {file.name, file.stem} | number

    def __call__(self, name: str) -> int | str | None:
        stem = Path(name).stem if Path(name).suffix.lower() in IMAGE_ENDINGS else name
        for text in (name, stem):
            if text in self._by_name:
                return self._by_name[text]
        if stem.isdecimal():
            number = int(stem)
            if number in self._by_number:
                return self._by_number[number]
            if self._numbers_are_indices and number < self._count:
                return number
        return stem if stem in self._beside else None


def _error(cause: str, remedy: str) -> StageError:
    return StageError("pos", cause, remedy)
