"""The walk: from an empty scene to a measured cable, by mouse and keyboard, with a picture at each step."""

import json
import math
import os
import sys
import time
import traceback
from pathlib import Path

import bpy
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Vector

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
    yield from look_at_a_lens()
    yield from show_pos()
    yield from cancel_a_run()
    yield from reconstruct()
    yield from look_at_results()
    yield from preview_a_crop()
    yield from pick_a_mosaic_pair()
    yield from measure_a_station()
    yield from export_the_results()
    yield from synthesise()


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


def look_at_a_lens() -> Steps:
    """Before and after, in a window of its own; here only the panel is pictured."""
    yield from panel("survey")
    yield from panel("lens")
    yield 1.0
    yield from person.shot("04-lens")
    yield from panel("lens")


def show_pos() -> Steps:
    """The constructed exterior orientation as the cameras' paths."""
    yield from panel("pos")
    yield from person.press("cabletwin.pos_show", columns=(0.5,))
    yield 1.5
    yield from person.shot("05-pos")
    yield from panel("pos")


def cancel_a_run() -> Steps:
    """Started by the button, stopped by the button, within two seconds."""
    yield from panel("reconstruct")
    yield from person.shot("06-reconstruct")
    yield from person.press("cabletwin.reconstruct_run", columns=(0.5,))
    yield from person.wait_for(lambda: job().stage == "match", 120)
    yield from person.shot("07-running")
    began = time.monotonic()
    yield from person.press("cabletwin.reconstruct_cancel")
    pressed = time.monotonic()
    yield from person.wait_for(lambda: not job().running, 10, every=0.05)
    print(
        f"cancelled {time.monotonic() - pressed:.2f} s after the press ({pressed - began:.2f} s to find it)"
    )
    assert time.monotonic() - pressed < 2.5
    yield from person.shot("08-cancelled")


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
    yield from person.shot("09-results")
    report = json.loads((Path(results().folder) / "report.json").read_text())
    told = [s["diameter_mm"] for s in report["stations"]]
    shown = [s.diameter_mm for s in results().stations]
    assert all(abs(a - b) < 1e-4 for a, b in zip(told, shown, strict=True)), (told, shown)


def preview_a_crop() -> Steps:
    """What a smaller angle would cut away, on the blocks themselves."""
    yield from panel("results")
    yield from panel("crop")
    yield from person.press("cabletwin.crop_preview", columns=(0.5,))
    yield 2.0
    state().crop.incidence = math.radians(45)
    yield 2.0
    yield from person.shot("10-crop")
    yield from person.press("cabletwin.crop_reset")
    yield 1.0
    yield from panel("crop")


def pick_a_mosaic_pair() -> Steps:
    """A mark on one block, its partner on the next, both by a click on the mesh; then the fit."""
    yield from panel("mosaic")
    state().mosaic.way = "BY_HAND"
    state().mosaic.block_a, state().mosaic.block_b = "Block1", "Block2"
    yield 0.5
    yield from person.press("cabletwin.mosaic_look")
    yield 2.0
    yield from person.press("cabletwin.mosaic_pick")
    yield 1.0
    for y_m in (0.10, 0.20):
        spot = on_screen("Block1", 45.0, y_m)
        yield from person.click(*spot)
        yield 1.5
        yield from person.click(*spot)
        yield 1.5
    assert len(state().mosaic.pairs) == 2, len(state().mosaic.pairs)
    yield from person.shot("11-mosaic-pairs")
    yield from person.key("ESC")
    yield from person.press("cabletwin.mosaic_fit")
    yield 2.0
    yield from person.shot("12-mosaic-fit")
    yield from person.press("cabletwin.mosaic_show_all")
    state().mosaic.way = "AUTOMATIC"
    yield from panel("mosaic")


def measure_a_station() -> Steps:
    """A click on the cable adds a station; *Measure* gives it its diameter."""
    yield from panel("measure")
    with person.override(person.area(), person.region(kind="WINDOW")):
        bpy.ops.cabletwin.results_open()
        bpy.ops.view3d.view_axis(type="RIGHT")
    yield 1.5
    before = len(survey().stations)
    yield from person.press("cabletwin.measure_station_add", columns=(0.2, 0.25))
    view = person.region(kind="WINDOW")
    yield from person.click(view.x + 0.42 * view.width, view.y + 0.5 * view.height)
    yield 0.8
    assert len(survey().stations) == before + 1
    yield from person.shot("13-station-added")
    yield from person.press("cabletwin.measure_run", columns=(0.5,))
    yield from person.wait_for(lambda: job().running, 10)
    yield from person.wait_for(lambda: not job().running, 240)
    assert not job().failure, job().failure
    assert len(results().stations) == before + 1
    state().measure.colour_by = "MEAN"
    yield 2.0
    yield from person.shot("14-measured")
    state().measure.colour_by = "TEXTURE"
    yield from panel("measure")


def export_the_results() -> Steps:
    """Report and tables to a folder of the person's own."""
    yield from panel("export")
    state().export.folder = str(OUT / "exported")
    yield 0.5
    yield from person.press("cabletwin.export_files")
    yield from person.wait_for(lambda: (OUT / "exported" / "report.html").exists(), 20)
    yield from person.shot("15-export")
    yield from panel("export")


def synthesise() -> Steps:
    """A cable and a ring from the library."""
    yield from panel("synthesise")
    yield 0.5
    yield from person.shot("16-synthesise")


def on_screen(block: str, azimuth_deg: float, y_m: float) -> tuple[float, float]:
    """Where a place on a block's surface is seen in the window."""
    item = next(o for o in bpy.data.objects if o.get("cabletwin_block") == block and o.type == "MESH")
    azimuth, radius_m = math.radians(azimuth_deg), 0.0555
    place = Vector((radius_m * math.cos(azimuth), y_m, -radius_m * math.sin(azimuth)))
    view = person.region(kind="WINDOW")
    spot = location_3d_to_region_2d(view, person.area().spaces.active.region_3d, item.matrix_world @ place)
    return view.x + spot.x, view.y + spot.y


def state() -> bpy.types.PropertyGroup:
    return bpy.context.scene.cabletwin


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
