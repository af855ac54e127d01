"""A reconstruction: its poses shown, started, stopped within two seconds, and run to its end.

Also measured: the longest pause of the interface while it runs and while its results are brought in, and how
much of that is our own code's.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

import bpy
from driver import Steps
from sidebar import Person
from state import job
from stopwatch import Stopwatch

MOST_OWN_S = 0.05
"""Our code may hold the interface no longer than this at a time while a job runs."""
TURN_S = 0.02
"""Pause between two looks at the clock."""
MOST_S = 0.2
"""All of Blender's threads together may work no longer than this on one turn of the event loop."""


def poses(person: Person) -> Steps:
    """The constructed exterior orientation as the cameras' paths."""
    yield from person.panel("pos")
    yield from person.press("cabletwin.pos_show", columns=(0.5,))
    yield 1.5
    yield from person.shot("06-pos")
    yield from person.panel("pos")


def cancel(person: Person) -> Steps:
    """Started by the button, stopped by the button."""
    yield from person.panel("reconstruct")
    yield from person.shot("07-reconstruct")
    yield from person.press("cabletwin.reconstruct_run", columns=(0.5,))
    yield from person.wait_for(lambda: job().stage == "match", 120)
    yield from person.shot("08-running")
    spot = yield from person.find("cabletwin.reconstruct_cancel")
    yield from person.click(*spot)
    pressed = time.monotonic()
    yield from person.wait_for(lambda: not job().running, 10, every=0.05)
    print(f"cancelled {time.monotonic() - pressed:.2f} s after the press")
    assert time.monotonic() - pressed < 2.0
    yield from person.shot("09-cancelled")


def run(person: Person) -> Steps:
    """From where it was stopped to the end."""
    yield from person.press("cabletwin.reconstruct_run", columns=(0.5,))
    yield from person.wait_for(lambda: job().running, 10)
    with Stopwatch() as watch, ViewsDrawn() as views:
        longest = yield from longest_pause(lambda: job().running and job().stage != "show")
    tell("reconstructing", longest, views)
    print(watch.table())
    with Stopwatch() as bringing, ViewsDrawn() as drawn:
        pause = yield from longest_pause(lambda: job().running)
    tell("bringing the results in", pause, drawn)
    print(bringing.table())
    yield from person.wait_for(lambda: not job().running, 120)
    assert not job().failure, job().failure
    assert watch.longest_s < MOST_OWN_S, watch.table()
    assert max(longest.main_s, longest.all_s) < MOST_S, longest
    assert views.count == 0, "nothing but the sidebar shows a progress"
    assert bringing.longest_s < MOST_S, bringing.table()
    assert pause.main_s < MOST_S, pause
    yield from person.panel("reconstruct")


def tell(what: str, longest: "Turn", views: "ViewsDrawn") -> None:
    """What was measured, in a line."""
    print(
        f"{what}: longest pause {longest.clock_s:.3f} s by the clock; busiest turn {longest.main_s:.3f} s of "
        f"the main thread, {longest.all_s:.3f} s of all threads; views drawn {views.count} times"
    )


@dataclass(frozen=True, kw_only=True)
class Turn:
    """One turn of the event loop, or the longest of each kind.

    Attributes:
        clock_s: by the clock, beyond the pause that was asked for.
        main_s: processor time of Blender's main thread, whatever else the machine had to do.
        all_s: the same of all its threads; without a graphics card they draw.
    """

    clock_s: float = 0.0
    main_s: float = 0.0
    all_s: float = 0.0


def longest_pause(running: Callable[[], bool]) -> Steps:
    """The longest time between two turns, each clock for itself; gives a :class:`Turn`."""
    longest, last = (0.0, 0.0, 0.0), clocks()
    while running():
        yield TURN_S
        now = clocks()
        if running():  # what comes after the last turn is not of this
            took = (b - a for a, b in zip(last, now, strict=True))
            longest = tuple(max(*pair) for pair in zip(longest, took, strict=True))
        last = now
    return Turn(clock_s=longest[0] - TURN_S, main_s=longest[1], all_s=longest[2])


def clocks() -> tuple[float, float, float]:
    """Wall, main thread, all threads."""
    return time.monotonic(), time.thread_time(), time.process_time()


class ViewsDrawn:
    """Within ``with``: how often a 3D view was drawn."""

    def __enter__(self) -> "ViewsDrawn":
        self.count = 0
        self._handle = bpy.types.SpaceView3D.draw_handler_add(self._drawn, (), "WINDOW", "POST_PIXEL")
        return self

    def __exit__(self, *_: object) -> None:
        bpy.types.SpaceView3D.draw_handler_remove(self._handle, "WINDOW")

    def _drawn(self) -> None:
        self.count += 1
