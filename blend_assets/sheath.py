"""What the sheath looks like: one shader group that ages it, and four materials made of it.

For the eye, in EEVEE and Cycles, in the layers of ``synth.texture``: grain, clouds, soot, water, specks.
Coordinates are the object's, in metres with +y along the cable, so nothing shows a seam.  The rendered survey
paints its own texture; strengths mean the same in both.
"""

from dataclasses import dataclass

import bpy

from blend_assets.formula import Formulas, Value
from blend_assets.inputs import ASSET, Input, Panel, declare

GROUP = "CableTwin sheath"
SOOT = (0.92, 1.0, 1.12)  # dirt swallows blue most
STREAK_LENGTH = 45.0

SHEATH = (
    Panel(
        name="",
        description="",
        inputs=(
            Input(
                name="Colour",
                kind="colour",
                default=(0.3, 0.305, 0.3, 1.0),
                description="Of the clean sheath",
            ),
            Input(
                name="Roughness",
                kind="share",
                default=0.5,
                low=0.0,
                high=1.0,
                description="Of the clean sheath: 0 mirrors, 1 is matt",
            ),
            *(
                Input(name=name, kind="share", default=0.5, low=0.0, high=1.0, description=description)
                for name, description in (
                    ("Grain", "Fine natural mottling of the material itself"),
                    ("Dirt", "Blotches of soot and dust"),
                    ("Streaks", "Marks of running water along the cable"),
                    ("Specks", "Lichen, splashes, grains of dust"),
                    ("Clouds", "Faint clouds, centimetres wide"),
                )
            ),
        ),
    ),
)


@dataclass(frozen=True, kw_only=True)
class Sheath:
    """One material of the library.

    Attributes:
        name: of the material.
        description: for the Asset Browser.
        colour: linear, of the clean sheath.
        roughness: of the clean sheath.
        grain, dirt, streaks, specks, clouds: strengths, 0 to 1.
    """

    name: str
    description: str
    colour: tuple[float, float, float]
    roughness: float
    grain: float
    dirt: float
    streaks: float
    specks: float
    clouds: float


SHEATHS = (
    Sheath(
        name="Black HDPE",
        description="Black polyethylene sheath, lightly used",
        colour=(0.030, 0.031, 0.033),
        roughness=0.42,
        grain=0.5,
        dirt=0.15,
        streaks=0.3,
        specks=0.5,
        clouds=0.4,
    ),
    Sheath(
        name="White HDPE",
        description="White polyethylene sheath, lightly used",
        colour=(0.68, 0.68, 0.66),
        roughness=0.46,
        grain=0.35,
        dirt=0.35,
        streaks=0.4,
        specks=0.45,
        clouds=0.4,
    ),
    Sheath(
        name="Painted sheath",
        description="Grey paint with a soft gloss",
        colour=(0.44, 0.45, 0.42),
        roughness=0.3,
        grain=0.3,
        dirt=0.25,
        streaks=0.3,
        specks=0.35,
        clouds=0.3,
    ),
    Sheath(
        name="Weathered sheath",
        description="Aged grey sheath with soot, water marks and lichen",
        colour=(0.30, 0.305, 0.30),
        roughness=0.62,
        grain=0.7,
        dirt=1.0,
        streaks=1.0,
        specks=0.8,
        clouds=0.8,
    ),
)


def sheath_group() -> bpy.types.ShaderNodeTree:
    """The shader group that all materials share."""
    tree = bpy.data.node_groups.new(GROUP, "ShaderNodeTree")
    tree[ASSET] = "sheath"
    formulas = Formulas(tree)
    tree.interface.new_socket("Surface", in_out="OUTPUT", socket_type="NodeSocketShader")
    inputs = declare(formulas, SHEATH)
    place = formulas.node("ShaderNodeTexCoord").outputs["Object"]
    soot = formulas.clamp(
        _dirt(formulas, place) * inputs["", "Dirt"]
        + 0.8 * _streaks(formulas, place, 1.0) * inputs["", "Streaks"],
        0.0,
        1.5,
    )
    washed = _streaks(formulas, place, 9.0) * inputs["", "Streaks"]
    log_light = (
        0.55 * _noise(formulas, place, 700.0, 4.0) * inputs["", "Grain"]
        + 0.9 * _noise(formulas, place, 25.0, 3.0) * inputs["", "Clouds"]
        + 0.25 * washed
        + 1.4 * _specks(formulas, place) * inputs["", "Specks"]
    )
    colour = _aged(formulas, inputs["", "Colour"], log_light, soot)
    roughness = formulas.clamp(
        inputs["", "Roughness"] + 0.25 * soot + 0.1 * _noise(formulas, place, 120.0, 2.0), 0.05, 1.0
    )
    surface = formulas.node("ShaderNodeBsdfPrincipled")
    formulas.put(surface.inputs["Base Color"], colour)
    formulas.put(surface.inputs["Roughness"], roughness)
    formulas.put(formulas.node("NodeGroupOutput").inputs["Surface"], surface.outputs["BSDF"])
    formulas.tidy()
    return tree


