"""Points out of text files, run by run: PTS (its first line tells how many) and XYZ.

Takes the path; gives what every reader of :mod:`pipeline.steel.cloud_readers` gives, which is told here.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array

POINTS_PER_RUN = 500_000

_COMMENTS = ("#", "//", ";")


@dataclass(frozen=True, kw_only=True)
class CloudRuns:
    """An open cloud.

    Attributes:
        announced: points that the file says it has; 0 where it does not say.
        runs: (n, 3) coordinates as written; (n, 4) with intensities, NaN where the file has none.
    """

    announced: int
    runs: Iterator[Array]


def cloud_error(station: str, cause: str, remedy: str) -> StageError:
    """An error about the cloud of a station."""
    return StageError("clouds", f"station {station}: {cause}", remedy)


def with_bright(points: Array, intensities: Any, bright: bool) -> Array:  # noqa: ANN401 - of any type
    """Coordinates with a fourth column, where it is asked for; NaN without intensities."""
    if not bright:
        return points
    column = np.full(len(points), np.nan) if intensities is None else np.asarray(intensities, dtype=float)
    return np.column_stack([points, column])


@contextmanager
def open_text(path: Path, station: str, bright: bool) -> Iterator[CloudRuns]:
    """Open PTS (first line: number of points) or XYZ (comments or a heading may stand first).

    Raises:
        StageError: a line does not begin with three numbers.
    """
    with path.open(encoding="utf-8-sig") as file:
        lines, announced, first = 0, 0, file.readline()
        while first and (_is_comment(first) or not _numbers(first)):
            lines, first = lines + 1, file.readline()
        if len(_numbers(first)) == 1:
            announced = int(_numbers(first)[0])
            lines, first = lines + 1, file.readline()
        yield CloudRuns(announced=announced, runs=_text_runs(file, path, station, first, lines + 1, bright))


def _text_runs(
    file: TextIO, path: Path, station: str, first: str, line: int, bright: bool
) -> Iterator[Array]:
    if not first:
        return
    columns = (0, 1, 2, 3) if bright and len(_numbers(first)) > 3 else (0, 1, 2)
    if len(_numbers(first)) < 3:
        raise _bad_line(path, station, line, first)
    comma = next((c for c in ",;" if c in first), None)
    while text := ([first] if first else []) + file.readlines(POINTS_PER_RUN * len(first or "x" * 40)):
        first = ""
        try:
            run = np.loadtxt(text, usecols=columns, delimiter=comma, ndmin=2, comments=list(_COMMENTS[:2]))
        except ValueError as error:
            number, bad = next(
                ((n, t) for n, t in enumerate(text) if t.strip() and len(_numbers(t)) < 3), (0, text[0])
            )
            raise _bad_line(path, station, line + number, bad) from error
        line += len(text)
        yield with_bright(run[:, :3], run[:, 3] if len(columns) > 3 else None, bright)


def _is_comment(line: str) -> bool:
    return not line.strip() or line.lstrip().startswith(_COMMENTS)


def _numbers(line: str) -> list[float]:
    """The leading numbers of a line."""
    found: list[float] = []
    for word in line.replace(",", " ").replace(";", " ").split():
        try:
            found.append(float(word))
        except ValueError:
            break
    return found


def _bad_line(path: Path, station: str, line: int, text: str) -> StageError:
    return cloud_error(
        station,
        f'{path.name} line {line} "{text.strip()[:40]}" does not begin with three numbers',
        "export x, y and z as the first columns",
    )
