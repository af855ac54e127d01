"""How long a rendering will take, roughly: figures of a machine with two cores."""

import bpy

from .synthetic_cable import asset_modifier, read_inputs, scene_cable

RENDER_S = 0.25
"""Of each exposure, whatever its size: Blender's own work and the check of the rays."""

RAY_S = 0.35e-6
TEXEL_S = 2.0e-6
MOMENTS, STRIPES, MOMENTS_OF_STRIPE = 8, 12, 4
"""Exposures of a frame with motion blur; stripes with a rolling shutter; of each stripe with both."""


def render_seconds(scene: bpy.types.Scene) -> float:
    """Time for the survey that the scene describes, in seconds: good to a factor of two."""
    settings = scene.cabletwin.synthesise
    blurred, rolling = settings.motion_blur_mm > 0, settings.readout_share > 0
    exposures = 1
    if rolling:
        exposures = STRIPES * (MOMENTS_OF_STRIPE if blurred else 1)
    elif blurred:
        exposures = MOMENTS
    rays = settings.width_px * settings.height_px * settings.samples
    frame_s = exposures * RENDER_S + rays * RAY_S
    return settings.cameras * settings.frames * frame_s + _texels(scene) * TEXEL_S


def _texels(scene: bpy.types.Scene) -> float:
    cable = scene_cable(scene)
    modifier = asset_modifier(cable, "cable") if cable else None
    if modifier is None:
        return 0.0
    inputs = read_inputs(modifier)
    texel_m = scene.cabletwin.synthesise.texel_mm / 1000
    girth_m = 3.15 * inputs["", "Diameter (mm)"] / 1000
    return float((inputs["", "Travel"] + 2 * inputs["", "Margin"]) * girth_m / texel_m**2)
