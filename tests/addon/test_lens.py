"""The panel *Lens* shows what the pipeline's own correction shows, and finds what its own estimate finds."""

import cv2
import numpy as np
import pytest

from tests.addon.drawn_survey import FRAMES, draw
from tests.addon.shown_run import library, reloaded

import bpy  # isort: skip


@pytest.fixture(scope="session")
def survey_file(cabletwin, tmp_path_factory):
    return draw(tmp_path_factory.mktemp("drawn") / "survey")


@pytest.fixture
def state(cabletwin, survey_file):
    assert bpy.ops.cabletwin.survey_open(filepath=str(survey_file)) == {"FINISHED"}
    return bpy.context.scene.cabletwin


def pixels(image):
    """(h, w, 3) uint8 blue-green-red, first row on top."""
    width, height = image.size
    values = np.empty(width * height * 4, dtype=np.float32)
    image.pixels.foreach_get(values)
    rgba = np.round(values.reshape(height, width, 4)[::-1] * 255).astype(np.uint8)
    return rgba[..., 2::-1]


def expected(state, division_lambda, frame=0, cells=0, block=0):
    """Before and after, by the pipeline."""
    from dataclasses import replace

    read = library("pipeline.cable.survey").read_survey
    described = read(library("gather").survey_path(state.survey)).blocks[block]
    image = library("pipeline.cable.sources").read_frame(described, frame).image
    spec = replace(described.lens_spec, division_lambda=division_lambda)
    lens = replace(described, lens_spec=spec).lens(image.shape[1], image.shape[0])
    return library("pipeline.cable.lens_pictures").before_after_picture(image, lens, cells)


def turn_of_the_loop():
    """What Blender's loop does next, where there is one."""
    due = library("results.lens_view").refresh_due
    assert bpy.app.timers.is_registered(due)
    bpy.app.timers.unregister(due)
    due()


def same(view, pictures):
    for image, picture in zip((view.before, view.after), pictures, strict=True):
        np.testing.assert_array_equal(pixels(image), picture)


def test_the_preview_is_the_librarys_and_follows_lambda_frame_grid_and_block(state):
    view, block = state.lens, state.survey.blocks[0]
    assert bpy.ops.cabletwin.lens_show() == {"FINISHED"}
    assert (view.before.name, view.after.name) == ("CableTwin lens: before", "CableTwin lens: after")
    assert view.frames == FRAMES
    same(view, expected(state, -0.1))
    images = (view.before, view.after)
    for key, value in (("division_lambda", -0.04), ("division_lambda", 0.03)):
        setattr(block, key, value)
        turn_of_the_loop()
        same(view, expected(state, value))
    view.frame, view.use_grid, view.grid_cells = 5, True, 8
    turn_of_the_loop()
    same(view, expected(state, 0.03, frame=5, cells=8))
    state.survey.block_index = 1
    turn_of_the_loop()
    same(view, expected(state, 0.0, frame=5, cells=8, block=1))
    assert (view.before, view.after) == images


