"""From the pipeline's survey to the scene's properties."""

import json
import math
import tomllib
from pathlib import Path

import bpy

from pipeline.cable.survey import Survey, read_survey
from pipeline.cable.survey_records import Block
from pipeline.cable.survey_writer import survey_toml
from pipeline.core.options import build

from .properties.block import CableTwinBlock
from .properties.survey import CableTwinSurvey


def open_survey(scene: bpy.types.Scene, path: Path) -> Survey:
    """Read a survey file into the scene, in place of what was there.

    Raises:
        StageError: what the pipeline refuses.
    """
    survey = read_survey(path)
    apply_survey(scene.cabletwin.survey, survey, path)
    apply_crop(scene, survey)
    return survey


def apply_survey(survey: CableTwinSurvey, values: Survey, path: Path) -> None:
    """Set every property from the survey that lies at ``path``."""
    survey.filepath = str(path)
    remember(survey, values, path)
    survey.name = values.name
    cable, robot = values.cable, values.robot
    survey.travel, survey.travel_sigma_mm = cable.travel_m, cable.travel_sigma_mm
    survey.use_diameter = cable.diameter_mm is not None
    if cable.diameter_mm is not None:
        survey.diameter = cable.diameter_mm / 1000
    survey.standoff, survey.synchronised = robot.standoff_m, robot.synchronised
    survey.stations.clear()
    for station in cable.stations:
        item = survey.stations.add()
        item.name, item.position = station.name, station.position_m
    survey.blocks.clear()
    for block in values.blocks:
        _apply_block(survey.blocks.add(), block)
    survey.block_index = survey.station_index = 0


def apply_crop(scene: bpy.types.Scene, values: Survey) -> None:
    """Set the options of the crop from the survey's; a preview of another survey's blocks ends.

    Raises:
        StageError: a value is out of its range.
    """
    from pipeline.cable.crop import CropOptions

    from .results.crop_preview import end_preview

    end_preview(scene)
    crop = scene.cabletwin.crop
    options = build(CropOptions, values.stage_options("crop"), key="options.crop")
    crop.incidence, crop.least_score = math.radians(options.incidence_deg), options.least_score
    crop.fringe = options.fringe_mm / 1000
    for use, key, value in (("use_start", "start", options.from_m), ("use_end", "end", options.to_m)):
        setattr(crop, use, value is not None)
        if value is not None:
            setattr(crop, key, value)


def remember(survey: CableTwinSurvey, values: Survey, path: Path) -> None:
    """Keep the survey as its file holds it, for :mod:`.gather`; call after reading and after writing."""
    survey.written = json.dumps(tomllib.loads(survey_toml(values, path.parent.resolve())))


def _apply_block(block: CableTwinBlock, values: Block) -> None:
    block.name = values.name
    block.source = str(values.source)
    block.angle = math.radians(values.angle_deg)
    block.travel_in_image = values.travel_in_image.value
    block.pos = str(values.pos or "")
    block.ordered = values.ordered
    lens = values.lens_spec
    block.focal_in = "MM" if lens.focal_px is None else "PX"
    for key in ("focal_px", "focal_mm", "sensor_width_mm"):
        if getattr(lens, key) is not None:
            setattr(block, key, getattr(lens, key))
    block.use_principal_point = lens.principal_point_px is not None
    if lens.principal_point_px is not None:
        block.principal_point_px = lens.principal_point_px
    block.lambda_known = lens.division_lambda is not None
    block.division_lambda = lens.division_lambda or 0.0
    block.lambda_radius = lens.lambda_radius.value
    block.lambda_sigma = lens.lambda_sigma or 0.0
    block.calibrated = lens.calibrated
