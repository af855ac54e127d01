"""What a synthetic survey shows: the sheath, the light, and the sensor's faults."""

from typing import Any

import bpy


def _follow_sheath(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    from ..synthetic_cable import refresh_sheath

    refresh_sheath(self.id_data)


_STRENGTH: dict[str, Any] = {"min": 0, "max": 1, "subtype": "FACTOR", "update": _follow_sheath}
_MILLIMETRES: dict[str, Any] = {"min": 0, "soft_max": 10, "precision": 2, "step": 10}


class Look:
    """A part of the area *synthesise*."""

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
