"""The panel *Lens*: the shown block's lens, its preview, and the two ways to come by it."""

import bpy
from bpy.app.translations import pgettext_iface as translated

from ..properties.block import CableTwinBlock
from .base import Panel, aligned, sentence
from .reconstruct import draw_progress


class CABLETWIN_PT_lens(Panel):
    """Lens."""

    bl_idname = "CABLETWIN_PT_lens"
    bl_label = "Lens"
    bl_order = 1

    def draw(self, context: bpy.types.Context) -> None:
        """Which block, its preview, lambda and its origin."""
        survey, view = context.scene.cabletwin.survey, context.scene.cabletwin.lens
        block = survey.block()
        if block is None:
            self.layout.label(text="Start with a new survey or open one", icon="INFO")
            return
        self.layout.template_list(
            "CABLETWIN_UL_blocks", "lens", survey, "blocks", survey, "block_index", rows=2
        )
        self.layout.operator("cabletwin.lens_show", icon="IMAGE_DATA")
        if view.problem:
            sentence(self.layout.box(), view.problem, "ERROR")
        column = aligned(self.layout)
        column.prop(view, "frame")
        row = column.row(heading="Grid")
        row.prop(view, "use_grid", text="")
        cells = row.row()
        cells.enabled = view.use_grid
        cells.prop(view, "grid_cells", text="")
        column.separator()
        column.prop(block, "division_lambda", slider=True)
        column.prop(block, "lambda_radius")
        _focal(column, block)
        column.prop(block, "lambda_known")
        if block.sigma_counts():
            column.prop(block, "lambda_sigma")
        column.prop(block, "calibrated")
        _origin(self.layout, block)


class CABLETWIN_PT_lens_edges(Panel):
    """Lambda from the cable's own edges."""

    bl_label = "From the cable's edges"
    bl_parent_id = "CABLETWIN_PT_lens"
    bl_options = set()

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A block must be shown."""
        return context.scene.cabletwin.survey.block() is not None

    def draw(self, context: bpy.types.Context) -> None:
        """The buttons, or the progress."""
        job = context.window_manager.cabletwin_job
        if job.running and job.kind == "lens":
            draw_progress(self.layout, job)
            return
        row = self.layout.row(align=True)
        row.operator("cabletwin.lens_estimate", icon="DRIVER_DISTANCE")
        row.operator("cabletwin.lens_estimate", text="All blocks").every = True


class CABLETWIN_PT_lens_board(Panel):
    """The lens from pictures of a chessboard."""

    bl_label = "From a chessboard"
    bl_parent_id = "CABLETWIN_PT_lens"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A block must be shown."""
        return context.scene.cabletwin.survey.block() is not None

    def draw(self, context: bpy.types.Context) -> None:
        """Folder, size, and the buttons."""
        view = context.scene.cabletwin.lens
        column = aligned(self.layout)
        column.prop(view, "board_folder")
        column.row().prop(view, "board_corners")
        row = self.layout.row(align=True)
        row.operator("cabletwin.lens_chessboard", icon="TEXTURE")
        row.operator("cabletwin.lens_chessboard", text="All blocks").every = True


def _focal(column: bpy.types.UILayout, block: CableTwinBlock) -> None:
    column.prop(block, "focal_in")
    if block.focal_in == "PX":
        column.prop(block, "focal_px")
    else:
        column.prop(block, "focal_mm")
        column.prop(block, "sensor_width_mm")
    column.prop(block, "use_principal_point")
    if block.use_principal_point:
        column.prop(block, "principal_point_px", text="x, y")


def _origin(layout: bpy.types.UILayout, block: CableTwinBlock) -> None:
    """Where lambda comes from and how well it is known; what a run will do with it."""
    column = layout.column(align=True)
    if block.lambda_sigma > 0 and block.lambda_from != "HAND":
        text = translated("From a chessboard") if block.lambda_from == "BOARD" else translated("Estimated")
        column.label(text=text, icon="CHECKMARK", translate=False)
        figures = f"{block.division_lambda:.5f} ± {block.lambda_sigma:.5f}".replace("-", "−")
        column.label(text=figures, icon="BLANK1", translate=False)
    if not block.lambda_known:
        column.label(text="Estimated in each run", icon="INFO")
    layout.operator("cabletwin.survey_lens_to_all", icon="DUPLICATE")


classes = (CABLETWIN_PT_lens, CABLETWIN_PT_lens_edges, CABLETWIN_PT_lens_board)
