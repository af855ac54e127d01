"""The constructed POS follows the paper; POS files read back the same and are refused in clear words."""

from dataclasses import replace
from math import hypot, radians

import numpy as np
import pytest

from pipeline.cable.pos import (
    PosOptions,
    construct_pos,
    pos_of_block,
    read_pos,
    robot_priors,
    write_pos,
)
from pipeline.cable.pos_file import NO_FRAME, TAKEN, match_pos
from pipeline.cable.survey import Block, Cable, LensSpec, Robot, Survey
from pipeline.core.errors import StageError
from pipeline.core.vocabulary import FrameSequence, Poses, PosPriors, TravelDirection

CABLE = Cable(travel_m=0.46)
ROBOT = Robot(standoff_m=0.3, synchronised=True)
HEADER = "name,x,y,z,pitch,yaw,roll\n"


@pytest.fixture
def folder(tmp_path):
    """A folder with the images 000000.png to 000009.png."""
    for k in range(10):
        (tmp_path / f"{k:06d}.png").write_bytes(b"")
    return tmp_path


def block(angle_deg=0.0, travel=TravelDirection.RIGHT, pos=None, source="a.mp4"):
    return Block(
        name="Block1",
        source=source,
        angle_deg=angle_deg,
        travel_in_image=travel,
        pos=pos,
        lens_spec=LensSpec(focal_px=700.0),
    )


def frames_of(folder, indices=range(10), names="{:06d}.png"):
    return FrameSequence(
        block="Block1",
        files=tuple(folder / names.format(k) for k in indices),
        source_indices=np.array(list(indices), dtype=np.int64),
        source_count=10,
        width_px=960,
        height_px=600,
    )


def table(folder, rows, header=HEADER):
    path = folder / "pos.csv"
    path.write_text(header + "".join(f"{row}\n" for row in rows), encoding="utf-8")
    return path


GOOD = [f"{k:06d}.png,0.3,{0.01 * k},0,0,0,0" for k in range(10)]


def test_places_found_from_the_pictures_count_instead_of_even_steps(folder):
    found = replace(frames_of(folder, (2, 0, 1)), fractions=np.array([0.0, 0.3, 1.0]))
    priors = construct_pos(block(), ROBOT, CABLE, found, PosOptions())
    np.testing.assert_allclose(priors.poses.centres[:, 1], [0, 0.138, 0.46], atol=1e-12)
    np.testing.assert_allclose(robot_priors(ROBOT, CABLE, found, PosOptions()).y_m, [0, 0.138, 0.46])


def test_frame_k_lies_k_minus_1_steps_along_the_cable(folder):
    priors = construct_pos(block(), ROBOT, CABLE, frames_of(folder), PosOptions())
    step = 0.46 / 9
    expected = [[0.3, (k - 1) * step, 0.0] for k in range(1, 11)]
    np.testing.assert_allclose(priors.poses.centres, expected, atol=1e-15)


def test_selected_frames_lie_at_their_fraction_of_the_travel(folder):
    priors = construct_pos(block(), ROBOT, CABLE, frames_of(folder, [0, 4, 9]), PosOptions())
    np.testing.assert_allclose(priors.poses.centres[:, 1], [0, 0.46 * 4 / 9, 0.46], atol=1e-15)


