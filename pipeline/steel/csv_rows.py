"""Rows of a CSV table that a person wrote about a station: read strictly, told of by file and line.

Takes the file and its columns; gives texts by column, with the words that name each row in a sentence.
Leaves out what the columns mean (``target_table.py``, ``name_table.py``).
"""

import csv
from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path

from pipeline.core.errors import StageError

STAGE = "targets"


def read_rows(
    path: Path, columns: Sequence[str], optional: Sequence[str] = ()
) -> list[tuple[str, dict[str, str]]]:
    """("PATH line N", column to text) of each row that is not blank.

    Raises:
        StageError: the file is no table, or its first line lacks a column or has one too many.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = list(csv.reader(file))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise table_error(f"{path} cannot be read as a table ({error})", "give a CSV file") from error
    header = [word.strip() for word in rows[0]] if rows else []
    missing = [name for name in columns if name not in header]
    unknown = [name for name in header if name not in (*columns, *optional)]
    if missing or unknown:
        said = f"has no column {missing[0]}" if missing else f'has an unknown column "{unknown[0]}"'
        lines = [",".join((*columns, *optional[:n])) for n in range(len(optional) + 1)]
        raise table_error(f"{path} {said}", f"let its first line be {' or '.join(lines)}")
    return [
        (f"{path} line {number}", {key: text.strip() for key, text in zip(header, row, strict=False)})
        for number, row in enumerate(rows[1:], start=2)
        if any(word.strip() for word in row)
    ]


def number_in(row: Mapping[str, str], key: str, where: str) -> float:
    """A finite number, metres.

    Raises:
        StageError: it is none.
    """
    text = row.get(key, "")
    try:
        value = float(text)
    except ValueError as error:
        raise table_error(f'{where}: {key} is "{text}"', "give a number in metres") from error
    if not isfinite(value):
        raise table_error(f"{where}: {key} is {text}", "give a number in metres")
    return value


def table_error(cause: str, remedy: str) -> StageError:
    """What the tables of a station are refused with."""
    return StageError(STAGE, cause, remedy)
