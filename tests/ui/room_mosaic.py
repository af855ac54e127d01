"""A mark on one block, its partner on the next, both by a click on the mesh; the fit; the ring closed."""

import math

import bpy
from bpy_extras.view3d_utils import location_3d_to_region_2d
from driver import Steps
from mathutils import Vector
from sidebar import Person
from state import state

LEFT, RIGHT = (0.28,), (0.62,)
"""Shares of the sidebar's width at which the two halves of a row lie."""
MARKS_M = (0.10, 0.20)
"""Positions along the cable of the marks that are picked."""
SEAMS = 4


def pick_pairs(person: Person) -> Steps:
    """Two pairs on Block1 and Block2, which are chosen by name."""
    yield from person.panel("mosaic")
    yield from person.until(
        lambda: person.press("mosaic.way", columns=RIGHT), lambda: state().mosaic.way == "BY_HAND"
    )
    for key, name, column in (("block_a", "Block1", LEFT), ("block_b", "Block2", RIGHT)):
        yield from person.until(
            lambda words=(f"mosaic.{key}", name, column): person.search(*words),
            lambda wanted=(key, name): getattr(state().mosaic, wanted[0]) == wanted[1],
        )
    yield from person.press("cabletwin.mosaic_look")
    yield 2.0
    yield from person.press("cabletwin.mosaic_pick")
    yield 1.0
    for y_m in MARKS_M:
        spot = on_screen(person, "Block1", 45.0, y_m)
        for _ in range(2):  # the mark on the one block, then through it on the other
            yield from person.click(*spot)
            yield 1.5
    pairs = state().mosaic.pairs
    assert len(pairs) == 2, len(pairs)
    assert all(abs(pair.point_a[1] - y_m) < 0.002 for pair, y_m in zip(pairs, MARKS_M, strict=True))
    yield from person.shot("12-mosaic-pairs")
    yield from person.key("ESC")
    yield from person.press("cabletwin.mosaic_fit")
    yield 2.0
    assert max(p.residual_mm for p in state().mosaic.pairs) < 0.3
    yield from person.shot("13-mosaic-fit")
    yield from person.press("cabletwin.mosaic_show_all")
    yield from close_the_ring(person)
    yield from person.until(
        lambda: person.press("mosaic.way", columns=LEFT), lambda: state().mosaic.way == "AUTOMATIC"
    )
    yield from person.panel("mosaic")


def close_the_ring(person: Person) -> Steps:
    """The three other seams get a pair each that was found, and all four are fitted at once."""
    yield from person.press("cabletwin.mosaic_close", columns=(0.75,))
    yield from person.wait_for(lambda: len(state().mosaic.joins) == SEAMS, 30)
    mosaic = state().mosaic
    assert [p.found for p in mosaic.pairs] == [False] * len(MARKS_M) + [True] * (len(mosaic.pairs) - 2)
    assert {frozenset((p.block_a, p.block_b)) for p in mosaic.pairs} == {
        frozenset((j.block_a, j.block_b)) for j in mosaic.joins
    }
    assert max(p.residual_mm for p in mosaic.pairs) < 0.3, [p.residual_mm for p in mosaic.pairs]
    yield from person.over(y=0.9)
    yield 1.0
    yield from person.shot("13-mosaic-closed")


def on_screen(person: Person, block: str, azimuth_deg: float, y_m: float) -> tuple[float, float]:
    """Where a place on a block's surface is seen in the window."""
    item = next(
        o for o in bpy.data.objects if o.get("cabletwin_block") == block and "cabletwin_pair" not in o
    )
    azimuth, radius_m = math.radians(azimuth_deg), 0.0555
    place = Vector((radius_m * math.cos(azimuth), y_m, -radius_m * math.sin(azimuth)))
    view = person.region(kind="WINDOW")
    turned = person.area().spaces.active.region_3d
    spot = location_3d_to_region_2d(view, turned, item.matrix_world @ place)
    return view.x + spot.x, view.y + spot.y
