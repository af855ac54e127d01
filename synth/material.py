"""The sheath's material with the ring's lamps in it: shading in closed form, free of noise.  Needs bpy.

A convex cable throws no shadow on itself, so light from point lamps can be written down exactly: per lamp a
matt term max(0, n.l) / d^2 and a soft highlight (Phong's lobe about the mirrored view ray).  As the material
emits the result, no light has to be sampled: few rays per pixel suffice and frames take a second.
"""

from pathlib import Path
from typing import Any

import bpy

from pipeline.core.vocabulary import Array

HIGHLIGHT = 0.16  # share of the highlight on a smooth sheath
HIGHLIGHT_EXPONENT = 14.0
GLOSSY_HIGHLIGHT, GLOSSY_EXPONENT = 1.6, 90.0  # at gloss 1


class LitMaterial:
    """The material and the places of its lamps.

    Args:
        texture: picture from :func:`synth.texture.encode`; None is a plain grey.
        lamps: number of lamps.
        strength: light of one lamp at 1 m, relative to white.
        ambient: light from all around.
        gloss: 0 is the soft sheen of an aged sheath, 1 the glare of a polished one.
    """

    def __init__(
        self, texture: Path | None, *, lamps: int, strength: float, ambient: float, gloss: float
    ) -> None:
        self._exponent = HIGHLIGHT_EXPONENT + gloss * (GLOSSY_EXPONENT - HIGHLIGHT_EXPONENT)
        highlight = HIGHLIGHT + gloss * (GLOSSY_HIGHLIGHT - HIGHLIGHT)
        self.material = bpy.data.materials.new("sheath")
        self.material.cycles.emission_sampling = "NONE"
        self._nodes = self.material.node_tree.nodes
        self._nodes.clear()
        self._geometry = self._nodes.new("ShaderNodeNewGeometry")
        view = self._vector("SCALE", self._geometry.outputs["Incoming"], scale=-1.0)
        self._mirrored = self._vector("REFLECT", view, self._geometry.outputs["Normal"])
        colour, roughness = self._surface(texture)
        self._places = [self._nodes.new("ShaderNodeCombineXYZ") for _ in range(lamps)]
        matt: Any = ambient
        mirrored: Any = 0.0
        for place in self._places:
            lamp_matt, lamp_gloss = self._lamp(place.outputs["Vector"])
            matt = self._math("MULTIPLY_ADD", lamp_matt, strength, matt)
            mirrored = self._math("MULTIPLY_ADD", lamp_gloss, strength, mirrored)
        smooth = self._math("SUBTRACT", 1.0, roughness)
        sheen = self._math("MULTIPLY", self._math("MULTIPLY", mirrored, highlight), smooth)
        light = self._vector("SCALE", colour, scale=matt)
        grey = self._nodes.new("ShaderNodeCombineXYZ")
        for axis in "XYZ":
            self._link(sheen, grey.inputs[axis])
        self._emit(self._vector("ADD", light, grey.outputs["Vector"]))

    def place_lamps(self, positions_in_world: Array) -> None:
        """Move the lamps: (lamps, 3), metres."""
        for node, position in zip(self._places, positions_in_world, strict=True):
            for socket, value in zip(node.inputs, position, strict=True):
                socket.default_value = float(value)

    def _surface(self, texture: Path | None) -> tuple[Any, Any]:
        if texture is None:
            grey = self._nodes.new("ShaderNodeRGB")
            grey.outputs[0].default_value = (0.3, 0.3, 0.3, 1.0)
            return grey.outputs[0], 0.6
        picture = self._nodes.new("ShaderNodeTexImage")
        picture.image = bpy.data.images.load(str(texture))
        picture.image.alpha_mode = "CHANNEL_PACKED"
        picture.interpolation = "Linear"
        return picture.outputs["Color"], picture.outputs["Alpha"]

    def _lamp(self, place: Any) -> tuple[Any, Any]:  # noqa: ANN401 - node sockets have no public type
        """Matt and highlight term of one lamp, both over the squared distance."""
        to_lamp = self._vector("SUBTRACT", place, self._geometry.outputs["Position"])
        squared = self._vector("DOT_PRODUCT", to_lamp, to_lamp)
        distance = self._math("SQRT", squared)
        cube = self._math("MULTIPLY", squared, distance)
        facing = self._math(
            "MAXIMUM", self._vector("DOT_PRODUCT", self._geometry.outputs["Normal"], to_lamp), 0.0
        )
        mirrored = self._math("DIVIDE", self._vector("DOT_PRODUCT", self._mirrored, to_lamp), distance)
        lobe = self._math("POWER", self._math("MAXIMUM", mirrored, 0.0), self._exponent)
        return self._math("DIVIDE", facing, cube), self._math("DIVIDE", lobe, squared)

    def _emit(self, light: Any) -> None:  # noqa: ANN401
        emission = self._nodes.new("ShaderNodeEmission")
        output = self._nodes.new("ShaderNodeOutputMaterial")
        self._link(light, emission.inputs["Color"])
        self._link(emission.outputs["Emission"], output.inputs["Surface"])

    def _math(self, operation: str, *values: Any) -> Any:  # noqa: ANN401
        node = self._nodes.new("ShaderNodeMath")
        node.operation = operation
        for socket, value in zip(node.inputs, values, strict=False):
            self._link(value, socket)
        return node.outputs["Value"]

    def _vector(self, operation: str, *values: Any, scale: Any = None) -> Any:  # noqa: ANN401
        node = self._nodes.new("ShaderNodeVectorMath")
        node.operation = operation
        for socket, value in zip(node.inputs, values, strict=False):
            self._link(value, socket)
        if scale is not None:
            self._link(scale, node.inputs["Scale"])
        return node.outputs["Value" if operation == "DOT_PRODUCT" else "Vector"]

    def _link(self, value: Any, socket: Any) -> None:  # noqa: ANN401
        if isinstance(value, float):
            socket.default_value = value
        else:
            self.material.node_tree.links.new(value, socket)
