"""Calibration from a chessboard: pictures drawn by numpy through a known lens, corners by OpenCV."""

import cv2
import numpy as np
import pytest

from pipeline.cable import chessboard
from pipeline.core.errors import StageError
from pipeline.core.events import silent
from pipeline.core.rotations import rotation_from_vector

FOCAL, CENTRE, LAMBDA = 520.0, np.array([322.0, 236.0]), -0.08
HALF_DIAGONAL = 400.0
POSES = [
    ((0.0, 0.0, 0.0), (0.3, -0.2, 11.0)),
    ((0.5, 0.1, 0.1), (-0.8, 0.3, 11.5)),
    ((-0.5, 0.0, -0.2), (0.9, -0.3, 11.5)),
    ((0.05, 0.55, 0.1), (0.2, 0.9, 11.5)),
    ((0.0, -0.55, 0.3), (0.0, -0.6, 12.0)),
    ((0.35, 0.35, -0.4), (0.6, 0.7, 11.5)),
]


def draw_board(rotation_vector, translation, scale=3):
    """A 9 x 6 board of unit squares, 640 x 480: each pixel is the mean of scale^2 rays through the lens."""
    steps = (np.arange(640 * scale) + 0.5) / scale, (np.arange(480 * scale) + 0.5) / scale
    d = (np.stack(np.meshgrid(*steps), axis=-1) - CENTRE) / HALF_DIAGONAL
    ideal = d / (1 + LAMBDA * np.sum(d**2, axis=-1, keepdims=True)) * HALF_DIAGONAL / FOCAL
    R = rotation_from_vector(np.array(rotation_vector))
    plane = np.column_stack([R[:, :2], translation])
    hit = np.concatenate([ideal, np.ones((*ideal.shape[:2], 1))], axis=-1) @ np.linalg.inv(plane).T
    x, y = np.moveaxis(hit[..., :2] / hit[..., 2:], -1, 0)
    inside = (np.abs(x) < 5) & (np.abs(y) < 3.5)
    dark = inside & ((np.floor(x + 5) + np.floor(y + 3.5)) % 2 == 0)
    picture = np.where(dark, 40.0, 215.0).reshape(480, scale, 640, scale).mean(axis=(1, 3))
    noise = np.random.default_rng(0).normal(0, 2, picture.shape)
    return np.clip(picture + noise, 0, 255).astype(np.uint8)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("board")
    for i, (turn, shift) in enumerate(POSES):
        cv2.imwrite(str(place / f"view{i}.png"), draw_board(turn, shift))
    cv2.imwrite(str(place / "wall.png"), np.full((480, 640), 128, np.uint8))
    (place / "notes.txt").write_text("not a picture")
    return place


def test_lens_is_recovered_within_its_sigmas(folder):
    events = []
    found = chessboard.calibrate_chessboard(folder, "9x6", 25.0, events.append)
    lens = found.lens
    assert abs(lens.focal_px - FOCAL) < 4 * lens.focal_sigma_px
    assert abs(lens.division_lambda - LAMBDA) < 4 * lens.lambda_sigma
    offsets = np.abs(np.array(lens.principal_point_px) - CENTRE)
    assert (offsets < 4 * np.array(found.principal_point_sigma_px)).all()
    assert 0.05 < lens.focal_sigma_px < 1.0
    assert 5e-5 < lens.lambda_sigma < 1e-3
    assert found.noise_px < 0.1
    assert len(found.used) == 6
    assert [file.name for file in found.unused] == ["wall.png"]
    assert events[-1].done == events[-1].total == 7


def test_corners_are_counted_from_the_corner_of_the_first_pixel():
    """Seen square on, the board's middle corner lies where the axis of the pose meets the picture."""
    corners = chessboard.find_corners(draw_board((0, 0, 0), (0.0, 0.0, 11.0)), 9, 6)
    middle = corners.reshape(6, 9, 2)[2:4, 4].mean(axis=0)
    np.testing.assert_allclose(middle, CENTRE, atol=0.05)


def test_exact_corners_give_the_lens_exactly():
    model_points = chessboard._board_points(9, 6, 1.0)
    views = []
    for turn, shift in POSES:
        in_cam = model_points @ rotation_from_vector(np.array(turn)).T + shift
        ideal = FOCAL * in_cam[:, :2] / in_cam[:, 2:] / HALF_DIAGONAL
        u2 = np.sum(ideal**2, axis=1, keepdims=True)
        bent = ideal * 2 / (1 + np.sqrt(1 - 4 * LAMBDA * u2)) * HALF_DIAGONAL + CENTRE
        views.append(chessboard.BoardView(file=None, corners_px=bent))
    lens = chessboard.calibrate_views(views, model_points, 640, 480).lens
    assert lens.focal_px == pytest.approx(FOCAL, abs=1e-5)
    assert lens.division_lambda == pytest.approx(LAMBDA, abs=1e-8)
    np.testing.assert_allclose(lens.principal_point_px, CENTRE, atol=1e-5)


def test_what_to_write_into_the_survey_can_be_read_back(folder):
    import tomllib

    text = chessboard.survey_lines(chessboard.calibrate_chessboard(folder, "9x6", emit=silent))
    lens = tomllib.loads("[[block]]\n" + text)["block"][0]["lens"]
    assert lens["focal_px"] == pytest.approx(FOCAL, abs=2)
    assert lens["lambda_radius"] == "half-diagonal"
    assert lens["calibrated"] is True


def test_hopeless_folders_are_refused_in_one_sentence(folder, tmp_path):
    with pytest.raises(StageError, match="is no folder"):
        chessboard.calibrate_chessboard(tmp_path / "nowhere", "9x6")
    with pytest.raises(StageError, match="has no pictures"):
        chessboard.calibrate_chessboard(tmp_path, "9x6")
    with pytest.raises(StageError, match='"nine" is no size'):
        chessboard.calibrate_chessboard(folder, "nine")
    grey = np.full((480, 640), 128, np.uint8)
    cv2.imwrite(str(tmp_path / "a.png"), grey)
    with pytest.raises(StageError, match=r"no picture in .* shows a board of 9x6"):
        chessboard.calibrate_chessboard(tmp_path, "9x6")
    cv2.imwrite(str(tmp_path / "b.png"), draw_board(*POSES[0]))
    with pytest.raises(StageError, match="only 1 of 2 pictures"):
        chessboard.calibrate_chessboard(tmp_path, "9x6")
    cv2.imwrite(str(tmp_path / "c.png"), grey[:400])
    with pytest.raises(StageError, match=r"c\.png has 640 x 400 pixels"):
        chessboard.calibrate_chessboard(tmp_path, "9x6")
    (tmp_path / "b.png").write_bytes(b"rubbish")
    with pytest.raises(StageError, match="cannot be read as an image"):
        chessboard.calibrate_chessboard(tmp_path, "9x6")


def test_a_board_seen_from_one_side_only_does_not_determine_the_focal_length():
    board = chessboard._board_points(9, 6, 1.0)
    rng = np.random.default_rng(1)
    views = []
    for depth in (9.0, 10.0, 11.0):
        flat = FOCAL * board[:, :2] / depth + CENTRE + rng.normal(0, 0.05, (54, 2))
        views.append(chessboard.BoardView(file=None, corners_px=flat))
    with pytest.raises(StageError, match=r"do not determine"):
        chessboard.calibrate_views(views, board, 640, 480)
