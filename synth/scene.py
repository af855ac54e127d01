"""The Blender scene: cable, material, the ring's lamps, a plain sky, render settings.  Needs bpy.

Takes the specification and the texture file; gives a :class:`Scene` that can be posed and rendered.  Leaves
out the order of the frames and everything after the light reached the sensor.
"""

import math
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

from pipeline.core.vocabulary import Array
from synth.lens_camera import make_camera
from synth.material import LitMaterial
from synth.mesh import CableMesh, cable_mesh
from synth.spec import Spec

LAMP_LIGHT = 0.062  # of one lamp at 1 m, relative to white; four of them expose a grey sheath well


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Handles on what moves: the scene, its camera, and the material that knows its lamps."""

    scene: bpy.types.Scene
    camera: bpy.types.Object
    sheath: LitMaterial


def build_scene(spec: Spec, texture: Path | None) -> Scene:
    """Build the scene anew in an empty Blender file.

    Args:
        spec: the survey.
        texture: picture from :func:`synth.texture.encode`, first row at the far end; None for a plain grey.
    """
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    _settings(scene, spec)
    cable = _mesh_object(cable_mesh(spec.cable, spec.robot))
    strength = LAMP_LIGHT * spec.light.lamp_strength
    sheath = LitMaterial(
        texture,
        lamps=len(spec.blocks),
        strength=strength,
        ambient=spec.light.daylight,
        gloss=spec.cable.material.gloss,
    )
    cable.data.materials.append(sheath.material)
    scene.collection.objects.link(cable)
    _sky(scene, spec)
    return Scene(scene=scene, camera=make_camera(scene), sheath=sheath)


def lamps_in_ring(spec: Spec) -> Array:
    """Places of the lamps, one half-way to the next camera, (cameras, 3) metres in the ring's frame.

    Light from aside keeps the glare of the sheath out of the cameras and lights the girth evenly.
    """
    cameras = np.radians(np.sort(np.mod(spec.angles_deg, 360.0)))
    gaps = np.mod(np.roll(cameras, -1) - cameras, 2.0 * np.pi)
    azimuth = cameras + (
        gaps / 2.0 if len(cameras) > 1 else math.radians(45.0)
    )  # half-way is behind a single one
    return spec.robot.standoff_m * np.stack(
        [np.cos(azimuth), np.zeros_like(azimuth), -np.sin(azimuth)], axis=1
    )


def _settings(scene: bpy.types.Scene, spec: Spec) -> None:
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y = spec.lens.width_px, spec.lens.height_px
    render.resolution_percentage = 100
    render.use_persistent_data = True
    render.threads_mode, render.threads = "FIXED", 2
    render.image_settings.media_type = "MULTI_LAYER_IMAGE"
    render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
    render.image_settings.color_depth = "32"
    render.image_settings.exr_codec = "NONE"
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False  # it would smear the texture that matching lives on
    cycles.max_bounces = 0
    cycles.sample_clamp_direct = 0.0
    scene.view_layers[0].use_pass_position = True


def _mesh_object(mesh: CableMesh) -> bpy.types.Object:
    data = bpy.data.meshes.new("cable")
    data.vertices.add(len(mesh.vertices))
    data.vertices.foreach_set("co", mesh.vertices.astype(np.float32).ravel())
    data.loops.add(mesh.quads.size)
    data.loops.foreach_set("vertex_index", mesh.quads.ravel())
    data.polygons.add(len(mesh.quads))
    data.polygons.foreach_set("loop_start", np.arange(0, mesh.quads.size, 4, dtype=np.int32))
    layer = data.uv_layers.new(name="unrolled")
    layer.uv.foreach_set("vector", mesh.uv.ravel())
    data.update(calc_edges=True)
    data.shade_smooth()
    return bpy.data.objects.new("cable", data)


def _sky(scene: bpy.types.Scene, spec: Spec) -> None:
    """A smooth gradient from ground to zenith, seen by the camera only."""
    world = bpy.data.worlds.new("sky")
    scene.world = world
    nodes, links = world.node_tree.nodes, world.node_tree.links
    nodes.clear()
    place = nodes.new("ShaderNodeTexCoord")
    height = nodes.new("ShaderNodeSeparateXYZ")
    ramp = nodes.new("ShaderNodeMapRange")
    ramp.inputs["From Min"].default_value, ramp.inputs["From Max"].default_value = -1.0, 1.0
    colours = nodes.new("ShaderNodeValToRGB")
    for stop, colour in zip(
        colours.color_ramp.elements, ((0.10, 0.11, 0.10, 1), (0.62, 0.70, 0.80, 1)), strict=True
    ):
        stop.color = colour
    colours.color_ramp.interpolation = "EASE"
    sky = nodes.new("ShaderNodeBackground")
    output = nodes.new("ShaderNodeOutputWorld")
    links.new(place.outputs["Generated"], height.inputs["Vector"])
    links.new(height.outputs["Z"], ramp.inputs["Value"])
    links.new(ramp.outputs["Result"], colours.inputs["Fac"])
    links.new(colours.outputs["Color"], sky.inputs["Color"])
    links.new(sky.outputs["Background"], output.inputs["Surface"])
    sky.inputs["Strength"].default_value = spec.light.sky
    world.cycles.sampling_method = "NONE"
