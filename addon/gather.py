"""From the scene's properties to the pipeline's records, right before a call.

Blender keeps numbers in 32 bits.  The survey as its file holds it is kept beside them: where a property still
says the same, the file's own digits count, so that the extension and the command line measure the same to the
last digit.  Leaves out checking: the pipeline's own reader does that and names the key.
"""

import json
import math
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import bpy

from pipeline.cable.survey import Survey, survey_from
from pipeline.core.errors import StageError
from pipeline.core.options import build

from .properties.block import CableTwinBlock
from .properties.survey import CableTwinSurvey

if TYPE_CHECKING:
    from pipeline.cable.crop import CropOptions


def gather_survey(scene: bpy.types.Scene) -> Survey:
    """The scene's survey, checked as the pipeline checks a file.

    Raises:
        StageError: what survey.toml would be refused for, or the survey was never saved.
    """
    survey = scene.cabletwin.survey
    if not survey.filepath:
        raise StageError("survey", "the survey is not saved", "save it first: its paths count from there")
    return survey_from(survey_values(survey), survey_path(survey).parent)


def gather_blocks(scene: bpy.types.Scene, *names: str, constructed: bool = False) -> Survey:
    """The survey of these blocks alone, checked in the same way: for what looks at one camera at a time.

    Args:
        scene: that holds the survey.
        names: of the blocks.
        constructed: leave their POS files out.

    Raises:
        StageError: no such block, or what survey.toml would be refused for.
    """
    survey = scene.cabletwin.survey
    values = survey_values(survey)
    described = values["block"]
    written = described if isinstance(described, list) else []
    chosen = [dict(block) for name in names for block in written if block["name"] == name]
    if len(chosen) < len(names):
        raise StageError("survey", "the survey has no such block", "choose one in the panel Survey")
    for block in chosen if constructed else ():
        block.pop("pos", None)
    folder = survey_path(survey).parent if survey.filepath else Path(bpy.path.abspath("//"))
    return survey_from({**values, "block": chosen}, folder)


def survey_path(survey: CableTwinSurvey) -> Path:
    """The absolute path of the survey's file."""
    return Path(bpy.path.abspath(survey.filepath))


def survey_values(survey: CableTwinSurvey) -> dict[str, object]:
    """A mapping laid out as survey.toml."""
    written = json.loads(survey.written or "{}")
    cable: dict[str, object] = {
        "travel_m": survey.travel,
        "travel_sigma_mm": survey.travel_sigma_mm,
        "diameter_mm": 1000 * survey.diameter if survey.use_diameter else None,
        "station": [{"name": s.name, "position_m": s.position} for s in survey.stations] or None,
    }
    values = {
        "format": 1,
        "name": survey.name,
        "cable": cable,
        "robot": {"standoff_m": survey.standoff, "synchronised": survey.synchronised},
        "block": [_block_values(block) for block in survey.blocks],
        "options": written.get("options"),
    }
    restored = _restored(values, written)
    return restored if isinstance(restored, dict) else {}


def _block_values(block: CableTwinBlock) -> dict[str, object]:
    return {
        "name": block.name,
        "source": bpy.path.abspath(block.source),
        "angle_deg": math.degrees(block.angle),
        "travel_in_image": block.travel_in_image,
        "pos": bpy.path.abspath(block.pos) if block.pos_from == "CSV" else None,
        "ordered": block.ordered,
        "lens": lens_values(block),
    }


def lens_values(block: CableTwinBlock) -> dict[str, object]:
    """A mapping laid out as survey.toml's ``[block.lens]``."""
    in_px = block.focal_in == "PX"
    return {
        "focal_px": block.focal_px if in_px else None,
        "focal_mm": None if in_px else block.focal_mm,
        "sensor_width_mm": None if in_px else block.sensor_width_mm,
        "principal_point_px": list(block.principal_point_px) if block.use_principal_point else None,
        "division_lambda": block.division_lambda if block.lambda_known else None,
        "lambda_sigma": block.lambda_sigma if block.sigma_counts() and block.lambda_sigma > 0 else None,
        "lambda_radius": block.lambda_radius,
        "calibrated": block.calibrated,
    }


def crop_options(scene: bpy.types.Scene) -> "CropOptions":
    """The options of the crop as the panel shows them, checked as the pipeline checks them.

    Raises:
        StageError: a value is out of its range.
    """
    from pipeline.cable.crop import CropOptions

    return build(CropOptions, _crop_values(scene), key="options.crop")


def write_crop(scene: bpy.types.Scene) -> None:
    """Put the panel's options of the crop into the survey; those that the pipeline starts with are left out.

    Raises:
        StageError: a value is out of its range.
    """
    from pipeline.cable.crop import CropOptions

    survey, usual = scene.cabletwin.survey, vars(CropOptions())
    chosen = {k: v for k, v in vars(crop_options(scene)).items() if v != usual[k]}
    written = json.loads(survey.written or "{}")
    options = {**written.get("options", {}), "crop": chosen}
    survey.written = json.dumps({**written, "options": {k: v for k, v in options.items() if v}})


def _crop_values(scene: bpy.types.Scene) -> dict[str, object]:
    from pipeline.cable.crop import CropOptions

    crop = scene.cabletwin.crop
    values = {
        "incidence_deg": math.degrees(crop.incidence),
        "least_score": crop.least_score,
        "fringe_mm": 1000 * crop.fringe,
        "from_m": crop.start if crop.use_start else None,
        "to_m": crop.end if crop.use_end else None,
    }
    written = json.loads(scene.cabletwin.survey.written or "{}").get("options", {}).get("crop", {})
    restored = _restored(values, {**vars(CropOptions()), **written})
    return restored if isinstance(restored, dict) else {}


def _restored(value: object, written: object) -> object:
    """The same values without empty ones, each number with the digits that were written or typed."""
    if isinstance(value, dict):
        old = written if isinstance(written, Mapping) else {}
        return {k: _restored(v, old.get(k)) for k, v in value.items() if v is not None}
    if isinstance(value, list):
        found = written if isinstance(written, list) else []
        return [_restored(v, found[n] if n < len(found) else None) for n, v in enumerate(value)]
    if isinstance(value, float):
        return _digits(value, written)
    return value


def _digits(value: float, written: object) -> float:
    """A 32-bit number as it was written, or else with the seven digits that 32 bits hold."""
    if isinstance(written, int | float) and math.isclose(value, written, rel_tol=2e-7, abs_tol=1e-9):
        return float(written)
    (short,) = struct.unpack("f", struct.pack("f", value))
    return float(f"{short:.7g}")
