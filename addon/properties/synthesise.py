"""State of the area *synthesise*: ring, lens, motion, sheath, light, sensor, and what the survey will claim.

The cable's shape is not here: it is in the inputs of its modifier, where
:mod:`..synthetic_cable` reads it.
"""

import math
from typing import Any

import bpy

from ..synthetic_cable import is_cable


def _is_cable(self: bpy.types.PropertyGroup, item: bpy.types.Object) -> bool:
    return is_cable(item)


def _follow_ring(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    from ..results.ring import refresh_ring

    refresh_ring(self.id_data)


def _follow_sheath(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    from ..synthetic_cable import refresh_sheath

    refresh_sheath(self.id_data)


_STRENGTH: dict[str, Any] = {"min": 0, "max": 1, "subtype": "FACTOR", "update": _follow_sheath}
_SMALL_ANGLE: dict[str, Any] = {
    "min": 0,
    "soft_max": math.radians(2),
    "subtype": "ANGLE",
    "unit": "ROTATION",
    "precision": 2,
    "step": 1,
}
_MILLIMETRES: dict[str, Any] = {"min": 0, "soft_max": 10, "precision": 2, "step": 10}


class CableTwinSynthesise(bpy.types.PropertyGroup):
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

    cameras: bpy.props.IntProperty(
        name="Cameras",
        description="Cameras around the cable, at equal angles",
        default=4,
        min=1,
        max=16,
        update=_follow_ring,
    )
    standoff: bpy.props.FloatProperty(
        name="Stand-off",
        description="From the centre of a camera to the axis of the cable",
        subtype="DISTANCE",
        unit="LENGTH",
        default=0.3,
        min=0.01,
        precision=4,
        update=_follow_ring,
    )
    frames: bpy.props.IntProperty(
        name="Frames each",
        description="Frames that each camera takes on its way",
        default=24,
        min=2,
        soft_max=200,
        update=_follow_ring,
    )
    travel_in_image: bpy.props.EnumProperty(
        name="Travel in image",
        description="Direction of the image in which the robot's travel points",
        items=(
            ("right", "Right", "The robot travels towards the right edge"),
            ("left", "Left", "The robot travels towards the left edge"),
            ("up", "Up", "The robot travels towards the upper edge"),
            ("down", "Down", "The robot travels towards the lower edge"),
        ),
        update=_follow_ring,
    )
    synchronised: bpy.props.BoolProperty(
        name="Synchronised",
        description="All cameras share one clock and one motion; else each makes a pass of its own",
        default=True,
    )

    focal_px: bpy.props.FloatProperty(
        name="Focal length", description="In pixels", default=720, min=1, precision=2, update=_follow_ring
    )
    width_px: bpy.props.IntProperty(
        name="Width", description="Of the image, in pixels", default=960, min=16, update=_follow_ring
    )
    height_px: bpy.props.IntProperty(
        name="Height", description="Of the image, in pixels", default=600, min=16, update=_follow_ring
    )
    division_lambda: bpy.props.FloatProperty(
        name="Lambda",
        description="Distortion of the division model; negative is barrel",
        default=-0.02,
        soft_min=-0.3,
        soft_max=0.3,
        precision=4,
        step=0.1,
    )
    lambda_radius: bpy.props.EnumProperty(
        name="Radius in",
        description="What the radius of lambda is measured in",
        items=(
            ("half-diagonal", "Half diagonal", "Of the image"),
            ("half-width", "Half width", "Of the image"),
            ("focal", "Focal length", "The focal length"),
            ("pixel", "Pixels", "A pixel"),
        ),
    )
    focal_spread_percent: bpy.props.FloatProperty(
        name="Spread (%)",
        description="Standard deviation of the cameras' own focal lengths",
        min=0,
        soft_max=5,
        precision=2,
    )

    sway: bpy.props.FloatProperty(
        name="Sway", description="Root mean square of each of the ring's three rotations", **_SMALL_ANGLE
    )
    sway_mm: bpy.props.FloatProperty(
        name="Sway (mm)",
        description="Root mean square of the ring's displacements across the cable",
        **_MILLIMETRES,
    )
    speed_wander_mm: bpy.props.FloatProperty(
        name="Wander (mm)", description="Root mean square deviation from even travel", **_MILLIMETRES
    )
    mounting: bpy.props.FloatProperty(
        name="Mounting", description="Standard deviation of each camera's constant angles", **_SMALL_ANGLE
    )
    mounting_mm: bpy.props.FloatProperty(
        name="Mounting (mm)",
        description="Standard deviation of each camera's constant displacement",
        **_MILLIMETRES,
    )

    kind: bpy.props.EnumProperty(
        name="Sheath",
        description="What the cable is made of in the rendered survey",
        items=(
            ("hdpe", "Polyethylene", "Weathered polyethylene"),
            ("painted", "Painted", "Grey paint"),
        ),
    )
    grain: bpy.props.FloatProperty(
        name="Grain", description="Fine natural mottling of the material itself", default=0.5, **_STRENGTH
    )
    dirt: bpy.props.FloatProperty(
        name="Dirt", description="Blotches of soot and dust", default=0.5, **_STRENGTH
    )
    streaks: bpy.props.FloatProperty(
        name="Streaks", description="Marks of running water along the cable", default=0.5, **_STRENGTH
    )
    scratches: bpy.props.FloatProperty(
        name="Scratches", description="Thin scrapes from handling", default=0.5, **_STRENGTH
    )
    speckle: bpy.props.FloatProperty(
        name="Specks", description="Lichen, splashes, grains of dust", default=0.5, **_STRENGTH
    )
    mottling: bpy.props.FloatProperty(
        name="Clouds", description="Faint clouds, centimetres wide", default=0.5, **_STRENGTH
    )
    gloss: bpy.props.FloatProperty(
        name="Gloss",
        description="0 is a matt sheath, 1 mirrors the lamps as glaring bands",
        default=0,
        **_STRENGTH,
    )
    texel_mm: bpy.props.FloatProperty(
        name="Texel (mm)",
        description="Side of a texel of the painted-on texture",
        default=0.2,
        min=0.05,
        soft_max=2,
        precision=2,
    )

    lamp_strength: bpy.props.FloatProperty(
        name="Lamps",
        description="Strength of the lamps that travel with the ring, relative to the usual",
        default=1,
        min=0.01,
        soft_max=4,
    )
    daylight: bpy.props.FloatProperty(
        name="Daylight",
        description="Even light from all around, relative to white",
        default=0.15,
        min=0,
        soft_max=1,
    )
    exposure: bpy.props.FloatProperty(
        name="Exposure", description="Factor on the light", default=1, min=0.01, soft_max=4
    )
    noise: bpy.props.BoolProperty(
        name="Sensor noise", description="Photon noise and read-out noise", default=True
    )
    motion_blur_mm: bpy.props.FloatProperty(
        name="Blur (mm)", description="Path of the ring while the shutter is open", **_MILLIMETRES
    )
    readout_share: bpy.props.FloatProperty(
        name="Rolling shutter",
        description="Time from the first to the last row, by the time from frame to frame",
        min=0,
        max=1,
        subtype="FACTOR",
    )
    samples: bpy.props.IntProperty(
        name="Samples", description="Rays for each pixel", default=8, min=1, soft_max=64
    )
    output: bpy.props.EnumProperty(
        name="Output",
        description="How the frames are delivered",
        items=(
            ("video", "Videos", "One H.264 video for each camera"),
            ("images", "Images", "One folder of PNG images for each camera"),
        ),
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
