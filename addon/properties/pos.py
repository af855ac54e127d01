"""State of the area *pos*."""

import bpy


class CableTwinPos(bpy.types.PropertyGroup):
    """Nothing yet."""


classes = (CableTwinPos,)
