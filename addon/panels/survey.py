"""The panel *Survey*: cable, robot and cameras, as survey.toml says them."""

import bpy

from ..properties.block import CableTwinBlock
from ..properties.survey import CableTwinSurvey
from .base import Panel, RowList, aligned


class CABLETWIN_UL_blocks(RowList):
    """Cameras with their angles."""

    def draw_row(self, row: bpy.types.UILayout, item: bpy.types.PropertyGroup) -> None:
        """Name, angle, and a sign where the video is missing."""
        row.prop(item, "name", text="", emboss=False, icon="CAMERA_DATA" if item.source else "ERROR")
        row.prop(item, "angle", text="", emboss=False)


class CABLETWIN_UL_stations(RowList):
    """Stations with their positions."""

    def draw_row(self, row: bpy.types.UILayout, item: bpy.types.PropertyGroup) -> None:
        """Name and position."""
        row.prop(item, "name", text="", emboss=False)
        row.prop(item, "position", text="", emboss=False)


class CABLETWIN_PT_survey(Panel):
    """Survey."""

    bl_idname = "CABLETWIN_PT_survey"
    bl_label = "Survey"
    bl_order = 0
    bl_options = set()

    def draw(self, context: bpy.types.Context) -> None:
        """File buttons, cable, robot."""
        survey = context.scene.cabletwin.survey
        row = self.layout.row(align=True)
        row.operator("cabletwin.survey_new", text="New", icon="FILE_NEW")
        row.operator("cabletwin.survey_open", text="Open", icon="FILE_FOLDER")
        saving = row.row(align=True)
        saving.enabled = len(survey.blocks) > 0
        saving.operator("cabletwin.survey_save", text="Save", icon="FILE_TICK")
        if not survey.blocks:
            self.layout.label(text="Start with a new survey or open one", icon="INFO")
            return
        column = aligned(self.layout)
        column.prop(survey, "name")
        column.separator()
        column.prop(survey, "travel")
        column.prop(survey, "travel_sigma_mm")
        row = column.row(heading="Diameter")
        row.prop(survey, "use_diameter", text="")
        value = row.row()
        value.enabled = survey.use_diameter
        value.prop(survey, "diameter", text="")
        column.separator()
        column.prop(survey, "standoff")
        column.prop(survey, "synchronised")


class CABLETWIN_PT_survey_blocks(Panel):
    """Cameras."""

    bl_label = "Blocks"
    bl_parent_id = "CABLETWIN_PT_survey"
    bl_options = set()

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be some."""
        return len(context.scene.cabletwin.survey.blocks) > 0

    def draw(self, context: bpy.types.Context) -> None:
        """The list, and the chosen camera below it."""
        survey = context.scene.cabletwin.survey
        row = self.layout.row()
        row.template_list("CABLETWIN_UL_blocks", "", survey, "blocks", survey, "block_index", rows=4)
        buttons = row.column(align=True)
        buttons.operator("cabletwin.survey_block_add", text="", icon="ADD")
        buttons.operator("cabletwin.survey_block_remove", text="", icon="REMOVE")
        block = survey.block()
        if block is not None:
            _block(self.layout, block)


class CABLETWIN_PT_survey_stations(Panel):
    """Stations."""

    bl_label = "Stations"
    bl_parent_id = "CABLETWIN_PT_survey"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a survey."""
        return len(context.scene.cabletwin.survey.blocks) > 0

    def draw(self, context: bpy.types.Context) -> None:
        """The list, or what happens without one."""
        survey: CableTwinSurvey = context.scene.cabletwin.survey
        row = self.layout.row()
        row.template_list("CABLETWIN_UL_stations", "", survey, "stations", survey, "station_index", rows=4)
        buttons = row.column(align=True)
        buttons.operator("cabletwin.survey_station_add", text="", icon="ADD")
        buttons.operator("cabletwin.survey_station_remove", text="", icon="REMOVE")
        if not survey.stations:
            self.layout.label(text="Without any: every 50 mm", icon="INFO")


def _block(layout: bpy.types.UILayout, block: CableTwinBlock) -> None:
    column = aligned(layout)
    column.prop(block, "source")
    column.prop(block, "angle")
    column.prop(block, "travel_in_image")
    column.prop(block, "ordered")


classes = (
    CABLETWIN_UL_blocks,
    CABLETWIN_UL_stations,
    CABLETWIN_PT_survey,
    CABLETWIN_PT_survey_blocks,
    CABLETWIN_PT_survey_stations,
)
