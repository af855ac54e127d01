"""What moves and looks in a synthetic survey: the ring, its cameras' lens, and how it sways."""

import math
from typing import Any

import bpy

from . import shared


def _follow_ring(self: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    from ..results.ring import refresh_ring

    refresh_ring(self.id_data)


_SMALL_ANGLE: dict[str, Any] = {
    "min": 0,
    "soft_max": math.radians(2),
    "subtype": "ANGLE",
    "unit": "ROTATION",
    "precision": 2,
    "step": 1,
}
_MILLIMETRES: dict[str, Any] = {"min": 0, "soft_max": 10, "precision": 2, "step": 10}


class RingAndLens:
    """A part of the area *synthesise*."""

    cameras: shared.cameras(_follow_ring)
    standoff: shared.standoff(_follow_ring)
    frames: bpy.props.IntProperty(
        name="Frames each",
        description="Frames that each camera takes on its way",
        default=24,
        min=2,
        soft_max=200,
        update=_follow_ring,
    )
    travel_in_image: shared.travel_in_image(_follow_ring)
    synchronised: shared.synchronised()

    focal_px: shared.focal_px(_follow_ring)
    width_px: bpy.props.IntProperty(
        name="Width", description="Of the image, in pixels", default=960, min=16, update=_follow_ring
    )
    height_px: bpy.props.IntProperty(
        name="Height", description="Of the image, in pixels", default=600, min=16, update=_follow_ring
    )
    division_lambda: shared.division_lambda(-0.02, None)
    lambda_radius: shared.lambda_radius(None)
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
