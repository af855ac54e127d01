"""A block's lambda from its own video, before any run: drawn pictures of a cable through a known lens."""

import json

import cv2
import pytest

from pipeline.cable.frames import FrameOptions
from pipeline.cable.lens import LensMethod, LensOptions
from pipeline.cable.lens_estimate import estimate_lens
from pipeline.cable.survey import read_survey
from pipeline.core.errors import StageError
from tests.cable.outline_pictures import picture_of_cable
from tests.cable.test_lens import TOUCH, bent
from tests.command import pipeline

SURVEY = """
format = 1
name = "drawn"
[cable]
travel_m = 0.12
diameter_mm = 110.0
[robot]
standoff_m = 0.30
synchronised = true
[[block]]
name = "Block1"
source = "one"
angle_deg = 0.0
travel_in_image = "right"
[block.lens]
focal_px = 720.0
division_lambda = -0.1
calibrated = true
[[block]]
name = "Block2"
source = "two.mp4"
angle_deg = 90.0
travel_in_image = "right"
[block.lens]
focal_px = 720.0
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("drawn")
    (place / "one").mkdir()
    for k in range(9):
        drawn = picture_of_cable(bent(-TOUCH), bent(TOUCH), seed=k)
        cv2.imwrite(str(place / "one" / f"{k:06d}.png"), drawn)
    (place / "two.mp4").write_bytes(b"no video, and not looked at")
    (place / "survey.toml").write_text(SURVEY)
    return place


def estimate(folder, name="Block1"):
    return estimate_lens(read_survey(folder / "survey.toml"), name, FrameOptions(), LensOptions())


def test_lambda_is_found_whatever_the_survey_says_of_it_and_other_blocks_are_not_looked_at(folder):
    found = estimate(folder)
    assert found.method == LensMethod.PLUMB_LINES
    assert found.lens.division_lambda == pytest.approx(-0.04, abs=4 * found.lens.lambda_sigma)
    assert 1e-4 < found.lens.lambda_sigma < 5e-3
    assert found.lens.focal_px == 720.0


def test_a_block_that_is_not_there_is_named_with_those_that_are(folder):
    with pytest.raises(StageError, match="the survey has no block Block9; name one of Block1, Block2"):
        estimate(folder, "Block9")


def test_the_command_says_and_writes_the_same(folder, tmp_path):
    out = tmp_path / "found.json"
    words = ("lens", folder / "survey.toml", "--block", "Block1", "--json", out, "--events", "json")
    done = pipeline(*words)
    assert done.code == 0, done.stderr
    lens = json.loads(out.read_text())["Block1"]["lens"]
    assert lens["division_lambda"] == estimate(folder).lens.division_lambda
    assert f"division_lambda = {lens['division_lambda']:.6g}" in done.stdout
    assert {event["stage"] for event in done.events} == {"frames", "lens"}
    refused = pipeline("lens", folder / "survey.toml", "--block", "Block2")
    assert (refused.code, refused.stderr.count("\n")) == (2, 1)
    assert "two.mp4 cannot be opened as a video" in refused.stderr
