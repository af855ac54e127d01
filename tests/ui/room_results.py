"""What a run left in the scene, compared with its report; the preview of another crop; a crop applied."""

import json
import math
import tomllib
from pathlib import Path

from driver import Steps
from sidebar import Person
from state import job, results, state, survey

CROP_DEG = 58.0
"""Four cameras still see all of the cable, and less of its limb than with the usual 62."""


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


def another_segment(person: Person) -> Steps:
    """Of a long survey: the first one is shown, then the second at its own place."""
    yield from person.panel("results")
    yield from person.shot("19-segment-1")
    before = results().folder
    yield from person.fill("run.segment", "2", columns=(0.55,))
    yield from person.press("cabletwin.results_open", columns=(0.6, 0.75))
    yield from person.wait_for(lambda: results().folder != before, 60)
    yield 2.0
    yield from person.shot("19-segment-2")
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


def apply_a_crop(person: Person) -> Steps:
    """Another angle written into the survey; what rests on the crop is made again and shown."""
    yield from person.panel("crop")
    yield from person.fill("crop.incidence", f"{CROP_DEG:g}")
    told = Path(results().folder) / "report.json"
    before, made = told.stat().st_mtime_ns, diameters_mm()
    yield from person.press("cabletwin.crop_apply", columns=(0.25,))
    yield from person.wait_for(lambda: job().running, 10)
    yield from person.wait_for(lambda: bool(job().stage) or not job().running, 30)
    yield from person.shot("11-cropping")
    yield from person.wait_for(lambda: not job().running, 240)
    assert not job().failure, job().failure
    written = tomllib.loads(Path(survey().filepath).read_text(encoding="utf-8"))
    assert math.isclose(written["options"]["crop"]["incidence_deg"], CROP_DEG, abs_tol=1e-4), written
    assert told.stat().st_mtime_ns > before
    moved = [abs(a - b) for a, b in zip(diameters_mm(), made, strict=True)]
    assert 0 < max(moved) < 0.05, moved
    yield from person.over(y=0.9)
    yield 2.0
    yield from person.shot("11-cropped")
    yield from person.panel("crop")


def diameters_mm() -> list[float]:
    """Of the stations as they are shown."""
    return [s.diameter_mm for s in results().stations]