@pytest.mark.parametrize(
    ("travel", "column", "row"),
    [
        (TravelDirection.RIGHT, 1.0, 0.0),
        (TravelDirection.LEFT, -1.0, 0.0),
        (TravelDirection.UP, 0.0, -1.0),
        (TravelDirection.DOWN, 0.0, 1.0),
    ],
)
@pytest.mark.parametrize("angle_deg", [0.0, 90.0, 200.0])
def test_every_camera_looks_square_at_the_axis_with_its_travel_as_told(
    folder, travel, column, row, angle_deg
):
    priors = construct_pos(block(angle_deg, travel), ROBOT, CABLE, frames_of(folder), PosOptions())
    R, t = priors.poses.rotations, priors.poses.translations
    axis_points = np.stack([np.zeros(10), priors.poses.centres[:, 1], np.zeros(10)], axis=1)
    in_camera = np.einsum("nij,nj->ni", R, axis_points) + t
    np.testing.assert_allclose(in_camera, np.tile([0, 0, 0.3], (10, 1)), atol=1e-12)
    np.testing.assert_allclose(R @ [0, 1, 0], np.tile([column, row, 0.0], (10, 1)), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(R), 1.0, atol=1e-12)
    a = radians(angle_deg)
    np.testing.assert_allclose(
        priors.poses.centres[:, [0, 2]], np.tile([0.3 * np.cos(a), -0.3 * np.sin(a)], (10, 1)), atol=1e-12
    )


def test_the_sigmas_are_tight_at_the_ends_loose_inside_and_know_the_lever(folder):
    options = PosOptions(sway_deg=0.2, sway_mm=0.5, wander_mm=2.0, mounting_deg=0.0, mounting_mm=0.0)
    cable = replace(CABLE, travel_sigma_mm=0.1)
    sigmas = construct_pos(block(), ROBOT, cable, frames_of(folder), options).sigmas
    lever = 0.3 * radians(0.2)
    np.testing.assert_allclose(sigmas[:, :3], radians(0.2))
    np.testing.assert_allclose(sigmas[:, 3], 0.0005)  # towards the axis: the arm turns, it does not grow
    np.testing.assert_allclose(sigmas[:, 5], hypot(0.0005, lever))  # around the axis
    assert sigmas[0, 4] == pytest.approx(lever)
    assert sigmas[-1, 4] == pytest.approx(hypot(lever, 0.0001))
    assert sigmas[4, 4] == pytest.approx(hypot(hypot(lever, 0.002), 0.0001), rel=0.02)
    quarter = construct_pos(block(90.0), ROBOT, cable, frames_of(folder), options).sigmas
    np.testing.assert_allclose(quarter[:, [3, 5]], sigmas[:, [5, 3]])


def test_the_mounting_adds_to_all_of_it(folder):
    without = PosOptions(mounting_deg=0.0, mounting_mm=0.0)
    plain = construct_pos(block(30.0), ROBOT, CABLE, frames_of(folder), without).sigmas
    mounted = construct_pos(
        block(30.0), ROBOT, CABLE, frames_of(folder), PosOptions(mounting_deg=0.4, mounting_mm=0.6)
    ).sigmas
    expected = np.repeat([radians(0.4), 0.0006], 3)
    np.testing.assert_allclose(np.sqrt(mounted**2 - plain**2), np.tile(expected, (10, 1)), rtol=1e-9)


def swaying(seed, azimuth_deg):
    """Poses all over the place, with sigmas."""
    rng = np.random.default_rng(seed)
    q, _ = np.linalg.qr(rng.normal(size=(10, 3, 3)))
    rotations = q * np.linalg.det(q)[:, None, None]
    poses = Poses(rotations=rotations, translations=rng.normal(size=(10, 3)))
    return PosPriors(poses=poses, sigmas=rng.uniform(1e-4, 1e-2, (10, 6)))


@pytest.mark.parametrize("travel", list(TravelDirection))
def test_a_written_pos_reads_back_the_same(folder, travel):
    written = swaying(5, 120.0)
    which = block(120.0, travel)
    write_pos(folder / "pos.csv", which, frames_of(folder), written)
    read = read_pos(folder / "pos.csv", which, frames_of(folder))
    np.testing.assert_allclose(read.poses.rotations, written.poses.rotations, atol=1e-9)
    np.testing.assert_allclose(read.poses.translations, written.poses.translations, atol=1e-9)
    np.testing.assert_allclose(read.sigmas, written.sigmas, rtol=1e-9)


