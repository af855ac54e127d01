"""A finished run of a steel structure: opened by its folder, then a row of each table clicked."""

from pathlib import Path

import bpy
from driver import Steps
from sidebar import Person
from state import state

FOLDER, AGAIN, ROW = (0.6,), (0.75,), 0.3
"""Shares of the sidebar's width at which the folder's field, *Reload* and a list's rows lie."""
TURNS = 8
"""Of the wheel, from one table of the panel to the next."""


def open_run(person: Person, folder: Path) -> Steps:
    """Its folder typed in, then *Reload*."""
    yield from person.panel("steel")
    yield from person.shot("20-steel-empty")
    yield from person.write("steel.run_folder", f"{folder}/", columns=FOLDER)
    assert Path(state().steel.run_folder) == folder, state().steel.run_folder
    yield from person.press("cabletwin.steel_open", columns=AGAIN)
    yield from person.wait_for(lambda: len(state().steel.columns) > 0, 60)
    yield 2.0
    yield from person.shot("21-steel")


def look(person: Person) -> Steps:
    """A click on a row turns the view to the column, another to the ball."""
    for index, kind, number in (("column_index", "columns", 1), ("node_index", "nodes", 4)):
        yield from person.until(
            lambda words=(index, number): click_row(person, *words),
            lambda wanted=(index, number): getattr(state().steel, wanted[0]) == wanted[1],
        )
        yield 1.0
        chosen = getattr(state().steel, kind)[number].name
        assert bpy.context.view_layer.objects.active.get("cabletwin_name") == chosen, chosen
        yield from person.over(y=0.9)
        yield 1.0
        yield from person.shot(f"22-steel-{kind}")
        yield from person.over(kind="UI")
        yield from person.wheel(TURNS)
    yield from person.over(kind="UI")
    yield from person.wheel(-2 * TURNS)
    yield from person.panel("steel")


def click_row(person: Person, index: str, number: int) -> Steps:
    """The row of that number in a list."""
    spot = yield from person.row(index, number, ROW)
    yield from person.click(*spot)
