"""The panel *Steel structure*: reconstruct or open a run; tables of columns and nodes that lead the eye."""

import bpy
from bpy.app.translations import pgettext_iface as translated
from bpy.app.translations import pgettext_n as n_

from ..properties.steel import STEEL_STAGES
from ..results import steel_collections
from .base import Panel, RowList, aligned, eyes, sentence
from .reconstruct import draw_progress
from .steel_text import WINDS, gross_text, size_text

_STAGE_NAMES = {name: label for name, label, _ in STEEL_STAGES}
_FIRST = 0.2
"""Share of a row that its name gets."""
_SIZE = 0.45
"""Share of what is left that the first figure gets; the others have the rest in equal parts."""


class CABLETWIN_UL_steel_columns(RowList):
    """Columns: name, deviation, direction, 1/n, and whether the limit is kept."""

    def draw_row(self, row: bpy.types.UILayout, item: bpy.types.PropertyGroup) -> None:
        """One column."""
        scene = item.id_data
        cells = (
            size_text(scene, item.deviation_mm),
            translated(WINDS.get(item.direction, item.direction)),
            f"1/{item.ratio:.0f}" if item.ratio > 0 else "–",
        )
        verdict = "ERROR" if item.over else "CHECKMARK"
        _table_row(row, item.name, cells, verdict if item.certain else "QUESTION")


class CABLETWIN_UL_steel_nodes(RowList):
    """Nodes: name, eccentricity, its sigma, and whether it is significant."""

    def draw_row(self, row: bpy.types.UILayout, item: bpy.types.PropertyGroup) -> None:
        """One node."""
        scene = item.id_data
        cells = (size_text(scene, item.size_mm), size_text(scene, item.sigma_mm, 2))
        known = item.size_mm >= 0
        verdict = "ERROR" if item.significant else "CHECKMARK"
        _table_row(row, item.name, cells, verdict if known else "QUESTION")


class CABLETWIN_PT_steel(Panel):
    """Steel structure."""

    bl_idname = "CABLETWIN_PT_steel"
    bl_label = "Steel structure"
    bl_order = 10

    def draw(self, context: bpy.types.Context) -> None:
        """Settings and the buttons, or the progress of what runs."""
        job, steel = context.window_manager.cabletwin_job, context.scene.cabletwin.steel
        settings = aligned(self.layout)
        settings.enabled = not job.running
        settings.prop(steel, "survey")
        settings.prop(steel, "run_folder")
        settings.prop(steel, "truth")
        if job.running and job.kind == "steel":
            draw_progress(self.layout, job, _STAGE_NAMES)
        else:
            row = self.layout.row()
            row.scale_y = 1.4
            row.operator("cabletwin.steel_run", text="Reconstruct", icon="PLAY")
        if job.failure and job.kind == "steel":
            sentence(self.layout.box(), job.failure, "ERROR")
        if job.log and job.kind == "steel":
            self.layout.operator("cabletwin.reconstruct_log", icon="TEXT")
        row = self.layout.row(align=True)
        row.operator("cabletwin.steel_choose", text="Open Folder", icon="FILE_FOLDER")
        again = row.row(align=True)
        again.enabled = bool(steel.run_folder)
        again.operator("cabletwin.steel_open", text="Reload", icon="FILE_REFRESH")
        if steel.folder:
            self.layout.operator("cabletwin.steel_report", icon="URL")
            _figures(self.layout, context.scene)


class CABLETWIN_PT_steel_columns(Panel):
    """The columns as a table."""

    bl_label = "Steel columns"
    bl_parent_id = "CABLETWIN_PT_steel"
    bl_options = set()

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be columns."""
        return len(context.scene.cabletwin.steel.columns) > 0

    def draw(self, context: bpy.types.Context) -> None:
        """Click a row to look at the column."""
        steel = context.scene.cabletwin.steel
        head = (n_("Deviation"), n_("Leans"), "1/n")
        _table_row(self.layout.row(), "", [translated(t) for t in head], "NONE")
        self.layout.template_list(
            "CABLETWIN_UL_steel_columns", "", steel, "columns", steel, "column_index", rows=5
        )
        column = steel.columns[min(steel.column_index, len(steel.columns) - 1)]
        limit = size_text(context.scene, column.limit_mm)
        _figure(self.layout, translated("Limit"), limit)
        _figure(self.layout, translated("Sigma"), size_text(context.scene, column.sigma_mm, 2))


class CABLETWIN_PT_steel_nodes(Panel):
    """The nodes as a table."""

    bl_label = "Nodes"
    bl_parent_id = "CABLETWIN_PT_steel"
    bl_options = set()

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be nodes."""
        return len(context.scene.cabletwin.steel.nodes) > 0

    def draw(self, context: bpy.types.Context) -> None:
        """Click a row to look at the ball."""
        steel = context.scene.cabletwin.steel
        head = (n_("Eccentricity"), n_("Sigma"))
        _table_row(self.layout.row(), "", [translated(t) for t in head], "NONE")
        self.layout.template_list("CABLETWIN_UL_steel_nodes", "", steel, "nodes", steel, "node_index", rows=5)


