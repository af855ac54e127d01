"""A survey in Blender is the survey in its file: opened, edited, saved, undone, in one scene or two."""

import math
import tomllib

import bpy
import pytest

from pipeline.cable.survey import read_survey
from tests.addon.shown_run import library, named, reloaded


@pytest.fixture
def file(rendered):
    return rendered / "survey.toml"


@pytest.fixture
def opened(file):
    assert bpy.ops.cabletwin.survey_open(filepath=str(file)) == {"FINISHED"}
    return bpy.context.scene


def gathered(scene):
    return library("gather").gather_survey(scene)


def test_what_was_opened_is_gathered_to_the_last_digit(opened, file):
    assert repr(gathered(opened)) == repr(read_survey(file))


def test_digits_beyond_32_bits_survive(rendered, tmp_path):
    text = (rendered / "survey.toml").read_text().replace('source = "', f'source = "{rendered.as_posix()}/')
    (tmp_path / "survey.toml").write_text(text.replace("travel_m = 0.3", "travel_m = 0.30012345678901"))
    assert bpy.ops.cabletwin.survey_open(filepath=str(tmp_path / "survey.toml")) == {"FINISHED"}
    assert gathered(bpy.context.scene).cable.travel_m == 0.30012345678901


def test_a_value_typed_in_counts_as_it_was_typed(opened):
    opened.cabletwin.survey.travel = 0.4567
    opened.cabletwin.survey.blocks[1].angle = math.radians(91.5)
    survey = gathered(opened)
    assert survey.cable.travel_m == 0.4567
    assert survey.blocks[1].angle_deg == 91.5


def test_what_is_saved_is_what_is_read(opened, tmp_path):
    opened.cabletwin.survey.name = "塔索-07"
    opened.cabletwin.survey.stations[0].position = 0.123
    path = tmp_path / "copy.toml"
    assert bpy.ops.cabletwin.survey_save(filepath=str(path)) == {"FINISHED"}
    survey = read_survey(path)
    assert repr(survey) == repr(gathered(opened))
    assert survey.name == "塔索-07"
    assert survey.cable.stations[0].position_m == 0.123


def test_options_that_no_property_holds_stay_in_the_file(rendered, tmp_path):
    text = (rendered / "survey.toml").read_text().replace('source = "', f'source = "{rendered.as_posix()}/')
    (tmp_path / "survey.toml").write_text(text + "\n[options.measure]\nslice_mm = 12.5\n")
    assert bpy.ops.cabletwin.survey_open(filepath=str(tmp_path / "survey.toml")) == {"FINISHED"}
    assert bpy.ops.cabletwin.survey_save(filepath=str(tmp_path / "again.toml")) == {"FINISHED"}
    assert tomllib.loads((tmp_path / "again.toml").read_text())["options"] == {"measure": {"slice_mm": 12.5}}


def test_a_bad_file_is_refused_with_the_pipelines_sentence_and_changes_nothing(opened, tmp_path):
    (tmp_path / "bad.toml").write_text("format = 1\nname = 'x'\ntravle = 3\n")
    with pytest.raises(RuntimeError, match="travle"):
        bpy.ops.cabletwin.survey_open(filepath=str(tmp_path / "bad.toml"))
    assert len(opened.cabletwin.survey.blocks) == 4


def test_an_impossible_value_is_refused_when_saving(opened, file, tmp_path):
    opened.cabletwin.survey.standoff = 0.01
    with pytest.raises(RuntimeError, match=r"robot\.standoff_m = 0\.01 puts the cameras inside"):
        bpy.ops.cabletwin.survey_save(filepath=str(tmp_path / "no.toml"))
    assert not (tmp_path / "no.toml").exists()


def test_a_new_survey_has_its_cameras_at_equal_angles():
    bpy.ops.cabletwin.survey_new(cameras=3)
    blocks = bpy.context.scene.cabletwin.survey.blocks
    assert [round(math.degrees(b.angle)) for b in blocks] == [0, 120, 240]
    assert [b.name for b in blocks] == ["Block1", "Block2", "Block3"]


def test_the_sketch_follows_the_angle(opened):
    def place():
        return named("Setup")["Block2"].matrix_world.translation

    assert tuple(round(v, 6) for v in place()) == (0.0, 0.0, -0.3)
    opened.cabletwin.survey.blocks[1].angle = math.pi
    assert tuple(round(v, 6) for v in place()) == (-0.3, 0.0, 0.0)


def test_a_sketched_camera_looks_at_the_axis_with_the_travel_to_its_right(opened):
    camera = named("Setup")["Block3"].matrix_world.to_3x3()
    assert tuple(round(v, 6) for v in -camera.col[2]) == (1.0, 0.0, 0.0)
    assert tuple(round(v, 6) for v in camera.col[0]) == (0.0, 1.0, 0.0)


def test_blocks_and_stations_are_added_and_removed(opened):
    survey = opened.cabletwin.survey
    bpy.ops.cabletwin.survey_station_add()
    bpy.ops.cabletwin.survey_block_add()
    assert (len(survey.stations), len(survey.blocks)) == (5, 5)
    bpy.ops.cabletwin.survey_block_remove()
    bpy.ops.cabletwin.survey_station_remove()
    assert [b.name for b in survey.blocks] == ["Block1", "Block2", "Block3", "Block4"]
    assert len(survey.stations) == 4


def test_one_lens_is_copied_to_all(opened):
    survey = opened.cabletwin.survey
    survey.block_index = 2
    survey.blocks[2].focal_px = 801.25
    bpy.ops.cabletwin.survey_lens_to_all()
    assert [b.focal_px for b in survey.blocks] == [801.25] * 4


def test_a_truth_beside_it_is_proposed_only_if_it_knows_a_station(opened, rendered, tmp_path):
    assert opened.cabletwin.run.truth == str(rendered / "truth.json")
    text = (rendered / "survey.toml").read_text().replace('source = "', f'source = "{rendered.as_posix()}/')
    for name in "ABCD":
        text = text.replace(f'name = "{name}"', f'name = "S{name}"')
    (tmp_path / "survey.toml").write_text(text)
    (tmp_path / "truth.json").write_bytes((rendered / "truth.json").read_bytes())
    assert bpy.ops.cabletwin.survey_open(filepath=str(tmp_path / "survey.toml")) == {"FINISHED"}
    assert opened.cabletwin.run.truth == ""


def test_it_survives_save_and_reload(opened, tmp_path):
    before = repr(gathered(opened))
    reloaded(tmp_path / "scene.blend")
    assert repr(gathered(bpy.context.scene)) == before
    assert set(named("Setup")) >= {"Block1", "Block2", "Block3", "Block4"}


def test_two_scenes_hold_two_surveys(opened):
    bpy.ops.scene.new(type="EMPTY")
    other = bpy.context.scene
    bpy.ops.cabletwin.survey_new(cameras=2)
    assert (len(opened.cabletwin.survey.blocks), len(other.cabletwin.survey.blocks)) == (4, 2)
    own = library("results.collections").own_objects
    assert own(opened).isdisjoint(own(other))
