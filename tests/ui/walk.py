"""The walk: from an empty scene to a measured cable, by mouse and keyboard, with a picture at each step.

Takes the folder of a rendered survey, one for pictures, and the rooms to walk through (none: all).  With a
finished run in SURVEY/run, "opened" and the rooms behind the reconstruction can be walked alone; "steel"
wants a run of a steel structure in SURVEY/steel, and "segments" one that was cut in SURVEY/run.  Runs inside
Blender.
"""

import os
import sys
import traceback
from pathlib import Path

import bpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import room_board
import room_export
import room_library
import room_measure
import room_mosaic
import room_results
import room_run
import room_steel
import room_survey
from driver import Steps, play
from sidebar import Person

SURVEY, OUT, *ROOMS = sys.argv[sys.argv.index("--") + 1 :]
TYPED = Path(SURVEY) / "typed.toml"

person = Person(OUT)


def walk() -> Steps:
    """The rooms in order."""
    yield from room_survey.empty_scene(person)
    for name in ROOMS or DOORS:
        yield from {**DOORS, **ALONE}[name]()


def survey() -> Steps:
    """A new survey, typed in and saved."""
    yield from room_survey.new_survey(person, Path(SURVEY))
    yield from room_survey.stations(person)
    yield from person.panel("survey")
    yield from room_survey.lens(person)
    yield from person.panel("survey")
    yield from room_survey.save(person, TYPED)
    yield from room_survey.open_again(person, TYPED)
    yield from person.shot("06-opened")
    yield from person.panel("survey")


def rendered() -> Steps:
    """In place of typing it: the survey that lies there."""
    yield from room_survey.open_again(person, Path(SURVEY) / "survey.toml")
    yield from person.panel("survey")


def opened() -> Steps:
    """In place of the rooms before: the survey that lies there, and the run beside it."""
    yield from rendered()
    yield from room_results.reload(person)


def run() -> Steps:
    """The reconstruction, cancelled once."""
    yield from room_run.poses(person)
    yield from room_run.cancel(person)
    yield from room_run.run(person)


def results() -> Steps:
    """What was found."""
    yield from room_results.look(person)


def crop() -> Steps:
    """What a smaller angle would cut away, and another one applied."""
    yield from room_results.preview_a_crop(person)
    yield from room_results.apply_a_crop(person)


def segments() -> Steps:
    """A run of a long survey that lies beside it: one segment after the other."""
    yield from opened()
    yield from room_results.another_segment(person)


def library() -> Steps:
    """A cable dragged out of the Asset Browser, into an empty scene."""
    yield from person.panel("survey")
    yield from room_library.drag_a_cable(person)


def steel() -> Steps:
    """A run of a steel structure that lies beside the survey, in an empty scene."""
    yield from person.panel("survey")
    yield from room_steel.open_run(person, Path(SURVEY) / "steel")
    yield from room_steel.look(person)


DOORS = {
    "survey": survey,
    "run": run,
    "results": results,
    "crop": crop,
    "mosaic": lambda: room_mosaic.pick_pairs(person),
    "measure": lambda: room_measure.measure_a_station(person, Path(SURVEY) / "truth.json"),
    "export": lambda: room_export.export(person, Path(OUT) / "exported"),
    "board": lambda: room_board.read_a_chessboard(person, Path(SURVEY) / "board"),
}
ALONE = {"rendered": rendered, "opened": opened, "segments": segments, "library": library, "steel": steel}


def end(error: BaseException | None) -> None:
    """Leave Blender with what came of it."""
    if error is not None:
        traceback.print_exception(error)
        for _ in person.shot("failed"):
            pass
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(1 if error else 0)


bpy.context.preferences.view.show_splash = False
bpy.context.preferences.view.filebrowser_display_type = "SCREEN"  # no second window, which has no events here
play(walk(), end)
