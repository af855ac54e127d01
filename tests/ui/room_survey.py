"""From an empty scene to a survey on disk: new, cameras, videos, angles, lens, saved; and opened again."""

import math
from pathlib import Path

import bpy
from driver import Steps
from sidebar import Person
from state import survey

VIDEOS = ("block1.mp4", "block2.mp4", "block3.mp4", "block4.mp4")
NAMES = "ABCD"
STATIONS_M = (0.06, 0.12, 0.18, 0.24)
FIRST, SECOND = 0.2, (0.57,)
"""Shares of the sidebar's width at which a list's columns lie."""
BUTTONS = (0.83,)
"""The same of the small buttons beside a list or at the end of a field."""


def empty_scene(person: Person) -> Steps:
    """The tab is there and says how to start."""
    yield from person.tab("CableTwin")
    yield from person.shot("01-empty")


def new_survey(person: Person, folder: Path) -> Steps:
    """All that survey.toml says, typed in; the videos are picked in the file browser."""
    yield from person.press("cabletwin.survey_new")
    yield 0.8
    yield from person.shot("02-new")
    yield from person.key("RET")
    yield from person.wait_for(lambda: len(survey().blocks) == 4)
    for key, text in (
        ("survey.name", "paper"),
        ("survey.travel", "0.3"),
        ("survey.travel_sigma_mm", "0.005"),
        ("survey.diameter", "0.111"),
        ("survey.standoff", "0.3"),
    ):
        yield from person.fill(key, text)
    yield from a_camera_more_and_less(person)
    for number, video in enumerate(VIDEOS):
        yield from camera(person, number, folder / video)
    yield from person.shot("03-survey")


def a_camera_more_and_less(person: Person) -> Steps:
    """The last camera taken out of the ring and put in again."""
    yield from choose(person, 3)
    yield from person.press("cabletwin.survey_block_remove", columns=BUTTONS)
    yield from person.wait_for(lambda: len(survey().blocks) == 3)
    yield from person.press("cabletwin.survey_block_add", columns=BUTTONS)
    yield from person.wait_for(lambda: len(survey().blocks) == 4)


def choose(person: Person, number: int) -> Steps:
    """A click on its row."""

    def once() -> Steps:
        spot = yield from person.row("block_index", number, FIRST)
        yield from person.click(*spot)

    yield from person.until(once, lambda: survey().block_index == number)


def camera(person: Person, number: int, video: Path) -> Steps:
    """Its video, its angle and the direction of travel in its picture."""
    yield from choose(person, number)
    block = survey().blocks[number]
    yield from person.until(
        lambda: person.press("buttons.file_browse", columns=BUTTONS), lambda: person.has_area("FILE_BROWSER")
    )
    yield from person.choose_file(video, "02-file-browser" if number == 0 else "")
    yield from person.wait_for(lambda: Path(survey().blocks[number].source) == video, 5)
    yield from person.fill(f"blocks[{number}].angle", str(90 * number), columns=SECOND)
    for letter, value in (("L", "left"), ("R", "right")):
        yield from person.until(
            lambda key=letter: direction(person, number, key),
            lambda v=value: survey().blocks[number].travel_in_image == v,
        )
    assert math.isclose(math.degrees(block.angle), 90 * number, abs_tol=1e-4), math.degrees(block.angle)


def direction(person: Person, number: int, letter: str) -> Steps:
    """From the menu, by the letter that it underlines."""
    yield from person.press(f"blocks[{number}].travel_in_image", columns=(0.7,))
    yield 0.6
    yield from person.key(letter)


def lens(person: Person) -> Steps:
    """Focal length and lambda of one camera, trusted, given to all."""
    yield from person.panel("lens")
    yield from person.fill("focal_px", "480")
    yield from person.fill("division_lambda", "-0.02")
    for box in ("lambda_known", "calibrated"):
        yield from person.until(
            lambda what=box: person.press(what, columns=(0.6, 0.5)),
            lambda what=box: bool(getattr(survey().block(), what)),
        )
    yield from person.until(
        lambda: person.press("cabletwin.survey_lens_to_all", columns=(0.5,)),
        lambda: all(b.calibrated and b.lambda_known for b in survey().blocks),
    )
    assert {round(b.focal_px) for b in survey().blocks} == {480}
    assert {round(b.division_lambda, 6) for b in survey().blocks} == {-0.02}
    yield from person.shot("04-lens")
    yield from preview(person)
    yield from person.panel("lens")


def preview(person: Person) -> Steps:
    """A frame before and after the correction, in a window of its own."""
    yield from person.press("cabletwin.lens_show", columns=(0.5,))
    yield from person.wait_for(lambda: len(bpy.context.window_manager.windows) == 2)
    yield 3.0
    yield from person.shot("05-lens-preview")
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[-1]):
        bpy.ops.wm.window_close()  # a virtual screen has no window manager, so no cross to click on
    yield 1.0


def stations(person: Person) -> Steps:
    """Four places where the diameter is wanted; their panel lies closed below the cameras."""
    yield from person.open_below("ordered", columns=(0.7, 0.5))
    for number, position_m in enumerate(STATIONS_M):
        yield from person.until(
            lambda: person.press("cabletwin.survey_station_add", columns=BUTTONS),
            lambda n=number: len(survey().stations) == n + 1,
        )
        yield from person.until(
            lambda n=number: name_station(person, n), lambda n=number: survey().stations[n].name == NAMES[n]
        )
        yield from person.fill(f"stations[{number}].position", str(position_m), columns=SECOND)
    found = [s.position for s in survey().stations]
    assert all(math.isclose(a, b, abs_tol=1e-6) for a, b in zip(found, STATIONS_M, strict=True)), found


def name_station(person: Person, number: int) -> Steps:
    """Ctrl and a click on its row make the name a field."""
    spot = yield from person.row("station_index", number, FIRST)
    yield from person.click(*spot, ctrl=True)
    yield 0.5
    yield from person.key("A", ctrl=True)
    yield from person.retype(NAMES[number])


def save(person: Person, path: Path) -> Steps:
    """Where no file is known yet, it is asked for."""
    yield from person.press("cabletwin.survey_save")
    yield from person.choose_folder(path.parent, confirm=False)
    yield from person.type_file_name(path.name)
    yield from person.wait_for(path.is_file, 10)


def open_again(person: Person, path: Path) -> Steps:
    """Through the file browser; what was typed before is what is read."""
    before = survey().written
    yield from person.press("cabletwin.survey_open")
    yield from person.choose_file(path)
    yield from person.wait_for(lambda: len(survey().blocks) == 4)
    assert before in ("", survey().written)
    yield 1.0
