"""A click on the cable adds a station; *Measure* gives it its diameter; the deviation in colour."""

import math
from pathlib import Path

from driver import Steps
from room_results import reload
from sidebar import Person
from state import job, results, state, survey

TRUE_MM = (111.4, 110.8, 110.7, 111.1)
"""The paper's diameters, which the survey was rendered with."""
TURNS = 12
"""Of the wheel, from the top of the sidebar to its end."""


def measure_a_station(person: Person, truth: Path) -> Steps:
    """The cable seen from the side, a station added by a click, measured, coloured, compared."""
    yield from reload(person)
    yield from person.panel("measure")
    yield from person.over()
    yield from person.key("NUMPAD_3")
    yield 1.5
    before = len(survey().stations)
    yield from person.press("cabletwin.measure_station_add", columns=(0.2, 0.25))
    view = person.region(kind="WINDOW")
    yield from person.click(view.x + 0.42 * view.width, view.y + 0.5 * view.height)
    yield 0.8
    assert len(survey().stations) == before + 1
    yield from person.shot("14-station-added")
    yield from measure(person)
    assert len(results().stations) == before + 1
    yield from colour(person)
    yield from against_the_truth(person, truth)
    yield from person.panel("measure")


def against_the_truth(person: Person, truth: Path) -> Steps:
    """The closed panel behind *Relief*: a truth typed in, measured again, each difference and their mean."""
    yield from person.open_below("measure.limit_mm", columns=(0.7,), number=1)
    yield from person.over(kind="UI")
    yield from person.wheel(TURNS)
    yield from person.write("run.truth", str(truth), columns=(0.6,))
    assert Path(state().run.truth) == truth, state().run.truth
    yield from person.over(kind="UI")
    yield from person.wheel(-TURNS)
    yield from measure(person)
    known = [s for s in results().stations if s.truth_mm >= 0]
    assert len(known) == len(TRUE_MM), [s.name for s in known]
    off = [abs(s.diameter_mm - mm) for s, mm in zip(known, TRUE_MM, strict=True)]
    assert math.isclose(results().mean_absolute_error_mm, sum(off) / len(off), abs_tol=1e-4)
    assert max(off) < 0.1, off
    yield from person.over(kind="UI")
    yield from person.wheel(TURNS)
    yield from person.over(y=0.9)
    yield 1.0
    yield from person.shot("15-truth")
    yield from person.over(kind="UI")
    yield from person.wheel(-TURNS)


def measure(person: Person) -> Steps:
    """The button, to its end."""
    yield from person.press("cabletwin.measure_run", columns=(0.5,))
    yield from person.wait_for(lambda: job().running, 10)
    yield from person.wait_for(lambda: not job().running, 240)
    assert not job().failure, job().failure


def colour(person: Person) -> Steps:
    """Ctrl and the wheel over the field turn from the picture to the deviation, and back."""
    spot = yield from person.find("measure.colour_by", columns=(0.6,))
    person.move(*spot)
    yield 0.3
    yield from person.wheel(1, ctrl=True)
    yield from person.wait_for(lambda: state().measure.colour_by == "MEAN", 5)
    yield from person.over(y=0.9)  # a tip over the panel would cover it
    yield 2.0
    yield from person.shot("15-measured")
    person.move(*spot)
    yield 0.3
    yield from person.wheel(-1, ctrl=True)
    yield from person.wait_for(lambda: state().measure.colour_by == "TEXTURE", 5)