def sheath_material(group: bpy.types.ShaderNodeTree, sheath: Sheath) -> bpy.types.Material:
    """One material: the group with its settings."""
    made = bpy.data.materials.new(sheath.name)
    made.node_tree.nodes.clear()
    formulas = Formulas(made.node_tree)
    node = formulas.node("ShaderNodeGroup", node_tree=group, label="Sheath", name="Sheath")
    node.inputs["Colour"].default_value = (*sheath.colour, 1.0)
    node.inputs["Roughness"].default_value = sheath.roughness
    for name in ("Grain", "Dirt", "Streaks", "Specks", "Clouds"):
        node.inputs[name].default_value = getattr(sheath, name.lower())
    formulas.put(formulas.node("ShaderNodeOutputMaterial").inputs["Surface"], node.outputs["Surface"])
    formulas.tidy()
    made.diffuse_color = (*sheath.colour, 1.0)  # what the solid view shows
    return made


def _noise(formulas: Formulas, place: bpy.types.NodeSocket, per_metre: float, detail: float) -> Value:
    """Noise about 0, within -0.5 and 0.5."""
    made = formulas.node("ShaderNodeTexNoise", noise_dimensions="3D")
    formulas.put(made.inputs["Vector"], place)
    formulas.put(made.inputs["Scale"], per_metre)
    formulas.put(made.inputs["Detail"], detail)
    formulas.put(made.inputs["Roughness"], 0.62)
    return Value(formulas, made.outputs["Factor"]) - 0.5


def _dirt(formulas: Formulas, place: bpy.types.NodeSocket) -> Value:
    """Blotches with ragged edges, 0 to 1."""
    blotch = _noise(formulas, place, 22.0, 7.0) + 0.25 * _noise(formulas, place, 260.0, 3.0)
    return formulas.rise(blotch, 0.02, 0.22, "SMOOTHSTEP")


def _streaks(formulas: Formulas, place: bpy.types.NodeSocket, shift: float) -> Value:
    """Marks of running water, thin across and long along the cable, 0 to 1, in patches."""
    drawn = formulas.node("ShaderNodeVectorMath", operation="MULTIPLY_ADD")
    formulas.put(drawn.inputs[0], place)
    formulas.put(drawn.inputs[1], (1.0, 1.0 / STREAK_LENGTH, 1.0))
    formulas.put(drawn.inputs[2], (shift, shift, shift))
    thin = _noise(formulas, drawn.outputs[0], 170.0, 2.5)
    patchy = formulas.rise(_noise(formulas, place, 18.0 + shift, 2.0), -0.1, 0.12, "SMOOTHSTEP")
    return formulas.rise(thin, 0.05, 0.2, "SMOOTHSTEP") * patchy


def _specks(formulas: Formulas, place: bpy.types.NodeSocket) -> Value:
    """Small spots of two sizes; dark ones are negative, every third one is light."""
    fine, coarse = (_spots(formulas, place, *size) for size in ((330.0, 0.30, 0.5), (90.0, 0.16, 0.35)))
    return fine + coarse


def _spots(
    formulas: Formulas, place: bpy.types.NodeSocket, per_metre: float, radius: float, share: float
) -> Value:
    """Spots of one size: cells to the metre, radius in cells, share of the cells that have one."""
    cells = formulas.node("ShaderNodeTexVoronoi")
    formulas.put(cells.inputs["Vector"], place)
    formulas.put(cells.inputs["Scale"], per_metre)
    distance = Value(formulas, cells.outputs["Distance"])
    chance, kind, _ = formulas.parts(Value(formulas, cells.outputs["Color"]))
    spot = 1.0 - formulas.rise(distance, 0.4 * radius, radius, "SMOOTHSTEP")
    some = formulas.math("LESS_THAN", chance, share)
    light = formulas.math("GREATER_THAN", kind, 0.66)
    return spot * some * (1.6 * light - 0.9)


def _aged(formulas: Formulas, colour: Value, log_light: Value, soot: Value) -> Value:
    """The clean colour, lighter or darker, and swallowed by soot."""
    aged = [
        part * formulas.math("EXPONENT", log_light - 1.1 * tint * soot)
        for part, tint in zip(formulas.parts(colour), SOOT, strict=True)
    ]
    return formulas.vector(*aged)
