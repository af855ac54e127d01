"""The lens stage on drawn frames: given, estimated, switched off; undistorted frames; pictures."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from pipeline.cable.lens import (
    CableScene,
    LensMethod,
    LensOptions,
    solve_lens,
    undistort_frames,
)
from pipeline.cable.lens_pictures import before_after_picture, distortion_grid_picture
from pipeline.core.division import pixels_to_rays, rays_to_pixels
from pipeline.core.errors import StageError
from pipeline.core.pictures import read_colour
from pipeline.core.vocabulary import FrameSequence, LambdaRadius, Lens, TravelDirection
from tests.cable.outline_pictures import picture_of_cable

LENS = Lens(
    width_px=960, height_px=600, focal_px=720.0, principal_point_px=(480.0, 300.0), division_lambda=-0.04
)
SCENE = CableScene(travel_m=0.12, standoff_m=0.30)
RIGHT = TravelDirection.RIGHT
HALF_DIAGONAL = np.hypot(480, 300)
TOUCH = 720 * np.tan(np.arcsin(0.055 / 0.30))
"""Height of the outline above the middle in an ideal picture."""


def bent(height):
    """The curve y(x), pixels, in which the lens of LENS shows the ideal line y = height."""

    def curve(x):
        y = np.full_like(x, height)
        for _ in range(30):
            y = height * (1 - 0.04 * ((x - 480) ** 2 + y**2) / HALF_DIAGONAL**2)
        return y + 300

    return curve


def sequence(folder, pictures):
    files = []
    for k, picture in enumerate(pictures):
        files.append(folder / f"{k:06d}.png")
        cv2.imwrite(str(files[-1]), picture)
    return FrameSequence(
        block="Block1",
        files=tuple(files),
        source_indices=np.arange(len(files)) * 5,
        source_count=5 * len(files) - 4,
        width_px=960,
        height_px=600,
    )


@pytest.fixture(scope="module")
def frames(tmp_path_factory):
    pictures = (picture_of_cable(bent(-TOUCH + k), bent(TOUCH + k), shift_px=40 * k) for k in range(5))
    return sequence(tmp_path_factory.mktemp("frames"), pictures)


def solve(frames, lens=LENS, known=True, options=None, emit=lambda event: None, scene=SCENE):
    return solve_lens(frames, lens, known, RIGHT, options or LensOptions(), emit, scene=scene)


def test_given_lambda_is_kept_and_the_outline_tells_the_radius(frames):
    found = solve(frames)
    assert found.method is LensMethod.GIVEN
    assert found.lens == LENS
    assert found.apparent_radius_m == pytest.approx(0.055, abs=2e-4)


def test_unknown_lambda_is_found_from_the_cables_edges(frames):
    events = []
    found = solve(frames, replace(LENS, division_lambda=0.0), known=False, emit=events.append)
    assert found.method is LensMethod.PLUMB_LINES
    error = found.lens.division_lambda + 0.04
    assert abs(error) < 2 * found.lens.lambda_sigma
    assert 1e-4 < found.lens.lambda_sigma < 0.006
    assert found.plumb_lines.line_count == 10
    assert found.plumb_lines.straight_px < 0.3 * found.plumb_lines.bent_px
    assert found.apparent_radius_m == pytest.approx(0.055, abs=2e-4)
    assert [event.stage for event in events] == ["lens"] * 6
    assert (events[-1].done, events[-1].total, events[-1].block) == (5, 5, "Block1")


def test_lambda_comes_in_the_unit_of_the_lens(frames):
    lens = replace(LENS, division_lambda=0.0, lambda_radius=LambdaRadius.HALF_WIDTH)
    half_width, half_diagonal = (
        solve(frames, each, known=False).lens
        for each in (lens, replace(lens, lambda_radius=LENS.lambda_radius))
    )
    per_unit = (480 / HALF_DIAGONAL) ** 2
    assert half_width.division_lambda == pytest.approx(half_diagonal.division_lambda * per_unit, rel=1e-9)
    assert half_width.lambda_sigma == pytest.approx(half_diagonal.lambda_sigma * per_unit, rel=1e-9)


def test_correction_switched_off_holds_lambda_at_zero(frames):
    for known in (True, False):
        found = solve(frames, known=known, options=LensOptions(correct=False))
        assert found.method is LensMethod.NONE
        assert found.lens.division_lambda == 0
        assert found.lens.lambda_sigma == 0


def test_a_lens_that_folds_is_refused(frames):
    with pytest.raises(StageError, match="folds the picture"):
        solve(frames, replace(LENS, division_lambda=-1.2))


def test_a_video_without_cable_is_refused_naming_block_and_frame(tmp_path):
    empty = sequence(
        tmp_path, (picture_of_cable(lambda x: x + 1e6, lambda x: x + 1e6, seed=k) for k in range(4))
    )
    for known in (True, False):
        with pytest.raises(StageError, match=r"Block1, frame 0 \(000000\.png\) shows no cable"):
            solve(empty, known=known)
    tolerated = solve(empty, options=LensOptions(need_outline=False))
    assert np.isnan(tolerated.apparent_radius_m)


def test_an_unreadable_frame_is_named(frames, tmp_path):
    broken = tmp_path / "broken.png"
    broken.write_bytes(b"no picture")
    with pytest.raises(StageError, match=r"broken\.png cannot be read"):
        solve(replace(frames, files=(broken, *frames.files[1:])))
    with pytest.raises(StageError, match=r"gone\.png cannot be read"):
        read_colour(tmp_path / "gone.png", "lens")


def test_undistorted_frames_show_straight_edges_on_the_pinhole_canvas(frames, tmp_path):
    events = []
    undistorted, pinhole = undistort_frames(frames, LENS, tmp_path / "undistorted", events.append)
    assert [file.name for file in undistorted.files] == [file.name for file in frames.files]
    assert (undistorted.width_px, undistorted.height_px) == (pinhole.width_px, pinhole.height_px)
    assert read_colour(undistorted.files[0], "lens").shape == (pinhole.height_px, pinhole.width_px, 3)
    assert pinhole.division_lambda == 0
    assert events[-1].done == events[-1].total == 5
    straight = solve(undistorted, replace(pinhole, division_lambda=0.0), known=False)
    assert straight.plumb_lines.bent_px < 0.3
    assert straight.apparent_radius_m == pytest.approx(0.055, abs=2e-4)


def test_grid_picture_is_blue_where_the_lens_puts_the_grid_and_grey_where_it_should_be():
    picture = distortion_grid_picture(LENS, cells=16)
    assert picture.shape == (600, 960, 3)
    ideal = np.array([[480 + 6 * 60.0, 300 + 4 * 60.0]])
    seen = rays_to_pixels(LENS, (ideal - [480, 300]) / 720)
    assert np.linalg.norm(seen - ideal) > 9
    blue = (picture[..., 0].astype(int) - picture[..., 2]) > 60
    x, y = np.floor(seen[0]).astype(int)
    assert blue[y - 1 : y + 2, x - 1 : x + 2].any()
    x, y = np.floor(ideal[0]).astype(int)
    assert not blue[y - 2 : y + 3, x - 2 : x + 3].any()
    grey = np.ptp(picture, axis=2) < 10
    assert (grey & (picture[..., 0] < 220))[y - 1 : y + 2, x - 1 : x + 2].any()
    flat = distortion_grid_picture(replace(LENS, division_lambda=0.0))
    assert ((flat[..., 0].astype(int) - flat[..., 2]) > 60).any()


def test_before_and_after_share_a_canvas_and_the_middle_of_the_picture(frames):
    frame = read_colour(frames.files[0], "lens")
    before, after = before_after_picture(frame, LENS)
    assert before.shape == after.shape
    height, width = before.shape[:2]
    middle = np.s_[height // 2 - 5 : height // 2 + 5, width // 2 - 5 : width // 2 + 5]
    assert np.mean(np.abs(before[middle].astype(int) - after[middle])) < 6
    corner = pixels_to_rays(LENS, [[0.0, 300.0]]) * 720 + [width / 2, height / 2]
    assert (before[height // 2, 0] == 255).all()
    assert 0 <= corner[0, 0] < 1  # the edge's middle just fits


def test_a_grid_over_both_is_straight_after_and_bent_before(frames):
    frame = np.full_like(read_colour(frames.files[0], "lens"), 90)
    plain, gridded = (before_after_picture(frame, LENS, cells) for cells in (0, 12))
    drawn = [(a.astype(int) - b).any(axis=2) for a, b in zip(gridded, plain, strict=True)]
    height, width = plain[0].shape[:2]
    left, top = (width - 960) // 2, (height - 600) // 2
    ideal = np.array([[480 + 80 * 4 + 20.0, 300 + 80 * 3]])  # on a level line, between two upright ones
    x, y = np.floor(ideal[0] + np.array([left, top])).astype(int)
    assert drawn[1][y - 1 : y + 2, x].any()
    assert not drawn[0][y - 2 : y + 3, x].any()
    seen = rays_to_pixels(LENS, (ideal - [480, 300]) / 720)
    x, y = np.floor(seen[0] + np.array([left, top])).astype(int)
    assert drawn[0][y - 1 : y + 2, x].any()