@pytest.mark.parametrize(
    ("angles", "turned"),
    [
        # a ray straight ahead, turned about the camera's own axes: yaw about y (down) turns it to the right,
        # pitch about x (right) turns it up, roll about z leaves it
        ("0,90,0", [1, 0, 0]),
        ("90,0,0", [0, -1, 0]),
        ("0,0,90", [0, 0, 1]),
        # yaw first, then pitch about the turned axis: the ray ends up, whatever the yaw
        ("90,90,0", [0, -1, 0]),
    ],
)
def test_angles_turn_about_the_cameras_own_axes_yaw_then_pitch_then_roll(folder, angles, turned):
    nominal = construct_pos(block(), ROBOT, CABLE, frames_of(folder), PosOptions()).poses.rotations[0]
    rows = [f"{k},0.3,0,0,{angles}" for k in range(10)]
    priors = read_pos(table(folder, rows), block(), frames_of(folder))
    ahead_in_nominal = nominal @ priors.poses.rotations[0].T @ [0, 0, 1]
    np.testing.assert_allclose(ahead_in_nominal, turned, atol=1e-12)


def test_sigmas_are_those_of_the_file_or_else_those_given(folder):
    header = "name,x,y,z,pitch,yaw,roll,sigma_y,sigma_yaw\n"
    path = table(folder, [f"{row},0.002,0.5" for row in GOOD], header)
    sigmas = read_pos(path, block(), frames_of(folder), sigma_deg=0.1, sigma_mm=1.0).sigmas
    expected = [radians(0.1), radians(0.5), radians(0.1), 0.001, 0.002, 0.001]
    np.testing.assert_allclose(sigmas, np.tile(expected, (10, 1)))


@pytest.mark.parametrize("name", ["{:06d}.png", "{:06d}", "{}", "{:06d}.jpg"])
def test_a_name_is_a_file_name_with_or_without_ending_or_a_number(folder, name):
    rows = [name.format(k) + f",0.3,{0.01 * k},0,0,0,0" for k in reversed(range(10))]
    centres = read_pos(table(folder, rows), block(), frames_of(folder)).poses.centres
    np.testing.assert_allclose(centres[:, 1], 0.01 * np.arange(10), atol=1e-15)


def test_rows_of_frames_that_were_not_selected_are_passed_over(folder):
    centres = read_pos(table(folder, GOOD), block(), frames_of(folder, [0, 3, 9])).poses.centres
    np.testing.assert_allclose(centres[:, 1], [0, 0.03, 0.09], atol=1e-15)


def test_images_of_a_folder_are_found_by_name_even_if_not_selected(tmp_path):
    for k in range(10):
        (tmp_path / f"shot{k}.jpg").write_bytes(b"")
    frames = frames_of(tmp_path, [0, 5, 9], "shot{}.jpg")
    rows = [f"shot{k}.jpg,0.3,{0.01 * k},0,0,0,0" for k in range(10)]
    centres = read_pos(table(tmp_path, rows), block(), frames).poses.centres
    np.testing.assert_allclose(centres[:, 1], [0, 0.05, 0.09], atol=1e-15)


def test_numbers_in_the_names_of_images_go_before_counting(tmp_path):
    files = tuple(tmp_path / f"{k:03d}.png" for k in (1, 2, 3))
    for file in files:
        file.write_bytes(b"")
    frames = FrameSequence(
        block="Block1",
        files=files,
        source_indices=np.arange(3),
        source_count=3,
        width_px=9,
        height_px=6,
    )
    rows = [f"{k},0.3,{k},0,0,0,0" for k in (1, 2, 3)]
    assert read_pos(table(tmp_path, rows), block(), frames).poses.centres[:, 1].tolist() == [1, 2, 3]


