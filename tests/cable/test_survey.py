"""survey.toml is read strictly: what is wrong is told in one sentence with the key's full name."""

import math

import pytest

from pipeline.cable.survey import LensSpec, read_survey, write_survey
from pipeline.core.errors import StageError
from pipeline.core.vocabulary import LambdaRadius, TravelDirection
from tests.cable.survey_text import CONTRACT, SECOND_BLOCK


def test_the_example_of_the_contract_is_read_in_full(written):
    survey = read_survey(written(CONTRACT + SECOND_BLOCK))
    first, second = survey.blocks
    assert (survey.name, survey.cable.travel_m, survey.cable.diameter_mm) == ("stay-07", 0.46, 110.0)
    assert [(s.name, s.position_m) for s in survey.cable.stations] == [("A", 0.10)]
    assert (survey.robot.standoff_m, survey.robot.synchronised) == (0.30, True)
    assert (first.name, first.angle_deg, first.travel_in_image) == ("Block1", 0.0, TravelDirection.RIGHT)
    assert first.source.is_absolute()
    assert (first.source.name, first.pos.name) == ("block1.mp4", "block1_pos.csv")
    assert (second.angle_deg, second.travel_in_image, second.pos) == (90.0, TravelDirection.UP, None)
    assert survey.options == {}


def test_the_lens_waits_for_the_image_size(written):
    first, second = read_survey(written(CONTRACT + SECOND_BLOCK)).blocks
    lens = first.lens(960, 600)
    assert (lens.focal_px, lens.principal_point_px, lens.division_lambda) == (720.0, (480.0, 300.0), -0.02)
    assert lens.lambda_radius is LambdaRadius.HALF_DIAGONAL
    other = second.lens(800, 600)
    assert other.focal_px == pytest.approx(4.5 / 6.0 * 800)
    assert other.principal_point_px == (400.0, 300.0)
    assert second.lens_spec.division_lambda is None


def test_only_a_calibrated_lens_has_no_uncertainty():
    trusted = LensSpec(focal_px=720.0, division_lambda=-0.02, calibrated=True).lens(960, 600)
    start = LensSpec(focal_px=720.0, division_lambda=-0.02).lens(960, 600)
    unknown = LensSpec(focal_px=720.0, calibrated=True).lens(960, 600)
    assert (trusted.focal_sigma_px, trusted.lambda_sigma) == (0.0, 0.0)
    assert 0.01 < start.focal_sigma_px / 720 < 0.1
    assert 0 < start.lambda_sigma < unknown.lambda_sigma < 0.5
    assert unknown.focal_sigma_px == 0.0


def test_the_sigma_of_lambda_is_the_same_in_any_unit():
    half_diagonal = math.hypot(960, 600) / 2
    reference = LensSpec(focal_px=720.0).lens(960, 600).lambda_sigma
    for radius, unit_px in ((LambdaRadius.HALF_WIDTH, 480.0), (LambdaRadius.FOCAL, 720.0)):
        lens = LensSpec(focal_px=720.0, lambda_radius=radius).lens(960, 600)
        assert lens.lambda_sigma / unit_px**2 == pytest.approx(reference / half_diagonal**2)


def test_a_lens_that_folds_or_is_off_centre_is_told_with_its_block(written):
    folding = read_survey(written(CONTRACT.replace("-0.02", "-1.2"))).blocks[0]
    with pytest.raises(StageError, match=r"block\[Block1\]\.lens: division_lambda = -1.2"):
        folding.lens(960, 600)
    outside = read_survey(written(CONTRACT)).blocks[0]
    with pytest.raises(StageError, match=r"block\[Block1\]\.lens\.principal_point_px .* 400 x 300"):
        outside.lens(400, 300)


