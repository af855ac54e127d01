"""A picture of each panel with a finished run shown, to be looked at: nothing cut, empty, or in English.

Takes a survey with a finished run in SURVEY/run, and a folder for pictures; the run of a steel structure may
lie in SURVEY/steel.  Runs inside Blender; with :mod:`chinese` applied to the installed extension the pictures
are Chinese.
"""

import os
import sys
import traceback
from pathlib import Path

import bpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from driver import Steps, play
from sidebar import PANELS, Person
from state import state
from stopwatch import module

SURVEY, OUT = (Path(p) for p in sys.argv[sys.argv.index("--") + 1 :][:2])

person = Person(str(OUT))


def pages() -> Steps:
    """Every panel open by itself."""
    yield from person.tab("CableTwin")
    yield from person.shot("page-0-empty")
    with person.override(person.area(), person.region(kind="WINDOW")):
        bpy.ops.cabletwin.survey_open(filepath=str(SURVEY / "survey.toml"))
        bpy.ops.cabletwin.results_open()
        bpy.ops.cabletwin.synthesise_add_cable()
    state().mosaic.way = "BY_HAND"
    yield 1.0
    yield from person.panel(PANELS[0])
    for number, name in enumerate(PANELS, start=1):
        if name == "steel" and (SURVEY / "steel").is_dir():
            with person.override(person.area(), person.region(kind="WINDOW")):
                bpy.ops.cabletwin.steel_choose(directory=str(SURVEY / "steel"))
        yield from person.panel(name)
        yield 0.5
        yield from person.shot(f"page-{number}-{name}")
        yield from person.panel(name)
    running = bpy.context.window_manager.cabletwin_job
    running.running, running.stage, running.block = True, "match", "Block1"
    running.fraction, running.seconds_left, running.kind = 0.4, 75.0, "reconstruct"
    yield from person.panel("reconstruct")
    yield from person.shot("page-running")
    module("operators.following").clear(running)


def end(error: BaseException | None) -> None:
    """Leave Blender with what came of it."""
    if error is not None:
        traceback.print_exception(error)
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(1 if error else 0)


bpy.context.preferences.view.show_splash = False
play(pages(), end)
