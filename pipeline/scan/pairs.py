"""Places that a person has pointed out both on the model and in the scan: a table.

Takes the file; gives pairs.  Leaves out how many are needed and whether they lie on a line
(:mod:`pipeline.steel.fuse_start`).
"""

import csv
from pathlib import Path

import numpy as np

from pipeline.core.errors import StageError
from pipeline.steel.fuse_records import GivenPair
from pipeline.steel.survey_records import LengthUnit

STAGE = "scan"
COLUMNS = ("name", "cable_x", "cable_y", "cable_z", "scan_x", "scan_y", "scan_z")


def read_scan_pairs(path: Path, unit: LengthUnit) -> tuple[GivenPair, ...]:
    """Read pairs: the cable's coordinates in metres, the scan's in its own unit.

    Raises:
        StageError: the file cannot be read, lacks a column, or holds what is no number.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = list(csv.DictReader(file))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise StageError(STAGE, f"{path} cannot be read as a table ({error})", "give a CSV file") from error
    if not rows or not set(COLUMNS) <= set(rows[0]):
        raise StageError(
            STAGE, f"{path} has no pairs in the columns {','.join(COLUMNS)}", "let its first line be these"
        )
    pairs = []
    for number, row in enumerate(rows, start=2):
        try:
            values = np.array([float(row[name]) for name in COLUMNS[1:]])
        except (TypeError, ValueError) as error:
            raise StageError(
                STAGE, f"{path} line {number} holds what is no number", "correct that line"
            ) from error
        pairs.append(GivenPair(name=row["name"], photo=values[:3], site=values[3:] * unit.in_metres))
    return tuple(pairs)