def with_row(row, at=3):
    return [*GOOD[:at], row, *GOOD[at + 1 :]]


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        (GOOD[:4] + GOOD[5:], ["no row for 000004.png (frame 4)"]),
        (with_row(GOOD[2]), ["line 5 names 000002.png again after line 4"]),
        (with_row("2" + GOOD[2][10:]), ["line 5 names 2 again after line 4"]),
        (with_row("000003.png,0.3,nan,0,0,0,0"), ["line 5: y is nan", "finite"]),
        (with_row("000003.png,0.3,0,0,inf,0,0"), ["line 5: pitch is inf", "finite"]),
        (with_row("000003.png,0.3,0,0,0,,0"), ["line 5: yaw is empty"]),
        (with_row("000003.png,0.3,0,0,0,0,level"), ['line 5: roll is "level"']),
        (with_row(",0.3,0,0,0,0,0"), ["line 5 has no name"]),
        (with_row("000003.png,0.3,0,0,0,0"), ["line 5 has 6 values for 7 columns"]),
        (with_row("other.png,0.3,0,0,0,0,0"), ["line 5 names other.png", "no frame of Block1"]),
        (with_row("12,0.3,0,0,0,0,0"), ["line 5 names 12", "0 to 9"]),
        ([*GOOD, "11,0,0,0,0,0,0"], ["11 rows", "only 10 frames"]),
        ([], ["no row for 000000.png"]),
    ],
)
def test_a_bad_row_is_told_with_file_line_and_key(folder, rows, words):
    with pytest.raises(StageError) as caught:
        read_pos(table(folder, rows), block(), frames_of(folder))
    assert caught.value.stage == "pos"
    for word in ["pos.csv", *words]:
        assert word in str(caught.value)


@pytest.mark.parametrize(
    ("header", "word"),
    [
        ("", "is empty"),
        ("name,x,y,z,pitch,yaw\n", "has no column roll"),
        ("name,x,y,z,pitch,yaw,roll,speed\n", "unknown column speed"),
        ("name,x,y,z,pitch,yaw,roll,x\n", "the column x twice"),
    ],
)
def test_a_bad_header_is_told(folder, header, word):
    with pytest.raises(StageError, match=r"pos\.csv") as caught:
        read_pos(table(folder, [], header), block(), frames_of(folder))
    assert word in str(caught.value)


def test_a_sigma_of_zero_and_a_missing_file_are_refused(folder):
    header = "name,x,y,z,pitch,yaw,roll,sigma_y\n"
    with pytest.raises(StageError, match="line 2: sigma_y is 0; give a standard deviation above zero"):
        read_pos(table(folder, [f"{row},0" for row in GOOD], header), block(), frames_of(folder))
    with pytest.raises(StageError, match=r"none\.csv cannot be read"):
        read_pos(folder / "none.csv", block(), frames_of(folder))


def test_a_block_takes_its_file_where_the_survey_names_one(folder):
    path = table(folder, GOOD)
    survey = Survey(format=1, name="test", cable=CABLE, robot=ROBOT, blocks=(block(),))
    measured = pos_of_block(survey, block(pos=path), frames_of(folder), PosOptions(measured_mm=2.0))
    constructed = pos_of_block(survey, block(), frames_of(folder), PosOptions())
    assert measured.poses.centres[-1, 1] == pytest.approx(0.09)
    assert constructed.poses.centres[-1, 1] == pytest.approx(0.46)
    assert measured.sigmas[0, 3] == pytest.approx(0.002)


def test_a_look_at_a_file_tells_what_became_of_each_row_and_refuses_no_name(folder):
    rows = [GOOD[2], GOOD[0], "window.png,0.3,0,0,0,0,0", "2,0.3,0,0,0,0,0", GOOD[9]]
    found = match_pos(table(folder, rows), frames_of(folder))
    assert found.names == ("000002.png", "000000.png", "window.png", "2", "000009.png")
    assert found.frames == (2, 0, NO_FRAME, TAKEN, 9)
    assert found.without_row == (1, 3, 4, 5, 6, 7, 8)
    with pytest.raises(StageError, match="x is empty"):
        match_pos(table(folder, ["000001.png,,0,0,0,0,0"]), frames_of(folder))
