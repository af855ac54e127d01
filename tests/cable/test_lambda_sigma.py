"""How well a stated lambda is known is read, written back, and weighed in the adjustment."""

import math

import pytest

from pipeline.cable.joint import JointOptions, adjust_ring
from pipeline.cable.survey import LensSpec, read_survey, write_survey
from pipeline.cable.survey_records import LAMBDA_SIGMA
from pipeline.core.errors import StageError
from pipeline.core.vocabulary import LambdaRadius
from tests.cable import ring_scene, scene
from tests.cable.survey_text import CONTRACT, SECOND_BLOCK

LAMBDA_LINE = "division_lambda = -0.02\n"
WITH_SIGMA = CONTRACT.replace(LAMBDA_LINE, f"{LAMBDA_LINE}lambda_sigma = 0.00087\n")


def adjusted(views, stated, sigma):
    """The lenses of a noisy ring whose lambda, -0.05 in truth, is stated like this."""
    true = views[0].lens
    spec = LensSpec(focal_px=true.focal_px, division_lambda=stated, lambda_sigma=sigma)
    blocks = ring_scene.blocks(views, 0.05, lens=spec.lens(true.width_px, true.height_px))
    marks, robot = ring_scene.marks(views, 0.05), ring_scene.robot()
    return [b.lens for b in adjust_ring(blocks, marks, robot, JointOptions(), scene.silent).blocks]


@pytest.fixture(scope="module")
def views():
    return ring_scene.views()


@pytest.mark.parametrize("radius", LambdaRadius)
def test_sigma_is_in_lambdas_own_unit(radius):
    stated = LensSpec(focal_px=720.0, division_lambda=-1e-9, lambda_sigma=0.0007, lambda_radius=radius)
    assert stated.lens(960, 600).lambda_sigma == 0.0007


def test_without_it_a_stated_lambda_counts_as_before():
    assert LensSpec(focal_px=720.0, division_lambda=-0.02).lens(960, 600).lambda_sigma == LAMBDA_SIGMA


def test_it_is_read_and_written_back_equal(written, tmp_path):
    survey = read_survey(written(WITH_SIGMA + SECOND_BLOCK))
    assert [b.lens_spec.lambda_sigma for b in survey.blocks] == [0.00087, None]
    assert survey.blocks[0].lens(960, 600).lambda_sigma == 0.00087
    write_survey(survey, tmp_path / "copy.toml")
    assert read_survey(tmp_path / "copy.toml") == survey


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (WITH_SIGMA.replace("0.00087", "0"), ["lens.lambda_sigma is 0", "above 0"]),
        (WITH_SIGMA.replace("0.00087", "-0.001"), ["lens.lambda_sigma is -0.001", "above 0"]),
        (WITH_SIGMA.replace("0.00087", '"small"'), ['lens.lambda_sigma is "small"', "a number"]),
        (
            WITH_SIGMA.replace(LAMBDA_LINE, ""),
            ["lens.lambda_sigma is given without", "give division_lambda too"],
        ),
        (
            WITH_SIGMA.replace("calibrated = false", "calibrated = true"),
            ["lens.lambda_sigma is given, but", "lens.calibrated = true", "leave one of them out"],
        ),
    ],
)
def test_what_it_cannot_be_is_told_with_its_key(written, text, words):
    with pytest.raises(StageError) as caught:
        read_survey(written(text))
    assert all(word in str(caught.value) for word in ("block[Block1].", *words))
    assert "\n" not in str(caught.value)


def test_a_tight_sigma_holds_lambda_and_a_loose_one_lets_it_go_to_the_truth(views):
    held, free = adjusted(views, -0.04, 1e-5), adjusted(views, -0.04, 0.02)
    assert all(abs(lens.division_lambda + 0.04) < 5e-5 for lens in held)
    assert all(lens.lambda_sigma <= 1e-5 for lens in held)
    assert all(abs(lens.division_lambda + 0.05) < 4 * lens.lambda_sigma for lens in free)
    assert all(1e-5 < lens.lambda_sigma < 1e-3 for lens in free)


def test_what_is_stated_and_what_is_seen_add_up_as_information_does(views):
    """Independent knowledge of one quantity: 1 / sigma^2 = 1 / stated^2 + 1 / seen^2."""
    seen, stated = adjusted(views, -0.05, 0.02)[0].lambda_sigma, 1e-4
    both = adjusted(views, -0.05, stated)[0].lambda_sigma
    assert both == pytest.approx(1 / math.hypot(1 / stated, 1 / seen), rel=0.15)
