"""Where the extension keeps what the walk looks at; read, never set.  Runs inside Blender."""

import bpy


def state() -> bpy.types.PropertyGroup:
    """All of the scene."""
    return bpy.context.scene.cabletwin


def survey() -> bpy.types.PropertyGroup:
    """What survey.toml says."""
    return state().survey


def results() -> bpy.types.PropertyGroup:
    """The run that is shown."""
    return state().results


def job() -> bpy.types.PropertyGroup:
    """What runs at the moment."""
    return bpy.context.window_manager.cabletwin_job
