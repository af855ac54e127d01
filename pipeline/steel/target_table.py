"""Targets named by hand: a table name,x,y,z[,sigma_mm] in the frame of a station.

Takes the file; gives point features with a covariance.  Leaves out targets found in a cloud (``targets.py``).
"""

from pathlib import Path

import numpy as np

from pipeline.core.vocabulary import Array
from pipeline.steel.csv_rows import number_in, read_rows, table_error
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
    features = [_feature(row, where, scanner) for where, row in read_rows(path, _COLUMNS, (_OPTIONAL,))]
    names = [feature.name for feature in features]
    for name in names:
        if names.count(name) > 1:
            raise table_error(f'{path} has the target "{name}" more than once', "give each its own name")
    if not features:
        raise table_error(f"{path} has no target", "give the targets that the station sees, one a line")
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
    name = row.get("name", "")
    if not name:
        raise table_error(f"{where} has no name", "name the target")
    place = np.array([number_in(row, key, where) for key in "xyz"])
    if not row.get(_OPTIONAL, ""):
        if not place.any():
            raise table_error(f"{where} puts a target into the scanner itself", "correct its coordinates")
        return target(name, place, point_covariance(place, scanner))
    sigma_mm = number_in(row, _OPTIONAL, where)
    if not sigma_mm > 0:
        raise table_error(f"{where}: sigma_mm is {sigma_mm:g}", "it must be above 0")
    return target(name, place, (sigma_mm / 1000) ** 2 * np.eye(3))
