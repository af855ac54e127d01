"""What an opened run costs at each redraw, beside an empty scene and the same things laid out plainly.

Takes a survey with a finished run in SURVEY/run, and a folder for redraw.json.  A cloud of 2 million points
made by the extension stands in for the run's own.  Each scene is drawn several times, whole window, the same
view and shading; the cheapest one counts.  Runs inside Blender.
"""

import json
import os
import sys
import time
import traceback
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from driver import Driver, Steps, play
from stopwatch import Stopwatch, module

SURVEY, OUT = (Path(p) for p in sys.argv[sys.argv.index("--") + 1 :][:2])
POINTS, TIMES = 2_000_000, 7
SLACK = 0.2
"""An opened run may cost so much more than the same data without us."""

PLAIN = {"opened run": "plain mesh", "opened run, 2 million points shown": "plain cloud"}

person = Driver(str(OUT))


def measure() -> Steps:
    """All scenes; figures in milliseconds."""
    scene = bpy.context.scene
    person.area().spaces.active.show_region_ui = True
    yield 1.0
    bpy.ops.cabletwin.survey_open(filepath=str(SURVEY / "survey.toml"))
    yield from opening()
    collections = module("results.collections")
    own = {
        kind: list(collections.existing(scene, kind).objects)
        for kind in collections.KINDS
        if _has(scene, kind)
    }
    many = _cloud()
    collections.existing(scene, collections.DENSE).objects.link(many)
    for item in own[collections.DENSE]:
        item.hide_viewport = True
    yield 1.0
    found = {}
    with Stopwatch() as watch:
        found["opened run"] = yield from redraw()
    print(watch.table())
    yield from person.shot("redraw-opened")
    _show(scene, dense=True)
    found["opened run, 2 million points shown"] = yield from redraw()
    yield from person.shot("redraw-cloud")
    for name, items in (
        ("empty scene", []),
        ("plain mesh", own[collections.MOSAIC]),
        ("plain cloud", [many]),
    ):
        with PlainScene(items):
            yield 1.0
            found[name] = yield from redraw()
            yield from person.shot(f"redraw-{name.replace(' ', '-')}")
    judge(found)


def opening() -> Steps:
    """The run brought in and drawn for the first time; processor seconds of all threads, and by the clock."""
    began, clock = time.process_time(), time.monotonic()
    with person.override(person.area(), person.region(kind="WINDOW")):
        bpy.ops.cabletwin.results_open()
        bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=1)
    cpu_s, wall_s = time.process_time() - began, time.monotonic() - clock
    print(f"opened and drawn: {cpu_s:.2f} s of processor, {wall_s:.2f} s by the clock")
    yield 0.5


def redraw() -> Steps:
    """The cheapest of some redraws of the whole window: processor time of all threads, milliseconds.

    On a machine without a graphics card Blender's own threads draw, and what else runs there does not count.
    """
    with person.override(person.area(), person.region(kind="WINDOW")):
        bpy.ops.wm.redraw_timer(type="DRAW_WIN", iterations=1)  # what is built once does not count
    took = []
    for _ in range(TIMES):
        yield 0.05
        began = time.process_time()
        with person.override(person.area(), person.region(kind="WINDOW")):
            bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=1)
        took.append(1000 * (time.process_time() - began))
    return round(min(took), 1)


class PlainScene:
    """Within ``with``: the window shows a scene of plain objects with the same data."""

    def __init__(self, items: list[bpy.types.Object]) -> None:
        self._items = items

    def __enter__(self) -> None:
        self._before = person.window.scene
        self._scene = bpy.data.scenes.new("Plain")
        for item in self._items:
            made = bpy.data.objects.new(item.name, item.data)
            made.matrix_world = item.matrix_world
            self._scene.collection.objects.link(made)
        person.window.scene = self._scene

    def __exit__(self, *_: object) -> None:
        person.window.scene = self._before
        bpy.data.scenes.remove(self._scene)


def judge(found: dict[str, float]) -> None:
    """Write the figures, and compare what our scenes cost with what the same data cost plainly."""
    (OUT / "redraw.json").write_text(json.dumps(found, indent=2), encoding="utf-8")
    for name, ms in found.items():
        print(f"  {name:40} {ms:8.1f} ms")
    for ours, plain in PLAIN.items():
        allowed = max(found[plain], found["empty scene"])
        print(f"  {ours}: {100 * (found[ours] / allowed - 1):+.0f} % beside {plain}")
        assert found[ours] <= (1 + SLACK) * allowed, (ours, found)


def _has(scene: bpy.types.Scene, kind: str) -> bool:
    return module("results.collections").existing(scene, kind) is not None


def _cloud() -> bpy.types.Object:
    """Points on a cable, as the extension makes its clouds."""
    chance = np.random.default_rng(1)
    turn, along = chance.uniform(0, 2 * np.pi, POINTS), chance.uniform(0, 0.3, POINTS)
    points = np.stack([0.0555 * np.cos(turn), along, 0.0555 * np.sin(turn)], axis=1)
    colours = chance.integers(0, 255, (POINTS, 3), dtype=np.uint8)
    return module("results.clouds").cloud_object("Many points", points, colours, 0.00025, POINTS)


def _show(scene: bpy.types.Scene, *, dense: bool) -> None:
    collections = module("results.collections")
    collections.set_hidden(scene, collections.DENSE, not dense)
    collections.set_hidden(scene, collections.MOSAIC, dense)


def end(error: BaseException | None) -> None:
    """Leave Blender with what came of it."""
    if error is not None:
        traceback.print_exception(error)
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(1 if error else 0)


bpy.context.preferences.view.show_splash = False
play(measure(), end)
