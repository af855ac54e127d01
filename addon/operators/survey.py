"""Operators of the survey: new, open, save; blocks and stations in their lists."""

import json
from pathlib import Path

import bpy
from bpy_extras.io_utils import ExportHelper, ImportHelper

from pipeline.cable.survey import Survey, survey_from, write_survey

from ..apply import open_survey, remember
from ..gather import survey_path, survey_values
from ..properties import shared
from ..properties.survey import add_block, add_station
from ..results.collections import SETUP
from ..results.sketch import refresh_sketch
from ..results.view import clear_startup, frame
from .base import Operator, take_out

_UNDOABLE = {"REGISTER", "UNDO"}


class CABLETWIN_OT_survey_new(Operator):
    """Start a survey with a ring of cameras at equal angles."""

    bl_idname = "cabletwin.survey_new"
    bl_label = "New Survey"
    bl_description = "Start a survey with a ring of cameras at equal angles"
    bl_options = _UNDOABLE

    cameras: shared.cameras(None)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask for the number of cameras."""
        return context.window_manager.invoke_props_dialog(self)

    def work(self, context: bpy.types.Context) -> None:
        """Empty the survey and lay out the ring."""
        scene = context.scene
        survey = scene.cabletwin.survey
        survey.blocks.clear()
        survey.stations.clear()
        for key in ("filepath", "written", "name", "travel", "travel_sigma_mm", "use_diameter", "diameter"):
            survey.property_unset(key)
        for key in ("standoff", "synchronised"):
            survey.property_unset(key)
        for _ in range(self.cameras):
            add_block(survey, self.cameras)
        survey.block_index = 0
        _present(context)


class CABLETWIN_OT_survey_open(Operator, ImportHelper):
    """Read a survey.toml into this scene."""

    bl_idname = "cabletwin.survey_open"
    bl_label = "Open Survey"
    bl_description = "Read a survey.toml into this scene"
    bl_options = _UNDOABLE

    filename_ext = ".toml"
    filter_glob: bpy.props.StringProperty(default="*.toml", options={"HIDDEN"})

    def work(self, context: bpy.types.Context) -> None:
        """Read it; the run folder beside it is proposed, and the truth if it is that of this survey."""
        path = Path(bpy.path.abspath(self.filepath))
        survey = open_survey(context.scene, path)
        run, truth = context.scene.cabletwin.run, path.parent / "truth.json"
        run.folder = str(path.parent / "run")
        run.truth = str(truth) if _is_truth_of(truth, survey) else ""
        _present(context)


class CABLETWIN_OT_survey_save(Operator, ExportHelper):
    """Write the survey to its file."""

    bl_idname = "cabletwin.survey_save"
    bl_label = "Save Survey"
    bl_description = "Write this scene's survey to survey.toml"
    bl_options = {"REGISTER"}

    filename_ext = ".toml"
    filter_glob: bpy.props.StringProperty(default="*.toml", options={"HIDDEN"})

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Save where it lies; ask only the first time or with Shift held."""
        known = context.scene.cabletwin.survey.filepath
        self.filepath = bpy.path.abspath(known) if known else "survey.toml"
        if known and not event.shift:
            return self.execute(context)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def work(self, context: bpy.types.Context) -> None:
        """Check it as a file is checked, then write."""
        save_survey(context.scene, Path(bpy.path.abspath(self.filepath)))


class CABLETWIN_OT_survey_block_add(Operator):
    """Add a camera to the ring."""

    bl_idname = "cabletwin.survey_block_add"
    bl_label = "Add Block"
    bl_description = "Add a camera, a quarter turn on from the last one"
    bl_options = _UNDOABLE

    def work(self, context: bpy.types.Context) -> None:
        """Append it and show it."""
        add_block(context.scene.cabletwin.survey)
        refresh_sketch(context.scene)


