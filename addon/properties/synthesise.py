"""State of the area *synthesise*: ring, lens, motion, sheath, light, sensor, and what the survey will claim.

The cable's shape is not here: it is in the inputs of its modifier, where
:mod:`..synthetic_cable` reads it.
"""

import bpy

from ..synthetic_cable import is_cable
from .synthesise_look import Look
from .synthesise_ring import RingAndLens


def _is_cable(self: bpy.types.PropertyGroup, item: bpy.types.Object) -> bool:
    return is_cable(item)


class CableTwinSynthesise(RingAndLens, Look, bpy.types.PropertyGroup):
    """What a survey is rendered from, beside the cable."""

    folder: bpy.props.StringProperty(
        name="Survey folder",
        description="Where the rendered survey goes; a rendering that was interrupted there goes on",
        subtype="DIR_PATH",
    )
    cable: bpy.props.PointerProperty(
        name="Cable", description="The cable that is filmed", type=bpy.types.Object, poll=_is_cable
    )
    name: bpy.props.StringProperty(name="Name", description="Name of the survey", default="synthetic")
    seed: bpy.props.IntProperty(
        name="Seed",
        description="Of all that is drawn by chance: texture, sway, mountings, noise",
        default=1,
        min=0,
    )

    calibrated: bpy.props.BoolProperty(
        name="Calibrated", description="The survey calls focal length and lambda trusted"
    )
    lambda_given: bpy.props.BoolProperty(
        name="Lambda stated", description="The survey states lambda; else it is to be estimated", default=True
    )
    focal_error_percent: bpy.props.FloatProperty(
        name="Focal error (%)",
        description="The stated focal length is off by this much",
        soft_min=-10,
        soft_max=10,
        precision=2,
    )
    travel_error_percent: bpy.props.FloatProperty(
        name="Travel error (%)",
        description="The stated travel is off by this much",
        soft_min=-2,
        soft_max=2,
        precision=3,
    )


classes = (CableTwinSynthesise,)
