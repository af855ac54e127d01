"""What runs at the moment, on the window manager: nothing of it is saved."""

import bpy


def _redraw(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


class CableTwinJob(bpy.types.PropertyGroup):
    """The one job that may run: a reconstruction or a rendering."""

    running: bpy.props.BoolProperty(update=_redraw)
    cancelling: bpy.props.BoolProperty(
        description="Asked to stop; the job ends within two seconds", update=_redraw
    )
    kind: bpy.props.StringProperty()
    scene: bpy.props.StringProperty()
    stage: bpy.props.StringProperty(update=_redraw)
    block: bpy.props.StringProperty(update=_redraw)
    fraction: bpy.props.FloatProperty(min=0, max=1, update=_redraw)
    seconds_left: bpy.props.FloatProperty(default=-1, update=_redraw)
    log: bpy.props.StringProperty(subtype="FILE_PATH")
    failure: bpy.props.StringProperty(update=_redraw)


classes = (CableTwinJob,)
