"""Pictures are shared between cases that differ in their claims, and nothing rendered is ever lost."""

from dataclasses import replace

import pytest

from synth.spec import Robot, Sensor, Spec
from synth.stamps import PICTURES, pictures_stamp
from synth.suite_cache import share_pictures, survey_digest

PAPER = Spec(name="paper", robot=Robot(cameras=2))
SCALE = replace(PAPER, name="scale", survey=replace(PAPER.survey, travel_error_percent=0.1))


def rendered(spec, survey, whole=True):
    """A folder as rendering leaves it."""
    (survey / ".synth").mkdir(parents=True)
    (survey / PICTURES).write_text(pictures_stamp(spec))
    (survey / "block1.mp4").write_text("first video")
    if whole:
        (survey / "block2.mp4").write_text("second video")
        (survey / "survey.toml").write_text("format = 1")
    return survey


@pytest.fixture
def paper(tmp_path):
    return rendered(PAPER, tmp_path / "paper" / "seed-1" / "survey")


def test_a_case_that_only_claims_something_else_gets_the_videos_and_tells_its_own(paper, tmp_path):
    survey = tmp_path / "scale" / "seed-1" / "survey"
    assert share_pictures(SCALE, survey, tmp_path) == paper
    assert (survey / PICTURES).read_text() == pictures_stamp(SCALE)
    assert (survey / "block2.mp4").samefile(paper / "block2.mp4")
    assert not (survey / "survey.toml").exists()  # that and truth.json are written by rendering
    (survey / "block2.mp4").unlink()
    assert (paper / "block2.mp4").read_text() == "second video"


def test_a_folder_of_images_is_shared_file_by_file(tmp_path):
    spec = replace(PAPER, sensor=Sensor(output="images"))
    source = rendered(spec, tmp_path / "a" / "seed-1" / "survey")
    (source / "block1").mkdir()
    (source / "block1" / "0000.png").write_text("frame")
    survey = tmp_path / "b" / "seed-1" / "survey"
    assert share_pictures(replace(spec, name="b"), survey, tmp_path) == source
    assert (survey / "block1" / "0000.png").read_text() == "frame"


def test_other_pictures_and_unfinished_ones_are_not_taken(paper, tmp_path):
    survey = tmp_path / "scale" / "seed-2" / "survey"
    assert share_pictures(replace(SCALE, seed=2), survey, tmp_path) is None
    rendered(replace(PAPER, seed=3), tmp_path / "paper" / "seed-3" / "survey", whole=False)
    assert share_pictures(replace(SCALE, seed=3), tmp_path / "scale" / "seed-3" / "survey", tmp_path) is None
    assert not survey.exists()


def test_what_a_case_has_already_is_left_alone(paper, tmp_path):
    own = rendered(replace(PAPER, seed=9), tmp_path / "scale" / "seed-1" / "survey")
    (own / "block2.mp4").write_text("mine")
    assert share_pictures(SCALE, own, tmp_path) is None
    (own / "survey.toml").unlink()
    assert share_pictures(SCALE, own, tmp_path) is None  # unfinished, of another specification
    assert (own / "block2.mp4").read_text() == "mine"
    assert share_pictures(PAPER, paper, tmp_path) is None


def test_the_digest_of_a_survey_follows_its_claims_and_its_pictures(paper):
    first = survey_digest(paper)
    (paper / "survey.toml").write_text("format = 1 # other")
    second = survey_digest(paper)
    (paper / PICTURES).write_text("other")
    assert len({first, second, survey_digest(paper)}) == 3
