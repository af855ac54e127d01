"""State of the area *lens*: the frame that is looked at, the grid over it, the chessboard's folder."""

import bpy


def _redraw(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    from ..results.lens_view import schedule

    schedule()


class CableTwinLens(bpy.types.PropertyGroup):
    """The preview of the shown block's lens, and what is needed to calibrate it."""

    frame: bpy.props.IntProperty(
        name="Frame",
        description="Number of the frame that is shown, from 0",
        min=0,
        soft_max=200,
        update=_redraw,
    )
    frames: bpy.props.IntProperty(name="Frames", description="Frames in the video of the shown block")
    use_grid: bpy.props.BoolProperty(
        name="Grid",
        description="Draw a grid over the frame that is straight where no distortion is left",
        update=_redraw,
    )
    grid_cells: bpy.props.IntProperty(
        name="Cells",
        description="Cells of the grid across the picture",
        default=12,
        min=2,
        soft_max=40,
        max=100,
        update=_redraw,
    )
    before: bpy.props.PointerProperty(
        name="Before", description="The frame as the camera took it", type=bpy.types.Image
    )
    after: bpy.props.PointerProperty(
        name="After", description="The frame without distortion", type=bpy.types.Image
    )
    problem: bpy.props.StringProperty(description="Why the preview does not follow, one sentence")
    board_folder: bpy.props.StringProperty(
        name="Pictures",
        description="Folder of pictures of one chessboard, taken with this camera from different sides",
        subtype="DIR_PATH",
    )
    board_corners: bpy.props.IntVectorProperty(
        name="Inner corners",
        description="Inner corners of the board, along and across",
        size=2,
        default=(9, 6),
        min=3,
        soft_max=30,
    )


classes = (CableTwinLens,)