def test_the_edges_of_the_cable_are_straight_only_with_the_right_lambda(state):
    bpy.ops.cabletwin.lens_show()
    state.survey.blocks[0].division_lambda = -0.04
    turn_of_the_loop()

    def sag(image):
        """How far the upper edge in the middle lies above its place at the sides."""
        dark = pixels(image).astype(int).sum(axis=2) < 450
        width = dark.shape[1]
        row = [
            np.argmax(dark[: dark.shape[0] // 2, x : x + 20].mean(axis=1) > 0.5)
            for x in (60, width // 2, width - 80)
        ]
        return (row[0] + row[2]) / 2 - row[1]

    assert sag(state.lens.before) >= 2
    assert abs(sag(state.lens.after)) <= 1


def test_a_lens_that_folds_is_told_and_the_picture_stays_until_it_is_right_again(state):
    bpy.ops.cabletwin.lens_show()
    before = pixels(state.lens.after)
    state.survey.blocks[0].division_lambda = -1.5
    turn_of_the_loop()
    assert "division_lambda = -1.5 (half-diagonal) folds the picture" in state.lens.problem
    np.testing.assert_array_equal(pixels(state.lens.after), before)
    state.survey.blocks[0].division_lambda = -0.1
    turn_of_the_loop()
    assert state.lens.problem == ""


def test_a_block_without_a_video_is_told_in_one_sentence(state):
    state.survey.blocks[0].source = ""
    with pytest.raises(RuntimeError, match=r"survey: block\[Block1\]\.source is empty; name a file\."):
        bpy.ops.cabletwin.lens_show()
    assert state.lens.before is None


def test_two_scenes_have_each_their_own_preview(state, survey_file):
    first = bpy.context.scene
    bpy.ops.cabletwin.lens_show()
    second = bpy.data.scenes.new("Other")
    with bpy.context.temp_override(scene=second):
        bpy.ops.cabletwin.survey_open(filepath=str(survey_file))
        second.cabletwin.survey.blocks[0].division_lambda = 0.05
        bpy.ops.cabletwin.lens_show()
    same(second.cabletwin.lens, expected(second.cabletwin, 0.05))
    same(first.cabletwin.lens, expected(first.cabletwin, -0.1))


def test_lambda_is_estimated_as_the_library_estimates_it(state, survey_file):
    estimate = library("pipeline.cable.lens_estimate").estimate_lens
    frames, lens = (library(f"pipeline.cable.{name}") for name in ("frames", "lens"))
    survey = library("pipeline.cable.survey").read_survey(survey_file)
    state.survey.blocks[1].source = "/nowhere"  # another camera's video is none of this one's business
    assert bpy.ops.cabletwin.lens_estimate() == {"FINISHED"}
    block = state.survey.blocks[0]
    found = estimate(survey, "Block1", frames.FrameOptions(), lens.LensOptions()).lens
    assert block.division_lambda == pytest.approx(found.division_lambda, rel=1e-6)
    assert block.lambda_sigma == pytest.approx(found.lambda_sigma, rel=1e-6)
    assert (block.lambda_from, block.lambda_known) == ("EDGES", True)
    assert block.division_lambda == pytest.approx(-0.04, abs=0.004)
    assert (state.survey.blocks[1].division_lambda, state.survey.blocks[1].lambda_from) == (0.0, "HAND")
    bpy.ops.cabletwin.survey_lens_to_all()
    assert state.survey.blocks[1].lambda_sigma == block.lambda_sigma > 0
    block.division_lambda = -0.03
    assert (block.lambda_sigma, block.lambda_from) == (0.0, "HAND")


def test_an_estimate_keeps_its_sigma_in_the_file_and_in_what_a_run_starts_from(state, tmp_path):
    assert bpy.ops.cabletwin.lens_estimate() == {"FINISHED"}
    block, path = state.survey.blocks[0], tmp_path / "kept.toml"
    found, sigma = block.division_lambda, block.lambda_sigma
    assert bpy.ops.cabletwin.survey_save(filepath=str(path)) == {"FINISHED"}
    read = library("pipeline.cable.survey").read_survey(path).blocks[0]
    assert read.lens_spec.lambda_sigma == pytest.approx(sigma, rel=1e-6)
    assert read.lens(320, 200).lambda_sigma == read.lens_spec.lambda_sigma < 0.005
    assert read.lens_spec.division_lambda == pytest.approx(found, rel=1e-6)
    assert bpy.ops.cabletwin.survey_open(filepath=str(path)) == {"FINISHED"}
    assert state.survey.blocks[0].lambda_sigma == pytest.approx(sigma, rel=1e-6)
    assert library("gather").gather_survey(bpy.context.scene).blocks[0] == read  # to the last digit
    assert bpy.ops.cabletwin.lens_estimate() == {"FINISHED"}  # a second look is as good as the first
    assert state.survey.blocks[0].lambda_sigma == pytest.approx(sigma, rel=1e-4)


def test_a_trusted_focal_length_leaves_the_estimate_to_each_run(state):
    block = state.survey.blocks[0]
    block.calibrated = True
    assert bpy.ops.cabletwin.lens_estimate() == {"FINISHED"}
    assert (block.lambda_from, block.lambda_known) == ("EDGES", False)
    lens = library("gather").lens_values(block)
    assert (lens["division_lambda"], lens["lambda_sigma"], lens["calibrated"]) == (None, None, True)


def test_a_sigma_is_typed_and_forgotten_with_what_it_belonged_to(state):
    block, lens_values = state.survey.blocks[0], library("gather").lens_values
    block.lambda_known, block.calibrated = True, False
    assert lens_values(block)["lambda_sigma"] is None
    block.lambda_sigma = 0.004
    assert lens_values(block)["lambda_sigma"] == pytest.approx(0.004)
    block.lambda_radius = "half-width"  # typed: it was meant in that unit
    assert lens_values(block)["lambda_sigma"] == pytest.approx(0.004)
    block.calibrated = True
    assert lens_values(block)["lambda_sigma"] is None
    block.calibrated, block.lambda_from = False, "EDGES"
    block.lambda_radius = "half-diagonal"  # found in the other unit
    assert (block.lambda_sigma, block.lambda_from) == (0.0, "HAND")


def test_every_block_is_estimated_from_its_own_video(state):
    assert bpy.ops.cabletwin.lens_estimate(every=True) == {"FINISHED"}
    assert [b.lambda_from for b in state.survey.blocks] == ["EDGES", "EDGES"]
    assert all(b.division_lambda == pytest.approx(-0.04, abs=0.004) for b in state.survey.blocks)


def test_a_video_that_cannot_be_read_fails_with_the_pipelines_sentence(state, tmp_path):
    broken = tmp_path / "broken.mp4"
    broken.write_bytes(b"nothing")
    state.survey.blocks[0].source = str(broken)
    with pytest.raises(RuntimeError, match=r"broken\.mp4 cannot be opened as a video"):
        bpy.ops.cabletwin.lens_estimate()
    assert state.survey.blocks[0].lambda_known
    assert not bpy.context.window_manager.cabletwin_job.running


def test_a_chessboard_gives_a_calibrated_lens(state, tmp_path):
    from tests.cable.test_chessboard import POSES, draw_board

    with pytest.raises(RuntimeError, match="no pictures of a chessboard are chosen"):
        bpy.ops.cabletwin.lens_chessboard()
    for i, (turn, shift) in enumerate(POSES):
        cv2.imwrite(str(tmp_path / f"view{i}.png"), draw_board(turn, shift))
    state.lens.board_folder = str(tmp_path)
    state.lens.board_corners = (12, 9)
    with pytest.raises(RuntimeError, match=r"no picture in .* shows a board of 12x9 inner corners"):
        bpy.ops.cabletwin.lens_chessboard()
    state.lens.board_corners = (9, 6)
    assert bpy.ops.cabletwin.lens_chessboard() == {"FINISHED"}
    found = library("pipeline.cable.chessboard").calibrate_chessboard(tmp_path, "9x6").lens
    block = state.survey.blocks[0]
    assert (block.focal_in, block.lambda_known, block.calibrated, block.lambda_from) == (
        "PX",
        True,
        True,
        "BOARD",
    )
    assert block.focal_px == pytest.approx(found.focal_px, rel=1e-6)
    assert tuple(block.principal_point_px) == pytest.approx(found.principal_point_px, rel=1e-6)
    assert block.division_lambda == pytest.approx(found.division_lambda, rel=1e-6)
    assert block.lambda_sigma == pytest.approx(found.lambda_sigma, rel=1e-6)
    assert not state.survey.blocks[1].calibrated


def test_state_and_preview_survive_save_and_reload(state, tmp_path):
    bpy.ops.cabletwin.lens_show()
    state.lens.frame, state.lens.use_grid = 3, True
    state = reloaded(tmp_path / "kept.blend")
    assert (state.lens.frame, state.lens.use_grid, state.lens.frames) == (3, True, FRAMES)
    assert state.lens.after.name == "CableTwin lens: after"
    turn_of_the_loop()
    same(state.lens, expected(state, -0.1, frame=3, cells=12))


def test_undo_of_lambda_brings_the_picture_back(state):
    bpy.ops.cabletwin.lens_show()
    bpy.ops.ed.undo_push(message="before")
    state.survey.blocks[0].division_lambda = 0.05
    turn_of_the_loop()
    bpy.ops.ed.undo_push(message="after")
    bpy.ops.ed.undo()
    state = bpy.context.scene.cabletwin
    assert state.survey.blocks[0].division_lambda == pytest.approx(-0.1)
    turn_of_the_loop()
    same(state.lens, expected(state, -0.1))
