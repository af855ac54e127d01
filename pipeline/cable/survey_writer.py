"""Write a survey as survey.toml, so that reading it gives the same survey (the Blender add-on needs this).

Takes a :class:`~pipeline.cable.survey_records.Survey`; gives the file.  Leaves out comments and the order of
keys that a person may have chosen.
"""

import json
import os
from collections.abc import Iterator, Mapping
from pathlib import Path

from pipeline.cable.survey_records import Block, LensSpec, Survey
from pipeline.core.files import write_text


def write_survey(survey: Survey, path: Path) -> None:
    """Write the survey; sources and POS files are named relative to it where that is possible.

    Raises:
        StageError: the place cannot be written.
    """
    write_text(path, survey_toml(survey, path.parent.resolve()), "survey")


def survey_toml(survey: Survey, folder: Path) -> str:
    """Give the text of the survey file that would lie in this folder."""
    return "\n".join(_lines(survey, folder)) + "\n"


def _lines(survey: Survey, folder: Path) -> Iterator[str]:
    yield from _pairs({"format": survey.format, "name": survey.name})
    yield from ("", "[cable]")
    cable = survey.cable
    yield from _pairs(
        {
            "travel_m": cable.travel_m,
            "travel_sigma_mm": cable.travel_sigma_mm,
            "diameter_mm": cable.diameter_mm,
        }
    )
    for station in survey.cable.stations:
        yield "[[cable.station]]"
        yield from _pairs({"name": station.name, "position_m": station.position_m})
    yield from ("", "[robot]")
    yield from _pairs(vars(survey.robot))
    for block in survey.blocks:
        yield from ("", "[[block]]")
        yield from _pairs(_block_values(block, folder))
        yield "[block.lens]"
        yield from _pairs(_lens_values(block.lens_spec))
    for stage in survey.options:
        yield from ("", f"[options.{_key(stage)}]")
        yield from _pairs(survey.stage_options(stage))


def _block_values(block: Block, folder: Path) -> dict[str, object]:
    return {
        "name": block.name,
        "source": _relative(block.source, folder),
        "angle_deg": block.angle_deg,
        "travel_in_image": block.travel_in_image.value,
        "pos": None if block.pos is None else _relative(block.pos, folder),
        "ordered": None if block.ordered else False,
    }


def _lens_values(lens: LensSpec) -> dict[str, object]:
    return {**vars(lens), "lambda_radius": lens.lambda_radius.value}


def _relative(path: Path, folder: Path) -> str:
    try:
        return Path(os.path.relpath(path, folder)).as_posix()
    except ValueError:  # another drive has no relative path
        return path.as_posix()


def _pairs(values: Mapping[str, object]) -> Iterator[str]:
    return (f"{_key(key)} = {_toml(value)}" for key, value in values.items() if value is not None)


def _key(name: str) -> str:
    bare = name.isascii() and name.replace("_", "").replace("-", "").isalnum()
    return name if bare else json.dumps(name, ensure_ascii=False)


def _toml(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        # JSON's escapes are TOML's, but for DEL, which TOML wants escaped too
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_toml(item) for item in value) + "]"
    if isinstance(value, Mapping):
        inside = (f"{_key(k)} = {_toml(v)}" for k, v in value.items() if v is not None)
        return "{ " + ", ".join(inside) + " }"
    return repr(value)
