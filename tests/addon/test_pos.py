"""The panel *POS* takes, shows and writes what the pipeline takes; names are matched as it matches them."""

from dataclasses import replace

import numpy as np
import pytest

from tests.addon.drawn_survey import FRAMES, draw
from tests.addon.shown_run import library, objects, reloaded

import bpy  # isort: skip

HEADER = "name,x,y,z,pitch,yaw,roll"


@pytest.fixture(scope="session")
def survey_file(cabletwin, tmp_path_factory):
    return draw(tmp_path_factory.mktemp("drawn") / "survey")


@pytest.fixture
def state(cabletwin, survey_file):
    assert bpy.ops.cabletwin.survey_open(filepath=str(survey_file)) == {"FINISHED"}
    return bpy.context.scene.cabletwin


def constructed(survey_file, number=0):
    """What the pipeline constructs for every frame of a block."""
    survey = library("pipeline.cable.survey").read_survey(survey_file)
    block, pos = survey.blocks[number], library("pipeline.cable.pos")
    frames = library("pipeline.cable.frames").every_frame(block)
    return block, frames, pos.construct_pos(block, survey.robot, survey.cable, frames, pos.PosOptions())


def path_points(item):
    return np.array([point.co[:3] for point in item.data.splines[0].points])


def write(path, rows):
    path.write_text("\n".join([HEADER, *rows]) + "\n", encoding="utf-8")
    return str(path)


def row(k, name=None):
    return f"{name or k},0.31,{0.015 * k},0.001,0.1,-0.2,0.3"


def test_the_constructed_path_is_the_pipelines_with_the_cameras_axes(state, survey_file):
    assert bpy.ops.cabletwin.pos_show() == {"FINISHED"}
    shown = objects("Camera paths")
    assert sorted(shown) == ["Block1", "Block2"]
    for number, name in enumerate(("Block1", "Block2")):
        poses = constructed(survey_file, number)[2].poses
        item = shown[name]
        np.testing.assert_allclose(path_points(item), poses.centres, atol=1e-6)
        assert len(item.data.splines) == 1 + 3 * FRAMES
        looks = [s for s in item.data.splines if s.material_index == 3]
        along = np.array([np.subtract(s.points[1].co, s.points[0].co)[:3] for s in looks])
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        np.testing.assert_allclose(along, poses.rotations[:, 2], atol=1e-5)
    bpy.ops.cabletwin.pos_show()
    assert len(objects("Camera paths")) == len(shown)


def test_the_written_pos_reads_back_as_constructed_and_can_be_imported(state, survey_file, tmp_path):
    file = tmp_path / "pos.csv"
    assert bpy.ops.cabletwin.pos_write(filepath=str(file)) == {"FINISHED"}
    block, frames, expected = constructed(survey_file)
    read = library("pipeline.cable.pos_file").read_pos(file, block, frames)
    np.testing.assert_allclose(read.poses.centres, expected.poses.centres, atol=1e-12)
    np.testing.assert_allclose(read.sigmas, expected.sigmas, rtol=1e-9)
    assert state.survey.blocks[0].pos_from == "TRAVEL"
    assert bpy.ops.cabletwin.pos_import(filepath=str(file)) == {"FINISHED"}
    assert (state.pos.matched, state.pos.strangers, state.pos.missing, state.pos.problem) == (
        FRAMES,
        0,
        0,
        "",
    )
    assert objects("Camera paths")["Block1"]["cabletwin_pos"] == "CSV"


def test_an_imported_file_is_the_blocks_and_its_path_is_as_the_pipeline_reads_it(
    state, survey_file, tmp_path
):
    file = write(tmp_path / "pos.csv", [row(k) for k in (0, 2, 4, 8)])
    assert bpy.ops.cabletwin.pos_import(filepath=file) == {"FINISHED"}
    survey = library("gather").gather_survey(bpy.context.scene)
    assert str(survey.blocks[0].pos) == file
    assert [(r.name, r.frame, r.state) for r in state.pos.rows][:4] == [
        (str(k), k, "MATCHED") for k in (0, 2, 4, 8)
    ]
    assert (state.pos.matched, state.pos.missing) == (4, FRAMES - 4)
    block, frames, _ = constructed(survey_file)
    kept = replace(
        frames, files=tuple(frames.files[k] for k in (0, 2, 4, 8)), source_indices=np.array([0, 2, 4, 8])
    )
    read = library("pipeline.cable.pos_file").read_pos(tmp_path / "pos.csv", block, kept)
    np.testing.assert_allclose(path_points(objects("Camera paths")["Block1"]), read.poses.centres, atol=1e-6)
    state.survey.blocks[0].pos_from = "TRAVEL"
    assert library("gather").gather_survey(bpy.context.scene).blocks[0].pos is None


