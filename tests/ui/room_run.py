"""A reconstruction: its poses shown, started, stopped within two seconds, and run to its end.

Also measured: the longest pause of the interface while it runs, and how much of that is our own code's.
"""

import time
from collections.abc import Callable

from driver import Steps
from sidebar import Person
from state import job
from stopwatch import Stopwatch

MOST_OWN_S = 0.05
"""Our code may hold the interface no longer than this at a time while a job runs."""


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
    with Stopwatch() as watch:
        longest_s, busy_s = yield from longest_pause(lambda: job().running)
    print(f"longest pause: {longest_s:.3f} s by the clock, {busy_s:.3f} s of the main thread's work")
    print(watch.table())
    yield from person.wait_for(lambda: not job().running, 120)
    assert not job().failure, job().failure
    assert watch.longest_s < MOST_OWN_S, watch.table()
    yield from person.panel("reconstruct")


def longest_pause(running: Callable[[], bool]) -> Steps:
    """The longest time between two turns of the event loop, beyond the pause asked for, by the clock; and the
    most processor time that Blender's main thread spent on one, whatever else the machine had to do."""
    longest_s, busy_s, last, worked = 0.0, 0.0, time.monotonic(), time.thread_time()
    while running():
        yield 0.02
        now, work = time.monotonic(), time.thread_time()
        if running():  # the last turn also brings the results into the scene
            longest_s, busy_s = max(longest_s, now - last - 0.02), max(busy_s, work - worked)
        last, worked = now, work
    return longest_s, busy_s