def test_without_stations_there_is_one_every_50_mm(written):
    station = '[[cable.station]]\nname = "A"\nposition_m = 0.10\n'
    stations = read_survey(written(CONTRACT.replace(station, ""))).cable.stations
    assert [s.name for s in stations] == [f"S{k}" for k in range(1, 10)]
    assert [s.position_m for s in stations] == pytest.approx([0.05 * k for k in range(1, 10)])
    short = CONTRACT.replace(station, "").replace("0.46", "0.04")
    assert [s.position_m for s in read_survey(written(short)).cable.stations] == [0.02]


def test_options_are_kept_as_they_stand(written):
    survey = read_survey(written(CONTRACT + "[options.frames]\nspacing_mm = 5\n[options.dense]\n"))
    assert survey.stage_options("frames") == {"spacing_mm": 5}
    assert survey.stage_options("dense") == survey.stage_options("match") == {}


def test_a_source_may_be_a_folder_or_a_pattern(written, tmp_path):
    (tmp_path / "images").mkdir()
    (tmp_path / "images" / "a.png").write_bytes(b"")
    for source in ("images", "images/*.png"):
        survey = read_survey(written(CONTRACT.replace("block1.mp4", source)))
        assert survey.blocks[0].source == tmp_path / source


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("format = 1", "format = 2", ["format is 2", "format = 1"]),
        ("name = ", "nane = ", ["unknown key nane", "perhaps name"]),
        (
            "focal_px",
            "focal_pix",
            ["unknown key block[Block1].lens.focal_pix", "block[Block1].lens.focal_px"],
        ),
        ("standoff_m", "standof_m", ["unknown key robot.standof_m", "robot.standoff_m"]),
        ("travel_m = 0.46\n", "", ["cable.travel_m is missing"]),
        ("0.46", "0", ["cable.travel_m is zero", "scale"]),
        ("0.46", "-1.0", ["cable.travel_m is -1", "positive"]),
        ("0.46", '"long"', ['cable.travel_m is "long"', "a number"]),
        ("0.10", "0.47", ["cable.station[A].position_m = 0.47", "between 0 and 0.46"]),
        ("0.10", "-0.1", ["cable.station[A].position_m", "at least 0"]),
        ("standoff_m = 0.30", "standoff_m = 0.055", ["robot.standoff_m = 0.055", "110 mm"]),
        ("standoff_m = 0.30", "standoff_m = 0", ["robot.standoff_m", "above 0"]),
        ("110.0", "-3", ["cable.diameter_mm", "above 0"]),
        ("synchronised = true", 'synchronised = "yes"', ["robot.synchronised", "true or false"]),
        ('"Block1"', '"a/b"', ['block.name "a/b"', "folder"]),
        ('"Block1"', '".."', ['block.name ".."', "folder"]),
        ('"Block1"', '"NUL"', ['block.name "NUL"', "folder"]),
        ('"right"', '"forward"', ["block[Block1].travel_in_image", "right, left, up, down"]),
        ("block1.mp4", "no.mp4", ["block[Block1].source", "no.mp4 does not exist"]),
        ("block1.mp4", "no*.png", ["block[Block1].source", "no file matches"]),
        ("block1_pos.csv", "no.csv", ["block[Block1].pos", "no.csv does not exist"]),
        ("half-diagonal", "corner", ["lens.lambda_radius", "half-diagonal, half-width, focal, pixel"]),
        ("720.0", "0", ["block[Block1].lens.focal_px is 0", "above 0"]),
        ("720.0", "nan", ["block[Block1].lens.focal_px is nan"]),
        ("focal_px = 720.0\n", "", ["block[Block1].lens has no focal length", "focal_px"]),
        ("focal_px = 720.0\n", "focal_mm = 4\n", ["no focal length", "sensor_width_mm"]),
        ("focal_px = 720.0\n", "focal_px = 720.0\nfocal_mm = 4\n", ["both in pixels and in millimetres"]),
        ("[480.0, 300.0]", "[-1.0, 300.0]", ["block[Block1].lens.principal_point_px"]),
        ("[robot]", "[[robot]]", ["robot is a list", "[robot]"]),
        ("[cable]", "[cable", ["survey.toml is no TOML", "line"]),
    ],
)
def test_what_is_wrong_is_told_with_its_key(written, old, new, words):
    assert old in CONTRACT
    with pytest.raises(StageError) as caught:
        read_survey(written(CONTRACT.replace(old, new, 1)))
    assert caught.value.stage == "survey"
    for word in words:
        assert word in str(caught.value)
    assert "\n" not in str(caught.value)


