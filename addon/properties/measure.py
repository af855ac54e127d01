"""State of the area *measure*."""

import bpy


class CableTwinMeasure(bpy.types.PropertyGroup):
    """Nothing yet."""


classes = (CableTwinMeasure,)
