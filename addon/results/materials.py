"""Materials: the colour of points, and an unrolled picture on a mesh.  All of them light themselves.

A measured surface is looked at as the camera saw it: its own picture already holds light and shade.
"""

import bpy
import numpy as np


def attribute_material(attribute: str | None) -> bpy.types.Material:
    """The one material of points: their own colour, or a plain one where there is none."""
    name = f"CableTwin points {attribute or 'plain'}"
    found = bpy.data.materials.get(name)
    if found is not None:
        return found
    material, emission = _emission(name)
    if attribute is None:
        emission.inputs["Color"].default_value = material.diffuse_color = (0.95, 0.55, 0.1, 1)
        return material
    tree = material.node_tree
    node = tree.nodes.new("ShaderNodeAttribute")
    node.attribute_name = attribute
    tree.links.new(node.outputs["Color"], emission.inputs["Color"])
    return material


def plain_material(colour: tuple[float, float, float, float]) -> bpy.types.Material:
    """A material of one colour (linear), the same in every shading."""
    name = "CableTwin plain {:.2f} {:.2f} {:.2f}".format(*colour)
    found = bpy.data.materials.get(name)
    if found is not None:
        return found
    material, emission = _emission(name)
    emission.inputs["Color"].default_value = material.diffuse_color = colour
    return material


def picture_material(name: str, image: bpy.types.Image) -> bpy.types.Material:
    """A material that shows the picture at the mesh's texture coordinates."""
    material, emission = _emission(name)
    tree = material.node_tree
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = image
    tree.nodes.active = node  # what solid view with textures shows
    tree.links.new(node.outputs["Color"], emission.inputs["Color"])
    return material


def png(rgb: np.ndarray) -> bytes:
    """A picture (h, w, 3) uint8 sRGB as a PNG, packed quickly rather than tightly; touches no bpy."""
    import cv2

    done, packed = cv2.imencode(".png", rgb[..., ::-1], [cv2.IMWRITE_PNG_COMPRESSION, 1])
    if not done:
        raise ValueError(f"no picture: {rgb.shape}, {rgb.dtype}")
    return packed.tobytes()


def packed_image(name: str, packed: bytes) -> bpy.types.Image:
    """A PNG as an image inside the .blend, which Blender unpacks when it is first shown."""
    image = bpy.data.images.new(name, 8, 8, alpha=False)  # takes its size from the file
    image.pack(data=packed, data_len=len(packed))
    image.source = "FILE"
    return image


def _emission(name: str) -> tuple[bpy.types.Material, bpy.types.ShaderNode]:
    material = bpy.data.materials.new(name)
    tree = material.node_tree
    if tree is None:  # before 5.0 a material has no nodes until it is told so
        material.use_nodes = True
        tree = material.node_tree
    tree.nodes.clear()
    emission = tree.nodes.new("ShaderNodeEmission")
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(emission.outputs["Emission"], output.inputs["Surface"])
    return material, emission