def test_rows_without_a_frame_are_listed_and_the_pipelines_refusal_is_told(state, tmp_path):
    bpy.ops.cabletwin.pos_show()
    state.survey.block_index = 1
    rows = [row(0, "img0.png"), row(1, "img1"), row(2, "window.png"), row(3, "img1.png")]
    file = write(tmp_path / "pos.csv", rows)
    assert bpy.ops.cabletwin.pos_import(filepath=file) == {"FINISHED"}
    pos = state.pos
    found = [(r.name, r.frame, r.state) for r in pos.rows]
    assert found[:4] == [
        ("img0.png", 0, "MATCHED"),
        ("img1", 1, "MATCHED"),
        ("window.png", -1, "NO_FRAME"),
        ("img1.png", -2, "TAKEN"),
    ]
    assert found[4:] == [("–", k, "NO_ROW") for k in range(2, FRAMES)]
    assert (pos.block, pos.matched, pos.strangers, pos.missing) == ("Block2", 2, 2, FRAMES - 2)
    assert "line 4 names window.png, which is no frame of Block2" in pos.problem
    assert list(objects("Camera paths")) == ["Block1"]
    write(tmp_path / "pos.csv", rows[:2])
    assert bpy.ops.cabletwin.pos_check() == {"FINISHED"}
    assert (pos.matched, pos.strangers, pos.problem) == (2, 0, "")


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("name,x,y\n1,2,3\n", "has no column z; begin it with name,x,y,z,pitch,yaw,roll"),
        (f"{HEADER}\n0,a,0,0,0,0,0\n", 'line 2: x is "a"; give a number'),
        ("", "is empty; give the columns"),
    ],
)
def test_a_file_that_cannot_be_read_is_refused_and_changes_nothing(state, tmp_path, text, sentence):
    (tmp_path / "pos.csv").write_text(text)
    with pytest.raises(RuntimeError, match=sentence):
        bpy.ops.cabletwin.pos_import(filepath=str(tmp_path / "pos.csv"))
    assert (state.survey.blocks[0].pos, state.survey.blocks[0].pos_from, len(state.pos.rows)) == (
        "",
        "TRAVEL",
        0,
    )


def test_images_without_order_have_no_constructed_path(state):
    state.survey.blocks[1].ordered = False
    state.survey.synchronised = False
    bpy.ops.cabletwin.pos_show()
    assert list(objects("Camera paths")) == ["Block1"]
    state.survey.block_index = 1
    with pytest.raises(RuntimeError, match="the places of Block2 are found from its pictures"):
        bpy.ops.cabletwin.pos_write(filepath="never.csv")


def test_paths_of_two_scenes_are_apart(state, survey_file):
    first, second = bpy.context.scene, bpy.data.scenes.new("Other")
    bpy.ops.cabletwin.pos_show()
    with bpy.context.temp_override(scene=second):
        bpy.ops.cabletwin.survey_open(filepath=str(survey_file))
        bpy.ops.cabletwin.survey_block_remove()
        bpy.ops.cabletwin.pos_show()
    find = library("results.collections").existing
    assert [len(find(scene, "Camera paths").objects) for scene in (first, second)] == [2, 1]


def test_the_match_survives_save_and_reload(state, tmp_path):
    bpy.ops.cabletwin.pos_import(filepath=write(tmp_path / "pos.csv", [row(k) for k in range(3)]))
    before = [(r.name, r.frame, r.state) for r in state.pos.rows]
    state = reloaded(tmp_path / "kept.blend")
    assert [(r.name, r.frame, r.state) for r in state.pos.rows] == before
    assert (state.pos.matched, state.survey.blocks[0].pos_from) == (3, "CSV")
    assert objects("Camera paths")["Block1"]["cabletwin_pos"] == "CSV"
