"""What a run that could be worked with, but looks wrong, tells the person: on its way and in the report."""

import json

import cv2
import pytest

from tests.bad_input import cylinder
from tests.command import pipeline

NUMBERS = (1, 2, 3, 5, 6)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A whole run of two folders of pictures of which number 4 is missing: command, survey, run folder."""
    folder = tmp_path_factory.mktemp("gap")
    for block, azimuth_deg in (("block1", 0.0), ("block2", 90.0)):
        (folder / block).mkdir()
        for number, picture in zip(NUMBERS, cylinder.views(azimuth_deg), strict=True):
            cv2.imwrite(str(folder / block / f"{number:03d}.png"), picture)
    (folder / "survey.toml").write_text(cylinder.SURVEY.replace(".mp4", ""))
    done = pipeline("run", folder / "survey.toml", "--out", folder / "run")
    assert done.code == 0, done.stderr
    return done, folder / "survey.toml", folder / "run"


def test_the_note_stands_behind_its_stage_in_the_progress(run):
    lines = run[0].stderr.splitlines()
    notes = [
        k for k, line in enumerate(lines) if line.startswith("note: The pictures of Block1, Block2 skip")
    ]
    assert len(notes) == 1
    assert lines[notes[0] - 1].startswith("frames ")


def test_the_report_begins_with_it(run):
    warnings = json.loads((run[2] / "report.json").read_text())["warnings"]
    assert warnings[0].startswith(
        "The pictures of Block1, Block2 skip numbers (in Block1, 005.png comes next"
    )
    assert warnings[0] in (run[2] / "report.html").read_text()


def test_a_run_that_finds_its_stages_finished_tells_it_again(run):
    again = pipeline("run", run[1], "--out", run[2], "--events", "json")
    told = [event["stage"] for event in again.events if "skip numbers" in event["message"]]
    assert told == ["frames"]


def test_a_stage_that_this_run_does_not_need_is_refused_by_name(run):
    done = pipeline(
        "run", run[1], "--out", run[2], "--only", "joint", "--adjust", "blocks", "--events", "none"
    )
    assert (done.code, done.stdout) == (2, "")
    assert done.stderr.startswith("error: run: the stage joint has no part in this run")
