"""The steel structure in Blender: mesh, painted surfaces, daylight, render settings.  Needs bpy.

Takes a mesh and the lens; gives the scene and its camera.  The look is noise in space, so it repeats nowhere
and needs no pictures.  Leaves out poses and everything after the light reached the sensor.
"""

from dataclasses import dataclass

import bpy
import mathutils
import numpy as np

from pipeline.core.vocabulary import Lens
from synth.lens_camera import make_camera, set_lens
from synth.scan.mesh import Mesh

SUN_ENERGY = 2.2
AMBIENT = 0.3  # of the albedo, sent out evenly: skylight without a sampled sky, so without its grain
SKY = (0.34, 0.38, 0.45, 1.0)
SUN_TILT_RAD = (0.55, 0.35)


@dataclass(frozen=True, kw_only=True)
class Look:
    """How one kind of thing is painted: two colours mixed by noise, ``grains_per_m`` at its coarsest."""

    dark: tuple[float, float, float]
    light: tuple[float, float, float]
    grains_per_m: float


LOOKS = {
    "steel": Look(dark=(0.06, 0.03, 0.02), light=(0.70, 0.72, 0.74), grains_per_m=24.0),
    "floor": Look(dark=(0.20, 0.19, 0.17), light=(0.46, 0.44, 0.40), grains_per_m=2.5),
    "target": Look(dark=(0.80, 0.80, 0.80), light=(0.90, 0.90, 0.90), grains_per_m=2.0),
}
LOOK_OF = {"floor": "floor", "wall": "floor", "box": "floor", "target": "target"}


def build_photo_scene(
    mesh: Mesh, names: tuple[str, ...], lens: Lens
) -> tuple[bpy.types.Scene, bpy.types.Object]:
    """Build the scene anew in an empty Blender file; gives it and its camera.

    Args:
        mesh: the world in the hall's frame.
        names: of the mesh's owners; what stands before the colon chooses the look.
        lens: of the camera.
    """
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    _settings(scene, lens)
    looks = list(LOOKS)
    index = np.array([looks.index(LOOK_OF.get(name.split(":")[0], "steel")) for name in names])
    thing = _object(mesh, index[mesh.owner])
    for look in looks:
        thing.data.materials.append(_material(look, LOOKS[look]))
    scene.collection.objects.link(thing)
    _daylight(scene)
    camera = make_camera(scene)
    set_lens(camera, lens)
    return scene, camera


def _settings(scene: bpy.types.Scene, lens: Lens) -> None:
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y = lens.width_px, lens.height_px
    render.resolution_percentage = 100
    render.use_persistent_data = True
    render.threads_mode, render.threads = "FIXED", 2
    render.image_settings.media_type = "MULTI_LAYER_IMAGE"
    render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
    render.image_settings.color_depth = "32"
    render.image_settings.exr_codec = "NONE"
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    cycles.max_bounces = 0
    scene.view_layers[0].use_pass_position = True


def _object(mesh: Mesh, material_index: np.ndarray) -> bpy.types.Object:
    data = bpy.data.meshes.new("steel")
    data.vertices.add(len(mesh.vertices))
    data.vertices.foreach_set("co", mesh.vertices.astype(np.float32).ravel())
    data.loops.add(mesh.quads.size)
    data.loops.foreach_set("vertex_index", mesh.quads.ravel().astype(np.int32))
    data.polygons.add(len(mesh.quads))
    data.polygons.foreach_set("loop_start", np.arange(0, mesh.quads.size, 4, dtype=np.int32))
    data.polygons.foreach_set("material_index", material_index.astype(np.int32))
    data.update(calc_edges=True)
    data.validate()  # a pole's quads have two corners in one place
    return bpy.data.objects.new("steel", data)


def _material(name: str, look: Look) -> bpy.types.Material:
    """Matt paint; fractal noise of the place in space mixes the two colours."""
    material = bpy.data.materials.new(name)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    place, noise = nodes.new("ShaderNodeNewGeometry"), nodes.new("ShaderNodeTexNoise")
    ramp, matt, glow = (
        nodes.new(kind) for kind in ("ShaderNodeValToRGB", "ShaderNodeBsdfDiffuse", "ShaderNodeEmission")
    )
    both, output = nodes.new("ShaderNodeAddShader"), nodes.new("ShaderNodeOutputMaterial")
    glow.inputs["Strength"].default_value = AMBIENT
    material.cycles.emission_sampling = "NONE"
    noise.inputs["Scale"].default_value = look.grains_per_m
    noise.inputs["Detail"].default_value = 6.0
    noise.inputs["Roughness"].default_value = 0.75
    for stop, place_on_ramp, colour in zip(
        ramp.color_ramp.elements, (0.36, 0.64), (look.dark, look.light), strict=True
    ):
        stop.position, stop.color = place_on_ramp, (*colour, 1.0)
    links.new(place.outputs["Position"], noise.inputs["Vector"])
    links.new(noise.outputs["Fac"], ramp.inputs["Fac"])
    links.new(ramp.outputs["Color"], matt.inputs["Color"])
    links.new(ramp.outputs["Color"], glow.inputs["Color"])
    links.new(matt.outputs["BSDF"], both.inputs[0])
    links.new(glow.outputs["Emission"], both.inputs[1])
    links.new(both.outputs["Shader"], output.inputs["Surface"])
    return material


def _daylight(scene: bpy.types.Scene) -> None:
    """A sharp sun, whose shadows stay while the camera flies, and a sky that only the camera sees."""
    sun = bpy.data.lights.new("sun", "SUN")
    sun.energy, sun.angle = SUN_ENERGY, 0.0
    lamp = bpy.data.objects.new("sun", sun)
    lamp.rotation_euler = mathutils.Euler((*SUN_TILT_RAD, 0.0))
    scene.collection.objects.link(lamp)
    world = bpy.data.worlds.new("sky")
    scene.world = world
    world.node_tree.nodes["Background"].inputs["Color"].default_value = SKY
    world.cycles.sampling_method = "NONE"
