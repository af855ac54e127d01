"""State of the area *lens*."""

import bpy


class CableTwinLens(bpy.types.PropertyGroup):
    """Nothing yet."""


classes = (CableTwinLens,)