class CABLETWIN_PT_steel_gross(Panel):
    """Gross errors of the registration."""

    bl_label = "Gross errors"
    bl_parent_id = "CABLETWIN_PT_steel"
    bl_options = set()

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be one."""
        return len(context.scene.cabletwin.steel.gross) > 0

    def draw(self, context: bpy.types.Context) -> None:
        """A button for each, which turns the view to it."""
        column = self.layout.column(align=True)
        for index, item in enumerate(context.scene.cabletwin.steel.gross):
            text = gross_text(context.scene, item)
            column.operator(
                "cabletwin.steel_gross_show", text=text, icon="VIEWZOOM", translate=False
            ).index = index


class CABLETWIN_PT_steel_display(Panel):
    """What the 3D view shows of the structure."""

    bl_label = "Display"
    bl_parent_id = "CABLETWIN_PT_steel"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Something must be shown."""
        return bool(context.scene.cabletwin.steel.folder)

    def draw(self, context: bpy.types.Context) -> None:
        """Scales, and one line for each collection: its eye and how much is in it."""
        steel = context.scene.cabletwin.steel
        column = aligned(self.layout)
        column.prop(steel, "arrow_scale")
        column.prop(steel, "error_scale")
        eyes(self.layout, context, steel_collections)


def _figures(layout: bpy.types.UILayout, scene: bpy.types.Scene) -> None:
    steel = scene.cabletwin.steel
    box = layout.box().column(align=True)
    _figure(box, translated("Scanner stations"), str(steel.stations))
    _figure(box, translated("Largest sigma"), size_text(scene, steel.largest_sigma_mm, 2))
    if steel.columns:
        over = sum(item.over for item in steel.columns)
        _figure(
            box,
            translated("Columns over their limit"),
            translated("{} of {}").format(over, len(steel.columns)),
        )
    if steel.nodes:
        eccentric = sum(item.significant for item in steel.nodes)
        _figure(
            box, translated("Eccentric nodes"), translated("{} of {}").format(eccentric, len(steel.nodes))
        )
    if steel.sag_limit_mm >= 0:
        sag = f"{size_text(scene, steel.sag_mm)} ({steel.sag_node})"
        _figure(box, translated("Largest deflection"), sag, "ERROR" if steel.sag_over else "NONE")
        _figure(box, translated("Limit"), size_text(scene, steel.sag_limit_mm))
    for warning in filter(None, steel.warnings.split("\n")):
        sentence(layout.box(), warning, "ERROR")


def _table_row(row: bpy.types.UILayout, name: str, cells: tuple[str, ...] | list[str], icon: str) -> None:
    split = row.split(factor=_FIRST)
    split.label(text=name, translate=False)
    rest = split.row()
    columns = rest.split(factor=_SIZE)  # fixed widths, so that head and rows stand below each other
    for text in cells:
        cell = columns.row()
        cell.alignment = "RIGHT"
        cell.label(text=text, translate=False)
    rest.label(text="", icon=icon if icon != "NONE" else "BLANK1")


def _figure(layout: bpy.types.UILayout, name: str, text: str, icon: str = "NONE") -> None:
    row = layout.row()
    row.label(text=name, translate=False)
    right = row.row()
    right.alignment = "RIGHT"
    right.label(text=text, icon=icon, translate=False)


classes = (
    CABLETWIN_UL_steel_columns,
    CABLETWIN_UL_steel_nodes,
    CABLETWIN_PT_steel,
    CABLETWIN_PT_steel_columns,
    CABLETWIN_PT_steel_nodes,
    CABLETWIN_PT_steel_gross,
    CABLETWIN_PT_steel_display,
)
