"""What runs at the moment, on the window manager: nothing of it is saved."""

import bpy

from ..sidebar import redraw_sidebars

SHOWING = "show"
"""What stands for a stage while results are brought in."""


class CableTwinJob(bpy.types.PropertyGroup):
    """The one job that may run: a reconstruction or a rendering.

    Nothing here has an update function: with one, Blender draws the whole window anew at each setting, and
    its views eight times more.  Set with :meth:`tell` what the panels show.
    """

    running: bpy.props.BoolProperty()
    cancelling: bpy.props.BoolProperty(description="Asked to stop; the job ends within two seconds")
    kind: bpy.props.StringProperty()
    scene: bpy.props.StringProperty()
    stage: bpy.props.StringProperty()
    part: bpy.props.StringProperty(description="Segment of a long survey, such as 2/5")
    block: bpy.props.StringProperty()
    fraction: bpy.props.FloatProperty(min=0, max=1)
    seconds_left: bpy.props.FloatProperty(default=-1)
    log: bpy.props.StringProperty(subtype="FILE_PATH")
    failure: bpy.props.StringProperty()

    def tell(self, **values: object) -> None:
        """Set properties, and draw the panels again."""
        for key, value in values.items():
            setattr(self, key, value)
        redraw_sidebars(bpy.context)


classes = (CableTwinJob,)
