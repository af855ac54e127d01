"""Stage *survey*: what the user wrote down about cable, robot and cameras, read strictly from survey.toml.

Takes the file; gives a frozen :class:`Survey` with absolute paths, or one sentence that names the key.
Leaves out the images themselves: what needs the image size is checked when the frames are read.  The table
``[options.STAGE]`` is kept as it stands; whoever runs the stage binds it to the stage's options.
"""

import os
import re
import tomllib
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

from pipeline.cable.survey_records import Block, Cable, LensSpec, Robot, Station, Survey
from pipeline.cable.survey_writer import write_survey
from pipeline.core.errors import StageError
from pipeline.core.files import is_pattern, matching
from pipeline.core.options import build

__all__ = [
    "Block",
    "Cable",
    "LensSpec",
    "Robot",
    "Station",
    "Survey",
    "read_survey",
    "survey_from",
    "with_stations",
    "write_survey",
]

STATION_SPACING_M = 0.05
"""Distance between stations where the survey names none."""

_FOLDER_NAME = re.compile(r"[\w-][\w .-]*(?<![ .])")
_RESERVED = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?", re.IGNORECASE)
"""Names that Windows keeps for its devices."""


def read_survey(path: Path) -> Survey:
    """Read and check a survey file.

    Raises:
        StageError: the file is missing or no TOML; a key is unknown, missing, of a wrong type or impossible.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        reason = (error.strerror or "unknown reason").lower()
        raise _error(f"{path} cannot be read ({reason})", "give the path of a survey.toml") from error
    except UnicodeDecodeError as error:
        raise _error(f"{path} is no UTF-8 text", "give the path of a survey.toml") from error
    try:
        values = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise _error(f"{path} is no TOML: {error}", "correct that line") from error
    return survey_from(values, path.parent)


def survey_from(values: Mapping[str, object], folder: Path) -> Survey:
    """Build a survey from a mapping laid out as survey.toml; paths are relative to the folder.

    Raises:
        StageError: as for :func:`read_survey`.
    """
    # first of all: a file of another format may well have other keys
    written = values.get("format", 1)
    if written != 1:
        raise _error(f"format is {written}", "this program reads format = 1")
    survey = build(Survey, values)
    _check_cable(survey.cable)
    survey = replace(survey, cable=with_stations(survey.cable))
    survey = replace(survey, blocks=tuple(_with_absolute_paths(b, folder.resolve()) for b in survey.blocks))
    _check_names(survey)
    _check_places(survey)
    for block in survey.blocks:
        _check_lens(block)
        _check_files(block)
    _check_order(survey)
    for stage, table in survey.options.items():
        if not isinstance(table, Mapping):
            raise _error(f"options.{stage} is no table", f"write the options under [options.{stage}]")
    return survey


def with_stations(cable: Cable) -> Cable:
    """Give the cable stations every 50 mm over the travel, S1, S2 and so on, where it has none."""
    if cable.stations:
        return cable
    inner = range(1, 1 + int(cable.travel_m / STATION_SPACING_M - 1e-9))
    # a strip shorter than one spacing is measured in its middle
    places = [round(k * STATION_SPACING_M, 9) for k in inner] or [cable.travel_m / 2]
    stations = tuple(Station(name=f"S{k}", position_m=y) for k, y in enumerate(places, start=1))
    return replace(cable, stations=stations)


def _error(cause: str, remedy: str) -> StageError:
    return StageError("survey", cause, remedy)


def _with_absolute_paths(block: Block, folder: Path) -> Block:
    for key, written in (("source", block.source), ("pos", block.pos)):
        if written is not None and not written.parts:
            raise _error(f"block[{block.name}].{key} is empty", "name a file")
    return replace(
        block,
        source=_absolute(block.source, folder),
        pos=None if block.pos is None else _absolute(block.pos, folder),
    )


def _absolute(path: Path, folder: Path) -> Path:
    # by the letters only: resolving would follow links away from where the user put them
    return Path(os.path.normpath(folder / path.expanduser()))


def _check_cable(cable: Cable) -> None:
    if cable.travel_m == 0:
        raise _error(
            "cable.travel_m is zero, but the known travel is what gives the model its scale",
            "measure the robot's path between the first and the last frame",
        )
    if cable.travel_m < 0:
        raise _error(f"cable.travel_m is {cable.travel_m:g}", "give the path as a positive length in metres")
    for station in cable.stations:
        if station.position_m > cable.travel_m:
            raise _error(
                f"cable.station[{station.name}].position_m = {station.position_m:g} lies outside the travel",
                f"give a position between 0 and {cable.travel_m:g}",
            )


def _check_names(survey: Survey) -> None:
    if not survey.blocks:
        raise _error("block is an empty list", "describe at least one camera under [[block]]")
    for key, names in (
        ("cable.station", [station.name for station in survey.cable.stations]),
        ("block", [block.name for block in survey.blocks]),
    ):
        for name in _repeated(n.lower() for n in names):
            raise _error(f'{key}.name "{name}" is there more than once', "give each its own name")
        if not all(name.strip() for name in names):
            raise _error(f"{key}.name is empty", "give a name")
    for block in survey.blocks:
        if not _FOLDER_NAME.fullmatch(block.name) or _RESERVED.fullmatch(block.name):
            raise _error(
                f'block.name "{block.name}" cannot be the name of a folder',
                "use letters, digits, - and _ only",
            )


def _check_places(survey: Survey) -> None:
    cable, standoff = survey.cable, survey.robot.standoff_m
    if cable.diameter_mm is not None and standoff <= cable.diameter_mm / 2000:
        raise _error(
            f"robot.standoff_m = {standoff:g} puts the cameras inside a cable of {cable.diameter_mm:g} mm",
            "give the distance from camera centre to cable axis in metres",
        )
    angles = [round(block.angle_deg % 360, 6) % 360 for block in survey.blocks]
    for angle in _repeated(angles):
        names = [b.name for b, a in zip(survey.blocks, angles, strict=True) if a == angle]
        raise _error(
            f"block[{names[0]}].angle_deg and block[{names[1]}].angle_deg are both {angle:g}",
            "give each camera its own place around the cable",
        )


def _check_lens(block: Block) -> None:
    key, lens = f"block[{block.name}].lens", block.lens_spec
    in_mm = (lens.focal_mm, lens.sensor_width_mm)
    if lens.focal_px is not None and in_mm != (None, None):
        raise _error(
            f"{key} gives its focal length both in pixels and in millimetres", "leave one of them out"
        )
    if lens.focal_px is None and None in in_mm:
        raise _error(
            f"{key} has no focal length", f"give {key}.focal_px, or focal_mm together with sensor_width_mm"
        )
    if lens.lambda_sigma is not None and lens.division_lambda is None:
        raise _error(
            f"{key}.lambda_sigma is given without the {key}.division_lambda whose standard deviation it is",
            "give division_lambda too, or leave lambda_sigma out",
        )
    if lens.lambda_sigma is not None and lens.calibrated:
        raise _error(
            f"{key}.lambda_sigma is given, but {key}.calibrated = true trusts lambda without any error",
            "leave one of them out",
        )


def _check_files(block: Block) -> None:
    source, key = block.source, f"block[{block.name}]"
    if is_pattern(source):
        if not matching(source):
            raise _error(f"{key}.source: no file matches {source}", "correct the pattern")
    elif not source.exists():
        raise _error(f"{key}.source: {source} does not exist", "correct the path or bring the file there")
    if block.pos is not None and not block.pos.is_file():
        raise _error(f"{key}.pos: {block.pos} does not exist", "correct the path or leave the key out")


def _check_order(survey: Survey) -> None:
    unordered = [block.name for block in survey.blocks if not block.ordered]
    for block in survey.blocks:
        if not block.ordered and block.source.is_file():
            raise _error(
                f"block[{block.name}].ordered = false, but its source is a video, whose frames are in order",
                "leave the key out, or give a folder of images",
            )
    if survey.robot.synchronised and 0 < len(unordered) < len(survey.blocks):
        raise _error(
            f"block[{unordered[0]}].ordered = false, but other blocks are in order and "
            "robot.synchronised = true ties all blocks frame by frame",
            "set robot.synchronised = false, so that each block is adjusted alone and the mosaic joins them",
        )


def _repeated[T](values: Iterable[T]) -> list[T]:
    return [value for value, count in Counter(values).items() if count > 1]
