"""What is written over the 3D views: the stations' figures, the numbers of the pairs, and the legend of the
surface's colours.

Batches are made once; drawing sets them into place and writes the numbers.  Leaves out Blender without a
window.
"""

import math
from collections.abc import Iterator
from functools import cache
from typing import Any, NamedTuple

import blf
import bpy
import gpu
from bpy.app.translations import pgettext_iface as translated
from bpy.app.translations import pgettext_n as n_
from bpy_extras.view3d_utils import location_3d_to_region_2d
from gpu_extras.batch import batch_for_shader
from mathutils import Matrix, Vector

from .results.clouds import GAMMA
from .results.collections import PAIRS, STATIONS, existing
from .results.marks import LABEL

TITLES = {
    "MEAN": n_("Deviation from mean"),
    "NOMINAL": n_("Deviation from nominal"),
    "BASE": n_("Relief"),
}
STEPS = 64
BAR_PX, MARGIN_PX = (16, 180), (30, 60)
FONT_PX, LINE_PX, PAD_PX, GAP_PX, DOT_PX = 12, 20, 6, 2, 9
WHITE, BACK, PROVISIONAL = (1.0, 1.0, 1.0, 1.0), (0.06, 0.06, 0.06, 0.85), (0.6, 0.85, 1.0, 1.0)

_handle: list[Any] = []

type Box = tuple[float, float, float, float]
"""Left, low, width, height, in pixels."""
type Colour = tuple[float, ...]
"""Red, green, blue, opacity, 0 to 1, as the screen has them."""


def ticks(limit_mm: float) -> tuple[tuple[float, str], ...]:
    """Places on the bar, 0 at its foot to 1 at its head, and what stands there."""
    digits = 2 if limit_mm >= 0.1 else 3
    places = (-1.0, -0.5, 0.0, 0.5, 1.0)
    return tuple((p / 2 + 0.5, f"{p * limit_mm:+.{digits}f}".replace("-", "−") if p else "0") for p in places)


def title(scene: bpy.types.Scene) -> str:
    """What the colours show, with its unit."""
    measure = scene.cabletwin.measure
    text = translated(TITLES[measure.colour_by])
    diameter_mm = {
        "MEAN": measure.mean_diameter_mm,
        "NOMINAL": 1000 * scene.cabletwin.survey.diameter,
    }.get(measure.colour_by)
    return f"{text} (mm)" if diameter_mm is None else f"{text} ⌀ {diameter_mm:.2f} (mm)"


def apart(boxes: list[Box]) -> list[Box]:
    """The boxes raised one after the other, from the left, until none lies over another; order is kept."""
    placed: dict[int, Box] = {}
    for index in sorted(range(len(boxes)), key=lambda k: boxes[k][0]):
        box = boxes[index]
        while tops := [other[1] + other[3] for other in placed.values() if _over(box, other)]:
            box = (box[0], max(tops) + GAP_PX, *box[2:])
        placed[index] = box
    return [placed[index] for index in range(len(boxes))]


def _over(one: Box, other: Box) -> bool:
    return all(
        one[k] < other[k] + other[k + 2] + GAP_PX / 2 and other[k] < one[k] + one[k + 2] + GAP_PX / 2
        for k in (0, 1)
    )


def _draw() -> None:
    context = bpy.context
    if not context.space_data.overlay.show_overlays:
        return
    scale = context.preferences.system.ui_scale
    blf.size(0, FONT_PX * scale)
    gpu.state.blend_set("ALPHA")
    _labels(context, scale)
    if context.scene.cabletwin.measure.colour_by != "TEXTURE":
        _legend(context, scale)
    gpu.state.blend_set("NONE")


class Label(NamedTuple):
    """What is written at a place in the view; ``dot`` marks the place itself, where it has a colour."""

    x: float
    y: float
    text: str
    colour: Colour
    dot: Colour | None


def _labels(context: bpy.types.Context, scale: float) -> None:
    """The figures of the stations and the numbers of the pairs, as far as they are shown."""
    pad, found = PAD_PX * scale, [*_stations(context), *_marks(context)]
    free = context.region.width - _covered(context.area, "UI")
    boxes = []
    for label in found:
        left = label.x if label.dot is None else label.x + DOT_PX * scale
        width = blf.dimensions(0, label.text)[0] + 2 * pad
        boxes.append((beside_sidebar(left, width, free), label.y, width, LINE_PX * scale))
        if label.dot is not None:
            _draw_in(_disc(), (label.x, label.y, DOT_PX * scale, DOT_PX * scale), label.dot)
    for box, label in zip(apart(boxes), found, strict=True):
        _draw_in(_square(), box, BACK)
        _write(label.text, box[0] + pad, box[1] + pad, label.colour)


def _stations(context: bpy.types.Context) -> Iterator[Label]:
    for item, x, y in _seen(context, STATIONS):
        colour = PROVISIONAL if item.get("cabletwin_provisional") else WHITE
        yield Label(x, y, item[LABEL], colour, None)


