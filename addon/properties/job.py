"""What runs at the moment, on the window manager: nothing of it is saved."""

import bpy


def redraw_sidebars(context: bpy.types.Context) -> None:
    """Draw the sidebars of the 3D views again, and not the views: those may take most of a second."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                for region in area.regions:
                    if region.type == "UI":
                        region.tag_redraw()


def _redraw(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    redraw_sidebars(context)


class CableTwinJob(bpy.types.PropertyGroup):
    """The one job that may run: a reconstruction or a rendering.

    What changes many times a second has no update function: with one, Blender draws the whole window anew at
    each setting.  Whoever sets it calls :func:`redraw_sidebars`.
    """

    running: bpy.props.BoolProperty(update=_redraw)
    cancelling: bpy.props.BoolProperty(
        description="Asked to stop; the job ends within two seconds", update=_redraw
    )
    kind: bpy.props.StringProperty()
    scene: bpy.props.StringProperty()
    stage: bpy.props.StringProperty()
    block: bpy.props.StringProperty()
    fraction: bpy.props.FloatProperty(min=0, max=1)
    seconds_left: bpy.props.FloatProperty(default=-1)
    log: bpy.props.StringProperty(subtype="FILE_PATH")
    failure: bpy.props.StringProperty(update=_redraw)


classes = (CableTwinJob,)
