"""Targets, axes and planes that a station's cloud shows, named by hand: a table name,kind,x,y,z.

Takes the file and what was found in the cloud; gives it with those names.  A row puts a point (station frame,
metres) onto or into a thing, and what was found there gets the name; the thing itself is fitted to its points
as ever.  Where two things lie about as near, neither is named: the row is refused.  Leaves out targets whose
places are listed (``target_table.py``) and names matched between stations (``naming.py``, ``figures.py``).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array
from pipeline.steel.csv_rows import number_in, read_rows, table_error
from pipeline.steel.records import Feature, FeatureKind, StationFeatures
from pipeline.steel.registration_options import TargetOptions

KINDS = {"target": FeatureKind.POINT, "axis": FeatureKind.LINE, "plane": FeatureKind.PLANE}
"""What a row may name."""
NEAR_M = 0.25
"""A point lies at most this far off the surface that it names."""
CLEAR, CLEAR_M = 2.0, 0.03
"""Another of that kind must lie off by so many times more, and so much besides."""
PLANE_REACHES = 2.5
"""A plane's cells lie within so many of its reach, which is their root mean square distance."""

_COLUMNS = ("name", "kind", "x", "y", "z")
_KIND_OF = {kind: word for word, kind in KINDS.items()}


@dataclass(frozen=True, kw_only=True)
class Naming:
    """A row: the kind of thing at a place (3,), station frame, that gets a name; ``where``: file and line."""

    name: str
    kind: FeatureKind
    place: Array
    where: str


def read_name_table(path: Path) -> tuple[Naming, ...]:
    """Read the names of one station's things.

    Raises:
        StageError: the file cannot be read, a column is missing, a value is no number, a kind is not known, a
            name is there twice in its kind.
    """
    rows = [_naming(row, where) for where, row in read_rows(path, _COLUMNS)]
    if not rows:
        raise table_error(f"{path} names nothing", "give a name a line, or leave station.names out")
    taken: dict[tuple[FeatureKind, str], str] = {}
    for row in rows:
        if (row.kind, row.name) in taken:
            raise table_error(
                f'{row.where} names a second {_KIND_OF[row.kind]} "{row.name}"', "give each its own name"
            )
        taken[row.kind, row.name] = row.where
    return tuple(rows)


def _naming(row: dict[str, str], where: str) -> Naming:
    if not row.get("name"):
        raise table_error(f"{where} has no name", "name the thing")
    kind = row.get("kind", "").lower()
    if kind not in KINDS:
        raise table_error(f'{where}: kind is "{kind}"', f"write one of {', '.join(KINDS)}")
    place = np.array([number_in(row, key, where) for key in "xyz"])
    return Naming(name=row["name"], kind=KINDS[kind], place=place, where=where)


def sought(options: TargetOptions, rows: Sequence[Naming]) -> TargetOptions:
    """The options, with the search for axes or planes on where one is named, wherever they are off."""
    kinds = {row.kind for row in rows}
    return replace(
        options,
        planes=options.planes or FeatureKind.PLANE in kinds,
        axes=options.axes or FeatureKind.LINE in kinds,
    )


def with_names(found: StationFeatures, rows: Sequence[Naming], options: TargetOptions) -> StationFeatures:
    """What was found in a station, named as the rows say; unnamed axes and planes only as ``options`` want.

    Raises:
        StageError: nothing of the kind lies at a row's place, more than one does, or two rows name one thing.
    """
    named: dict[int, Naming] = {}
    for row in rows:
        number = _at(found, row)
        if number in named:
            raise table_error(
                f'{row.where} names the same {_KIND_OF[row.kind]} "{row.name}" that {named[number].where} '
                f'names "{named[number].name}"',
                "put each point onto a thing of its own",
            )
        named[number] = row
    wanted = {FeatureKind.POINT: True, FeatureKind.LINE: options.axes, FeatureKind.PLANE: options.planes}
    features = tuple(
        replace(feature, name=named[n].name) if n in named else feature
        for n, feature in enumerate(found.features)
        if n in named or wanted[feature.kind]
    )
    return replace(found, features=features)


def _at(found: StationFeatures, row: Naming) -> int:
    """Number of the feature that a row names."""
    word = _KIND_OF[row.kind]
    near = sorted((_off_m(f, row.place), n) for n, f in enumerate(found.features) if f.kind is row.kind)
    if not near or near[0][0] > NEAR_M:
        raise _nothing_there(found.station, row, f"the nearest is {near[0][0]:.2f} m off" if near else "")
    if len(near) > 1 and near[1][0] < CLEAR * near[0][0] + CLEAR_M:
        raise table_error(
            f'{row.where}: the point of "{row.name}" lies {1000 * near[0][0]:.0f} mm off one {word} and '
            f"{1000 * near[1][0]:.0f} mm off another",
            f"put it onto the {word} itself, where no other is near",
        )
    return near[0][1]


def _nothing_there(station: str, row: Naming, nearest: str) -> StageError:
    more = {
        FeatureKind.POINT: "spheres of targets.radius_mm are found, as options.targets.farthest_m allows",
        FeatureKind.LINE: "options.targets.least_axis_m and axes_within_m bound what is found",
        FeatureKind.PLANE: "options.targets.least_plane_m2 bounds what is found",
    }[row.kind]
    word = _KIND_OF[row.kind]
    article = "an" if word[0] in "aeiou" else "a"
    return table_error(
        f'{row.where}: station {station} shows no {word} within {NEAR_M:g} m of the point of "{row.name}"'
        + (f" ({nearest})" if nearest else f" (it shows no {word} at all)"),
        f"give a point on {article} {word} (station frame, metres), or leave the row out: {more}",
    )


def _off_m(feature: Feature, place: Array) -> float:
    """How far a place (3,) lies outside a figure, and beyond what was seen of it."""
    away = place - feature.place
    along = float(away @ feature.direction)
    across = float(np.linalg.norm(away - along * feature.direction))
    if feature.kind is FeatureKind.POINT:
        return max(across - feature.radius_m, 0.0)
    if feature.kind is FeatureKind.LINE:
        return float(np.hypot(max(across - feature.radius_m, 0), max(abs(along) - feature.reach_m, 0)))
    return float(np.hypot(along, max(across - PLANE_REACHES * feature.reach_m, 0)))
