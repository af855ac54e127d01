"""The asset library: told to Blender, shown in the Asset Browser, its cable dragged into the scene."""

import bpy
from driver import Steps
from sidebar import Person
from stopwatch import module

ASSET = "Cable"
TIMELINE, BROWSER = "DOPESHEET_EDITOR", "FILE_BROWSER"
RAISED_PX, TILE_PX, LINE_PX = 320, 40, 20
"""How far the timeline's upper edge is drawn up; half a picture's size; a line of the tree."""
DROP = (0.3, 0.35)
"""Where the cable is dropped: shares of the 3D view's width and height, on the floor."""


def drag_a_cable(person: Person) -> Steps:
    """From the button *Add Asset Library* to a cable that the panel knows."""
    yield from person.panel("synthesise")
    yield from person.press("cabletwin.synthesise_add_library")
    yield from person.until(lambda: next_editor(person), lambda: is_browser(person))
    yield from raise_edge(person)
    tile = yield from find_asset(person, ASSET)
    yield from person.shot("30-library")
    view = person.region(kind="WINDOW")
    drop = (view.x + DROP[0] * view.width, view.y + DROP[1] * view.height)
    yield from person.drag(tile, drop)
    yield from person.wait_for(lambda: bpy.data.objects.get(ASSET) is not None, 10)
    yield 2.0
    made = bpy.data.objects[ASSET]
    assert made.library is None, made.library
    assert module("synthetic_cable").scene_cable(bpy.context.scene) == made
    yield from person.shot("31-library-cable")


def next_editor(person: Person) -> Steps:
    """Shift F1 over the timeline: file browser, then asset browser."""
    yield from person.over(BROWSER if person.has_area(BROWSER) else TIMELINE, "HEADER", x=0.6)
    yield from person.key("F1", shift=True)
    yield 1.0


def is_browser(person: Person) -> bool:
    """Whether it is the asset browser by now."""
    return person.has_area(BROWSER) and person.area(BROWSER).ui_type == "ASSETS"


def raise_edge(person: Person) -> Steps:
    """The border above the browser drawn up, so that the assets are seen."""
    area = person.area(BROWSER)
    x, y = area.x + 0.5 * area.width, area.y + area.height
    yield from person.drag((x, y), (x, y + RAISED_PX))
    assert person.area(BROWSER).height > RAISED_PX, person.area(BROWSER).height
    yield 2.0


def find_asset(person: Person, name: str) -> Steps:
    """Down the tree of catalogs, until a click on the first picture beside it has chosen it; gives where."""
    tree, pictures = person.region(BROWSER, "TOOLS"), person.region(BROWSER, "WINDOW")
    first = pictures.x + TILE_PX, pictures.y + pictures.height - 2 * TILE_PX
    for y in range(tree.y + tree.height - 3 * LINE_PX, tree.y, -LINE_PX):
        yield from person.click(tree.x + 0.35 * tree.width, y)
        yield 0.8
        yield from person.click(*first)
        with person.override(person.area(BROWSER), pictures):
            found = bpy.context.asset
        if found is not None and found.name == name:
            return first
    raise LookupError(f"no asset {name!r} in the browser")
