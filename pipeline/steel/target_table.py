"""Targets named by hand: a table name,x,y,z[,sigma_mm] in the frame of a station.

Takes the file; gives point features with a covariance.  Leaves out targets found in a cloud (``targets.py``).
"""

import csv
from math import isfinite
from pathlib import Path

import numpy as np

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array
from pipeline.steel.records import Feature, FeatureKind, StationFeatures
from pipeline.steel.survey_records import Scanner

_COLUMNS = ("name", "x", "y", "z")
_OPTIONAL = "sigma_mm"


def read_target_table(path: Path, station: str, scanner: Scanner) -> StationFeatures:
    """Read the targets of one station, metres.

    Without ``sigma_mm`` a target is worth one point as the scanner measures it.

    Raises:
        StageError: the file cannot be read, a column is missing, a value is no number, a name is there twice.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = list(csv.reader(file))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise _error(f"{path} cannot be read as a table ({error})", "give a CSV file") from error
    header = [word.strip() for word in rows[0]] if rows else []
    missing = [name for name in _COLUMNS if name not in header]
    unknown = [name for name in header if name not in (*_COLUMNS, _OPTIONAL)]
    if missing or unknown:
        said = f"has no column {missing[0]}" if missing else f'has an unknown column "{unknown[0]}"'
        raise _error(f"{path} {said}", "let its first line be name,x,y,z or name,x,y,z,sigma_mm")
    features = [
        _feature(dict(zip(header, row, strict=False)), f"{path} line {number}", scanner)
        for number, row in enumerate(rows[1:], start=2)
        if any(word.strip() for word in row)
    ]
    names = [feature.name for feature in features]
    for name in names:
        if names.count(name) > 1:
            raise _error(f'{path} has the target "{name}" more than once', "give each its own name")
    if not features:
        raise _error(f"{path} has no target", "give the targets that the station sees, one a line")
    return StationFeatures(station=station, features=tuple(features))


def point_covariance(place: Array, scanner: Scanner) -> Array:
    """(3, 3) covariance, metres^2, of one point (3,) as the scanner measures it: range and two angles."""
    distance = float(np.linalg.norm(place))
    along = place / distance if distance > 0 else np.array([1.0, 0.0, 0.0])
    across = (distance * scanner.angle_sigma_rad) ** 2
    return across * np.eye(3) + (scanner.range_sigma_m**2 - across) * np.outer(along, along)


def target(name: str, place: Array, covariance: Array) -> Feature:
    """A point feature named by hand, at (3,) metres."""
    return Feature(
        kind=FeatureKind.POINT,
        name=name,
        place=place,
        direction=np.zeros(3),
        frame=np.eye(3),
        covariance=covariance,
        radius_m=0.0,
        points=0,
        rms_m=0.0,
    )


def _feature(row: dict[str, str], where: str, scanner: Scanner) -> Feature:
    name = row.get("name", "").strip()
    if not name:
        raise _error(f"{where} has no name", "name the target")
    place = np.array([_number(row, key, where) for key in "xyz"])
    if not row.get(_OPTIONAL, "").strip():
        if not place.any():
            raise _error(f"{where} puts a target into the scanner itself", "correct its coordinates")
        return target(name, place, point_covariance(place, scanner))
    sigma_mm = _number(row, _OPTIONAL, where)
    if not sigma_mm > 0:
        raise _error(f"{where}: sigma_mm is {sigma_mm:g}", "it must be above 0")
    return target(name, place, (sigma_mm / 1000) ** 2 * np.eye(3))


def _number(row: dict[str, str], key: str, where: str) -> float:
    text = row.get(key, "").strip()
    try:
        value = float(text)
    except ValueError as error:
        raise _error(f'{where}: {key} is "{text}"', "give a number in metres") from error
    if not isfinite(value):
        raise _error(f"{where}: {key} is {text}", "give a number in metres")
    return value


def _error(cause: str, remedy: str) -> StageError:
    return StageError("targets", cause, remedy)
