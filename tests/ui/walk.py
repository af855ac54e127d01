"""The walk: from an empty scene to a measured cable, by mouse and keyboard, with a picture at each step."""

import json
import os
import sys
import time
import traceback
from pathlib import Path

import bpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from driver import Driver, Steps, play

SURVEY, OUT = (Path(p) for p in sys.argv[sys.argv.index("--") + 1 :])
PANELS = (
    "survey",
    "lens",
    "pos",
    "reconstruct",
    "results",
    "crop",
    "mosaic",
    "measure",
    "export",
    "synthesise",
)

person = Driver(str(OUT))


def walk() -> Steps:
    """All steps in order."""
    yield from empty_scene()
    yield from open_survey()
    yield from cancel_a_run()
    yield from reconstruct()
    yield from look_at_results()


def empty_scene() -> Steps:
    """The tab is there and says how to start."""
    yield from person.sidebar("CableTwin")
    yield from person.shot("01-empty")


def open_survey() -> Steps:
    """Through the file browser, as a person would."""
    yield from person.press("cabletwin.survey_open")
    yield from person.wait_for(lambda: any(a.type == "FILE_BROWSER" for a in person.window.screen.areas))
    browser = person.area("FILE_BROWSER").spaces.active
    yield from person.wait_for(lambda: browser.params is not None)
    browser.params.directory = str(SURVEY).encode()
    browser.params.filename = "survey.toml"
    yield 1.0
    yield from person.shot("02-file-browser")
    region = person.region("FILE_BROWSER", "WINDOW")
    person.move(region.x + region.width / 2, region.y + region.height / 2)
    yield 0.3
    yield from person.key("RET")
    yield from person.wait_for(lambda: len(survey().blocks) == 4)
    yield 1.0
    yield from person.shot("03-survey")


def cancel_a_run() -> Steps:
    """Started by the button, stopped by the button, within two seconds."""
    yield from panel("survey")
    yield from panel("reconstruct")
    yield from person.shot("04-reconstruct")
    yield from person.press("cabletwin.reconstruct_run", columns=(0.5,))
    yield from person.wait_for(lambda: job().stage == "match", 120)
    yield from person.shot("05-running")
    began = time.monotonic()
    yield from person.press("cabletwin.reconstruct_cancel")
    pressed = time.monotonic()
    yield from person.wait_for(lambda: not job().running, 10, every=0.05)
    print(
        f"cancelled {time.monotonic() - pressed:.2f} s after the press ({pressed - began:.2f} s to find it)"
    )
    assert time.monotonic() - pressed < 2.5
    yield from person.shot("06-cancelled")


def reconstruct() -> Steps:
    """From where it was stopped to the end, with the longest pause of the interface measured."""
    yield from person.press("cabletwin.reconstruct_run", columns=(0.5,))
    longest, last = 0.0, time.monotonic()
    yield from person.wait_for(lambda: job().running, 10)
    while job().running and job().stage != "report":
        yield 0.05
        now = time.monotonic()
        longest, last = max(longest, now - last - 0.05), now
    print(f"longest pause of the interface while it ran: {longest:.2f} s")
    yield from person.wait_for(lambda: not job().running, 120)
    assert not job().failure, job().failure


def look_at_results() -> Steps:
    """What was found lies in the scene, as the report tells it."""
    yield from person.wait_for(lambda: len(results().stations) > 0, 60)
    yield from panel("reconstruct")
    yield from panel("results")
    yield 2.0
    yield from person.shot("07-results")
    report = json.loads((Path(results().folder) / "report.json").read_text())
    told = [s["diameter_mm"] for s in report["stations"]]
    shown = [s.diameter_mm for s in results().stations]
    assert all(abs(a - b) < 1e-4 for a, b in zip(told, shown, strict=True)), (told, shown)


def survey() -> bpy.types.PropertyGroup:
    return bpy.context.scene.cabletwin.survey


def results() -> bpy.types.PropertyGroup:
    return bpy.context.scene.cabletwin.results


def job() -> bpy.types.PropertyGroup:
    return bpy.context.window_manager.cabletwin_job


def panel(name: str) -> Steps:
    """Open a closed panel or close an open one; never two open at a time."""
    yield from person.head(PANELS.index(name))


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
