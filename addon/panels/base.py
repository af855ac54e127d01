"""What all panels share: their place in the sidebar, and a few ways to draw."""

from types import ModuleType

import bpy

from ..results.collections import view_layer_collection
from ..sidebar import TAB

LETTER_PX, MARGIN_PX = 6.6, 50
"""Mean width of a letter, and what a box and an icon take of the sidebar, at scale 1."""


class Panel(bpy.types.Panel):
    """A panel in the 3D view's tab *CableTwin*; not registered itself."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = TAB
    bl_options = {"DEFAULT_CLOSED"}


class RowList(bpy.types.UIList):
    """A list that draws each item as one row; not registered itself."""

    def draw_item(
        self,
        context: bpy.types.Context,
        layout: bpy.types.UILayout,
        data: bpy.types.AnyType,
        item: bpy.types.PropertyGroup,
        icon: int,
        active_data: bpy.types.AnyType,
        active_property: str,
        index: int = 0,
        flt_flag: int = 0,
    ) -> None:
        """Blender's own signature."""
        self.draw_row(layout.row(), item)

    def draw_row(self, row: bpy.types.UILayout, item: bpy.types.PropertyGroup) -> None:
        """Draw the item."""
        raise NotImplementedError


def aligned(layout: bpy.types.UILayout) -> bpy.types.UILayout:
    """A column of settings with their names on the left, as in Blender's own panels."""
    column = layout.column()
    column.use_property_split = True
    column.use_property_decorate = False
    return column


def eyes(layout: bpy.types.UILayout, context: bpy.types.Context, room: ModuleType) -> None:
    """One line for each collection that is not empty: its eye and how much is in it.

    Args:
        layout: where to draw.
        context: whose scene and view layer.
        room: ``results.collections`` or ``results.steel_collections``.
    """
    column = layout.column(align=True)
    for kind in room.KINDS:
        found = room.existing(context.scene, kind)
        if found is None or not found.objects:
            continue
        layer = view_layer_collection(context.view_layer, found)
        if layer is None:
            continue
        row = column.row(align=True)
        row.prop(layer, "hide_viewport", text="", emboss=False)
        row.label(text=kind)
        row.label(text=amount(kind, found, room), translate=False)


def amount(kind: str, found: bpy.types.Collection, room: ModuleType) -> str:
    """Points of clouds, else how many things of a kind that is counted."""
    points = sum(item.get("cabletwin_points", 0) for item in found.objects)
    if points:
        return f"{points:,}"
    # a station is a ring with its label
    return str(sum("cabletwin_label" not in item for item in found.objects)) if kind in room.COUNTED else ""


def sentence(layout: bpy.types.UILayout, text: str, icon: str = "NONE") -> None:
    """A sentence over as many lines as it needs."""
    column = layout.column(align=True)
    column.scale_y = 0.8
    scale = bpy.context.preferences.system.ui_scale
    letters = int((bpy.context.region.width / scale - MARGIN_PX) / LETTER_PX)
    for number, line in enumerate(wrapped(text, max(letters, 20))):
        column.label(
            text=line, icon=icon if number == 0 else "BLANK1" if icon != "NONE" else "NONE", translate=False
        )


def wrapped(text: str, width: int) -> list[str]:
    """Lines of at most ``width`` half-width characters; a Chinese one counts as two and may end a line."""
    lines, line, used = [], "", 0
    for word in _pieces(text):
        size = sum(1 + _wide(c) for c in word)
        if line and used + size > width:
            lines.append(line.rstrip())
            line, used = "", 0
            word, size = word.lstrip(), len(word.lstrip())
        line, used = line + word, used + size
    return [*lines, line.rstrip()] if line.strip() else lines


def _pieces(text: str) -> list[str]:
    """Words with the space before them, parts of paths, and single Chinese characters."""
    pieces: list[str] = []
    for char in text:
        last = pieces[-1][-1] if pieces else " "
        if not pieces or char == " " or _wide(char) or _wide(last) or last in "/\\":
            pieces.append(char)
        else:
            pieces[-1] += char
    return pieces


def _wide(char: str) -> bool:
    """Chinese characters and their punctuation."""
    return ord(char) > 0x2E7F
