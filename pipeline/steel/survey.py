"""Stage *survey*: what the user wrote down about stations, targets and structure, read strictly from TOML.

Takes the file; gives a frozen :class:`~pipeline.steel.survey_records.SteelSurvey` with absolute paths, or one
sentence that names the key.  Leaves out what stands in the clouds and target tables (``clouds.py``,
``target_table.py``).  The table ``[options.STAGE]`` is kept as it stands; whoever runs the stage binds it to
the stage's options.
"""

import os
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from pipeline.core.errors import StageError
from pipeline.core.options import build
from pipeline.core.toml_file import read_toml
from pipeline.steel.survey_records import ControlTarget, PhotoSet, ScanStation, SteelSurvey

CLOUD_ENDINGS = (".e57", ".las", ".laz", ".ply", ".pts", ".xyz")
"""What clouds.py can read."""

FILES_OF_STATION = ("cloud", "targets", "names")
LEAST_STATIONS = 2
LEAST_CONTROL = 3

_FILE_NAME = re.compile(r"[\w-][\w .-]*(?<![ .])")
_RESERVED = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?", re.IGNORECASE)
"""Names that Windows keeps for its devices."""


def read_steel_survey(path: Path) -> SteelSurvey:
    """Read and check a survey file of a steel structure.

    Raises:
        StageError: the file is missing or no TOML; a key is unknown, missing, of a wrong type or impossible.
    """
    return steel_survey_from(read_toml(path, "survey", "a survey.toml"), path.parent)


def steel_survey_from(values: Mapping[str, object], folder: Path) -> SteelSurvey:
    """Build a survey from a mapping laid out as the file; paths are relative to the folder.

    Raises:
        StageError: as for :func:`read_steel_survey`.
    """
    # first of all: a file of another format or kind has other keys
    written = values.get("format", 1)
    if written != 1:
        raise _error(f"format is {written}", "this program reads format = 1")
    kind = values.get("kind")
    if kind != "steel":
        said = "is missing" if kind is None else f'is "{kind}"'
        raise _error(f"kind {said}", 'write kind = "steel", or run the survey of a cable with: pipeline run')
    survey = build(SteelSurvey, values)
    root = folder.resolve()
    survey = replace(
        survey,
        stations=tuple(_with_absolute_paths(s, root) for s in survey.stations),
        photos=_photos_absolute(survey.photos, root),
    )
    _check_names(survey)
    _check_bases(survey)
    for station in survey.stations:
        _check_files(station, survey)
    _check_control(survey.control)
    _check_columns(survey)
    _check_photos(survey.photos)
    for stage, table in survey.options.items():
        if not isinstance(table, Mapping):
            raise _error(f"options.{stage} is no table", f"write the options under [options.{stage}]")
    return survey


def _error(cause: str, remedy: str) -> StageError:
    return StageError("survey", cause, remedy)


def _with_absolute_paths(station: ScanStation, folder: Path) -> ScanStation:
    for key in FILES_OF_STATION:
        written = getattr(station, key)
        if written is not None and not written.parts:
            raise _error(f"station[{station.name}].{key} is empty", "name a file")

    def absolute(path: Path | None) -> Path | None:
        return None if path is None else _absolute(path, folder)

    return replace(
        station,
        cloud=absolute(station.cloud),
        targets=absolute(station.targets),
        names=absolute(station.names),
    )


def _photos_absolute(photos: PhotoSet | None, folder: Path) -> PhotoSet | None:
    if photos is None:
        return None
    if not photos.source.parts:
        raise _error("photos.source is empty", "name the folder of pictures")
    return replace(photos, source=_absolute(photos.source, folder))


def _absolute(path: Path, folder: Path) -> Path:
    # by the letters only: resolving would follow links away from where the user put them
    return Path(os.path.normpath(folder / path.expanduser()))


def _check_names(survey: SteelSurvey) -> None:
    count = len(survey.stations)
    if count < LEAST_STATIONS:
        raise _error(
            f"station has {count} entr{'y' if count == 1 else 'ies'}, but registering needs at least two",
            "describe each set-up of the scanner under [[station]]",
        )
    for key, names in (
        ("station", [station.name for station in survey.stations]),
        ("control", [target.name for target in survey.control]),
        ("column", [column.name for column in survey.columns]),
    ):
        _check_unique(key, names)
    for station in survey.stations:
        if not _FILE_NAME.fullmatch(station.name) or _RESERVED.fullmatch(station.name):
            raise _error(
                f'station.name "{station.name}" cannot be the name of a file',
                "use letters, digits, - and _ only",
            )


def _check_unique(key: str, names: Sequence[str]) -> None:
    # targets may differ by case only; the names of stations become names of files
    counted = Counter(name.lower() if key == "station" else name for name in names)
    for name, count in counted.items():
        if count > 1:
            raise _error(f'{key}.name "{name}" is there more than once', "give each its own name")
    if not all(name.strip() for name in names):
        raise _error(f"{key}.name is empty", "give a name")


def _check_bases(survey: SteelSurvey) -> None:
    bases = [station.name for station in survey.stations if station.base]
    if len(bases) > 1:
        raise _error(
            f"station[{bases[0]}].base and station[{bases[1]}].base are both true",
            "let one station alone be the base",
        )


def _check_files(station: ScanStation, survey: SteelSurvey) -> None:
    key = f"station[{station.name}]"
    if station.cloud is None and station.targets is None:
        raise _error(f"{key} has neither cloud nor targets", "name at least one of the files")
    for name in FILES_OF_STATION:
        path = getattr(station, name)
        if path is not None and not path.is_file():
            raise _error(f"{key}.{name}: {path} does not exist", "correct the path or bring the file there")
    if station.names is not None and station.cloud is None:
        raise _error(
            f"{key}.names is given without {key}.cloud, in which the named things would be found",
            f"give the cloud, or list the places of targets in {key}.targets",
        )
    if station.cloud is not None and station.cloud.suffix.lower() not in CLOUD_ENDINGS:
        raise _error(
            f"{key}.cloud: {station.cloud.name} is of a kind that is not known",
            f"give one of {', '.join(CLOUD_ENDINGS)}",
        )
    if station.targets is None and station.names is None and survey.targets.radius_mm is None:
        raise _error(
            f"targets.radius_mm is missing, but the targets of {key} are to be found in its cloud",
            f"give the radius of the spheres, or {key}.targets named by hand",
        )


def _check_control(control: Sequence[ControlTarget]) -> None:
    if 0 < len(control) < LEAST_CONTROL:
        raise _error(
            f"control has {len(control)} target{'s' if len(control) > 1 else ''}, too few to define a frame",
            f"give at least {LEAST_CONTROL} under [[control]], or none",
        )
    places = [target.position_m for target in control]
    for target in control:
        if places.count(target.position_m) > 1:
            raise _error(
                f"control[{target.name}].position_m is the place of another control target as well",
                "give each its own place",
            )


def _check_columns(survey: SteelSurvey) -> None:
    for column in survey.columns:
        if not column.top_m > column.bottom_m:
            raise _error(
                f"column[{column.name}].top_m = {column.top_m:g} does not lie above its bottom_m = "
                f"{column.bottom_m:g}",
                "give both as heights in metres in the site frame",
            )


def _check_photos(photos: PhotoSet | None) -> None:
    if photos is not None and not photos.source.is_dir():
        raise _error(f"photos.source: {photos.source} is no folder", "correct the path or leave [photos] out")
