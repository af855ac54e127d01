"""State of the area *mosaic*."""

import bpy


class CableTwinMosaic(bpy.types.PropertyGroup):
    """Nothing yet."""


classes = (CableTwinMosaic,)
