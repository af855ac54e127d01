"""What a run left in the scene, compared with its report; and the preview of another crop."""

import json
import math
from pathlib import Path

from driver import Steps
from sidebar import Person
from state import results, state


def reload(person: Person) -> Steps:
    """The run beside an opened survey."""
    yield from person.panel("results")
    yield from person.press("cabletwin.results_open", columns=(0.6, 0.75))
    yield from person.wait_for(lambda: len(results().stations) > 0, 60)
    yield from person.panel("results")


def look(person: Person) -> Steps:
    """What was found lies in the scene, as the report tells it."""
    yield from person.wait_for(lambda: len(results().stations) > 0, 60)
    yield from person.panel("results")
    yield 2.0
    yield from person.shot("10-results")
    report = json.loads((Path(results().folder) / "report.json").read_text(encoding="utf-8"))
    told = [s["diameter_mm"] for s in report["stations"]]
    shown = [s.diameter_mm for s in results().stations]
    assert all(abs(a - b) < 1e-4 for a, b in zip(told, shown, strict=True)), (told, shown)
    yield from person.panel("results")


def preview_a_crop(person: Person) -> Steps:
    """What a smaller angle would cut away, on the blocks themselves."""
    yield from person.panel("crop")
    yield from person.press("cabletwin.crop_preview", columns=(0.5,))
    yield 2.0
    yield from person.fill("crop.incidence", "45")
    assert math.isclose(math.degrees(state().crop.incidence), 45, abs_tol=1e-4)
    yield 2.0
    yield from person.shot("11-crop")
    yield from person.press("cabletwin.crop_reset")
    yield from person.wait_for(lambda: math.degrees(state().crop.incidence) > 46, 5)
    yield from person.until(
        lambda: person.press("cabletwin.crop_preview", columns=(0.5,)), lambda: not state().crop.previewing
    )
    yield from person.panel("crop")
