"""State of the area *crop*."""

import bpy


class CableTwinCrop(bpy.types.PropertyGroup):
    """Nothing yet."""


classes = (CableTwinCrop,)
