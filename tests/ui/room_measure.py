"""A click on the cable adds a station; *Measure* gives it its diameter; the deviation in colour."""

from driver import Steps
from room_results import reload
from sidebar import Person
from state import job, results, state, survey


def measure_a_station(person: Person) -> Steps:
    """The cable seen from the side, a station added by a click, measured, coloured."""
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
    yield from person.press("cabletwin.measure_run", columns=(0.5,))
    yield from person.wait_for(lambda: job().running, 10)
    yield from person.wait_for(lambda: not job().running, 240)
    assert not job().failure, job().failure
    assert len(results().stations) == before + 1
    yield from colour(person)
    yield from person.panel("measure")


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