def _marks(context: bpy.types.Context) -> Iterator[Label]:
    """Those on the side of the cable that one looks at."""
    view = context.region_data
    for item, x, y in _seen(context, PAIRS):
        if is_in_front(item.matrix_world.translation, view.view_matrix, perspective=view.is_perspective):
            shade = tuple(part ** (1 / GAMMA) for part in item.data.materials[0].diffuse_color)
            yield Label(x, y, item[LABEL], WHITE, shade)


def _seen(context: bpy.types.Context, kind: str) -> Iterator[tuple[bpy.types.Object, float, float]]:
    """Objects with a label that are not hidden, and where their origins are seen."""
    found = existing(context.scene, kind)
    for item in found.objects if found else ():
        if LABEL not in item or not item.visible_get(view_layer=context.view_layer):
            continue
        place = location_3d_to_region_2d(context.region, context.region_data, item.matrix_world.translation)
        if place is not None:
            yield item, place.x, place.y


def is_in_front(place: Vector, view_from_world: Matrix, *, perspective: bool) -> bool:
    """Whether a place on the cable, whose axis is y, lies on the side that is turned to the eye."""
    world_from_view = view_from_world.inverted()
    towards = world_from_view.translation - place if perspective else world_from_view.col[2].to_3d()
    return Vector((place.x, 0.0, place.z)).dot(towards) > 0


def _legend(context: bpy.types.Context, scale: float) -> None:
    scene, pad = context.scene, PAD_PX * scale
    left, low = MARGIN_PX[0] * scale + _covered(context.area, "TOOLS"), MARGIN_PX[1] * scale
    width, height = (scale * b for b in BAR_PX)
    line, heading = LINE_PX * scale, title(scene)
    wide = max(blf.dimensions(0, heading)[0], width + 4 * line)
    behind = (left - pad, low - line / 2 - pad, wide + 2 * pad, height + 2.2 * line + 2 * pad)
    _draw_in(_square(), behind, BACK)
    with gpu.matrix.push_pop():
        gpu.matrix.translate((left, low))
        gpu.matrix.scale((width, height))
        shader, batch = _bar()
        batch.draw(shader)
    for share, text in ticks(scene.cabletwin.measure.limit_mm):
        _write(text, left + width + 8 * scale, low + share * height - 4 * scale, WHITE)
    _write(heading, left, low + height + line, WHITE)


def _write(text: str, x: float, y: float, colour: Colour) -> None:
    blf.color(0, *colour)
    blf.position(0, x, y, 0)
    blf.draw(0, text)


def _draw_in(shape: tuple[Any, Any], box: Box, colour: Colour) -> None:
    """A shape of width and height 1 in a place of its own."""
    shader, batch = shape
    with gpu.matrix.push_pop():
        gpu.matrix.translate(box[:2])
        gpu.matrix.scale(box[2:])
        shader.uniform_float("color", colour)
        batch.draw(shader)


def _covered(area: bpy.types.Area, kind: str) -> float:
    """Width of the toolbar or sidebar (``TOOLS``, ``UI``) that lies over the view's edge."""
    return max((r.width for r in area.regions if r.type == kind and r.width > 1), default=0)


def beside_sidebar(left: float, width: float, free: float) -> float:
    """A label of something that is seen moves out from under the sidebar."""
    return min(left, free - width) if left < free else left


@cache
def _square() -> tuple[Any, Any]:
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    return shader, batch_for_shader(shader, "TRI_STRIP", {"pos": [(0, 0), (1, 0), (0, 1), (1, 1)]})


@cache
def _disc() -> tuple[Any, Any]:
    """About its middle."""
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    turn = [2 * math.pi * k / STEPS for k in range(STEPS + 1)]
    around = [(math.cos(t) / 2, math.sin(t) / 2) for t in turn]
    return shader, batch_for_shader(shader, "TRI_FAN", {"pos": [(0.0, 0.0), *around]})


@cache
def _bar() -> tuple[Any, Any]:
    """Shader and batch of the bar, of width and height 1."""
    import numpy as np

    from pipeline.report.deviation import diverging_colours

    heights = np.linspace(0, 1, STEPS + 1)
    colours = diverging_colours(2 * heights - 1, 1.0) / 255.0
    places = [(float(x), float(y)) for y in heights for x in (0, 1)]
    paint = [(*map(float, c), 1.0) for c in colours for _ in (0, 1)]
    shader = gpu.shader.from_builtin("SMOOTH_COLOR")
    return shader, batch_for_shader(shader, "TRI_STRIP", {"pos": places, "color": paint})


def register() -> None:
    """Draw from now on."""
    if not bpy.app.background:
        _handle.append(bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_PIXEL"))


def unregister() -> None:
    """Draw no more."""
    while _handle:
        bpy.types.SpaceView3D.draw_handler_remove(_handle.pop(), "WINDOW")
    for made in (_square, _disc, _bar):
        made.cache_clear()