class CABLETWIN_OT_survey_block_remove(Operator):
    """Take the shown camera out of the ring."""

    bl_idname = "cabletwin.survey_block_remove"
    bl_label = "Remove Block"
    bl_description = "Take the chosen camera out of the survey"
    bl_options = _UNDOABLE

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be one."""
        return context.scene.cabletwin.survey.block() is not None

    def work(self, context: bpy.types.Context) -> None:
        """Remove it and show the one before."""
        survey = context.scene.cabletwin.survey
        survey.block_index = take_out(survey.blocks, survey.block_index)
        refresh_sketch(context.scene)


class CABLETWIN_OT_survey_station_add(Operator):
    """Add a station."""

    bl_idname = "cabletwin.survey_station_add"
    bl_label = "Add Station"
    bl_description = "Add a place where the diameter is wanted, in the middle of the travel or 50 mm on"
    bl_options = _UNDOABLE

    def work(self, context: bpy.types.Context) -> None:
        """Append it and show it."""
        survey = context.scene.cabletwin.survey
        places = [s.position for s in survey.stations]
        add_station(survey, min(max(places) + 0.05, survey.travel) if places else survey.travel / 2)
        refresh_sketch(context.scene)


class CABLETWIN_OT_survey_station_remove(Operator):
    """Take the shown station out."""

    bl_idname = "cabletwin.survey_station_remove"
    bl_label = "Remove Station"
    bl_description = "Take the chosen station out of the survey"
    bl_options = _UNDOABLE

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be one."""
        survey = context.scene.cabletwin.survey
        return 0 <= survey.station_index < len(survey.stations)

    def work(self, context: bpy.types.Context) -> None:
        """Remove it and show the one before."""
        survey = context.scene.cabletwin.survey
        survey.station_index = take_out(survey.stations, survey.station_index)
        refresh_sketch(context.scene)


class CABLETWIN_OT_survey_lens_to_all(Operator):
    """Give every block the lens of the shown one."""

    bl_idname = "cabletwin.survey_lens_to_all"
    bl_label = "Copy Lens to All Blocks"
    bl_description = "Give every camera the lens of the chosen one"
    bl_options = _UNDOABLE

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be one to copy."""
        return context.scene.cabletwin.survey.block() is not None

    def work(self, context: bpy.types.Context) -> None:
        """Copy each lens property."""
        survey = context.scene.cabletwin.survey
        # a lambda that is set forgets its sigma, also in the block that is copied
        lens = [(key, getattr(survey.block(), key)) for key in LENS_KEYS]
        for block in survey.blocks:
            for key, value in lens:
                setattr(block, key, value)


def _is_truth_of(path: Path, survey: Survey) -> bool:
    """Whether a file tells the diameter of one of the stations: a run with another truth is refused."""
    # pipeline.evaluate reads it too, but brings pycolmap, which ends Debian's Blender
    try:
        truth = json.loads(path.read_text(encoding="utf-8"))
        known = {station["name"] for station in truth["stations"]}
    except (OSError, ValueError, KeyError, TypeError):
        return False
    return not known.isdisjoint(station.name for station in survey.cable.stations)


def _present(context: bpy.types.Context) -> None:
    """Sketch the set-up and look at it."""
    refresh_sketch(context.scene)
    clear_startup(context.scene)
    frame(context, context.scene, SETUP)


LENS_KEYS = (
    *("focal_in", "focal_px", "focal_mm", "sensor_width_mm", "use_principal_point", "principal_point_px"),
    *("lambda_known", "division_lambda", "lambda_radius", "lambda_sigma", "lambda_from", "calibrated"),
)


def save_survey(scene: bpy.types.Scene, path: Path) -> None:
    """Check the scene's survey and write it to ``path``, which becomes its place.

    Raises:
        StageError: what a survey file would be refused for, or the place cannot be written.
    """
    survey = scene.cabletwin.survey
    values = survey_from(survey_values(survey), path.parent)
    write_survey(values, path)
    survey.filepath = str(path)
    remember(survey, values, path)
    if not scene.cabletwin.run.folder:
        scene.cabletwin.run.folder = str(survey_path(survey).parent / "run")


classes = (
    CABLETWIN_OT_survey_new,
    CABLETWIN_OT_survey_open,
    CABLETWIN_OT_survey_save,
    CABLETWIN_OT_survey_block_add,
    CABLETWIN_OT_survey_block_remove,
    CABLETWIN_OT_survey_station_add,
    CABLETWIN_OT_survey_station_remove,
    CABLETWIN_OT_survey_lens_to_all,
)