UNORDERED = 'travel_in_image = "right"\nordered = false'


def test_images_are_in_order_unless_the_block_says_otherwise(written, tmp_path):
    (tmp_path / "images").mkdir()
    text = CONTRACT.replace("block1.mp4", "images")
    assert read_survey(written(text)).blocks[0].ordered
    survey = read_survey(written(text.replace('travel_in_image = "right"', UNORDERED)))
    assert not survey.blocks[0].ordered
    write_survey(survey, tmp_path / "copy.toml")
    assert read_survey(tmp_path / "copy.toml") == survey


def test_frames_of_a_video_are_in_order(written):
    with pytest.raises(StageError, match=r"block\[Block1\].ordered = false, but its source is a video"):
        read_survey(written(CONTRACT.replace('travel_in_image = "right"', UNORDERED)))


def test_unordered_and_ordered_blocks_share_no_clock(written, tmp_path):
    (tmp_path / "images").mkdir()
    text = CONTRACT.replace("block1.mp4", "images").replace('travel_in_image = "right"', UNORDERED)
    with pytest.raises(StageError, match=r"block\[Block1\].ordered = false, but other blocks .* order"):
        read_survey(written(text + SECOND_BLOCK))
    alone = text.replace("synchronised = true", "synchronised = false")
    assert [b.ordered for b in read_survey(written(alone + SECOND_BLOCK)).blocks] == [False, True]


@pytest.mark.parametrize(
    ("addition", "words"),
    [
        (SECOND_BLOCK.replace("Block2", "block1"), ['block.name "block1"', "more than once"]),
        (
            SECOND_BLOCK.replace("90", "-360"),
            ["block[Block1].angle_deg and block[Block2].angle_deg", "both 0"],
        ),
        (SECOND_BLOCK + "[options]\nframes = 3\n", ["options.frames is no table"]),
    ],
)
def test_names_and_angles_are_there_once(written, addition, words):
    with pytest.raises(StageError) as caught:
        read_survey(written(CONTRACT + addition))
    for word in words:
        assert word in str(caught.value)


def test_two_stations_of_one_name_are_refused(written):
    twice = '[[cable.station]]\nname = "A"\nposition_m = 0.2\n[robot]'
    with pytest.raises(StageError, match=r'cable\.station\.name "a" is there more than once'):
        read_survey(written(CONTRACT.replace("[robot]", twice)))


def test_a_survey_without_blocks_is_refused(written):
    head = CONTRACT[: CONTRACT.index("[[block]]")]
    with pytest.raises(StageError, match="block is missing"):
        read_survey(written(head))
    with pytest.raises(StageError, match="block is an empty list"):
        read_survey(written("block = []\n" + head))


def test_a_file_that_is_none_is_refused(tmp_path):
    with pytest.raises(StageError, match=r"none\.toml cannot be read"):
        read_survey(tmp_path / "none.toml")
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(StageError, match=r"binary\.toml is no UTF-8 text"):
        read_survey(tmp_path / "binary.toml")


def test_a_travel_of_which_nothing_is_stated_is_known_to_half_a_tenth_of_a_millimetre(written):
    assert read_survey(written(CONTRACT)).cable.travel_sigma_mm == 0.05


def test_a_negative_sigma_of_the_travel_is_refused(written):
    with pytest.raises(StageError, match=r"cable\.travel_sigma_mm is -0\.1"):
        read_survey(written(CONTRACT.replace("[cable]\n", "[cable]\ntravel_sigma_mm = -0.1\n")))
