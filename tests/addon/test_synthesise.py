"""The area *Synthesise*: cable and ring from the library, SPEC.toml as synth reads it, a survey rendered."""

import importlib
import json
import math
import tomllib
from pathlib import Path

import bpy
import numpy as np
import pytest

from pipeline.cable.survey import read_survey
from synth.motion import block_poses
from synth.spec import Cable, Defect, DefectKind, Fillet, Robot, Sensor, Spec, Station
from synth.spec_reader import parse_spec
from tests.addon.conftest import MODULE


@pytest.fixture
def scene(cabletwin):
    return bpy.context.scene


@pytest.fixture
def settings(scene):
    return scene.cabletwin.synthesise


@pytest.fixture
def cable(scene):
    assert bpy.ops.cabletwin.synthesise_add_cable() == {"FINISHED"}
    return scene.cabletwin.synthesise.cable


def room(name):
    """A module of the installed add-on."""
    return importlib.import_module(f"{MODULE}.{name}")


def put(cable, values):
    """Set inputs of the cable's modifier, as a person does."""
    found = room("synthetic_cable")
    found.write_inputs(cable, found.asset_modifier(cable, "cable"), values)


def written(scene):
    """What synth reads of what the scene writes."""
    return parse_spec(tomllib.loads(room("gather_spec").spec_toml(room("gather_spec").gather_spec(scene))))


def thumbnails(cable, settings, folder):
    put(cable, {("", "Travel"): 0.04, ("", "Margin"): 0.1})
    put(cable, {("Stations", "Stations"): 1, ("Stations", "A position"): 0.02})
    settings.cameras, settings.frames, settings.texel_mm, settings.samples = 2, 3, 1, 2
    settings.focal_px, settings.width_px, settings.height_px = 120, 160, 100
    settings.folder = str(folder)


def test_the_cable_of_the_library_is_the_usual_one_of_synth(scene, cable):
    assert cable.name in scene.objects
    assert cable.asset_data is None
    plain = written(scene)
    assert plain.cable == Cable()
    assert plain.robot == Robot()
    assert plain.sensor == Sensor()


def test_synth_reads_what_the_cable_and_the_panel_say(scene, cable, settings):
    put(
        cable,
        {
            ("", "Travel"): 0.5,
            ("", "Margin"): 0.25,
            ("", "Ovality (mm)"): 0.8,
            ("", "Ovality angle"): math.radians(33),
            ("Bow", "Bow (mm)"): 3.0,
            ("Stations", "Stations"): 2,
            ("Stations", "A diameter (mm)"): 111.4,
            ("Stations", "B diameter (mm)"): 110.8,
            ("Defect 1", "Defect 1"): True,
            ("Defect 2", "Defect 2"): True,
            ("Defect 2", "Height (mm)"): -1.2,
            ("Defect 2", "Azimuth"): math.radians(210),
        },
    )
    settings.name, settings.seed, settings.kind, settings.dirt = '斜拉索 "7"', 7, "painted", 0.9
    settings.cameras, settings.standoff, settings.sway = 3, 0.32, math.radians(0.2)
    settings.division_lambda, settings.noise, settings.travel_in_image = -0.15, False, "down"
    spec = written(scene)
    assert (spec.name, spec.seed, spec.cable.material.dirt) == ('斜拉索 "7"', 7, 0.9)
    assert spec.cable.station == (
        Station(name="A", position_m=0.1, diameter_mm=111.4),
        Station(name="B", position_m=0.19, diameter_mm=110.8),
    )
    assert spec.cable.defect == (
        Defect(kind=DefectKind.BULGE, height_mm=1.5, position_m=0.15, azimuth_deg=45),
        Defect(kind=DefectKind.DENT, height_mm=1.2, position_m=0.3, azimuth_deg=210),
    )
    assert (spec.cable.ovality_angle_deg, spec.cable.bow_mm, spec.cable.margin_m) == (33.0, 3.0, 0.25)
    robot = Robot(cameras=3, standoff_m=0.32, travel_m=0.5, sway_deg=0.2, travel_in_image="down")
    assert spec.robot == robot
    assert (spec.lens.division_lambda, spec.sensor.full_well_e, spec.sensor.read_noise_e) == (-0.15, 0, 0)


def test_ribs_are_written_only_when_they_are_on(scene, cable):
    assert written(scene).cable.fillet is None
    put(cable, {("Fillet", "Fillet"): True, ("Fillet", "Pitch"): 0.35})
    assert written(scene).cable.fillet == Fillet(pitch_m=0.35)


def test_a_cable_that_was_moved_is_refused(scene, cable, settings, tmp_path):
    settings.folder = str(tmp_path)
    cable.location.x = 0.1
    bpy.context.view_layer.update()
    with pytest.raises(RuntimeError, match="clear its location, rotation and scale"):
        bpy.ops.cabletwin.synthesise_render()
    assert list(tmp_path.iterdir()) == []


def test_without_a_cable_or_a_folder_nothing_is_rendered(scene, settings):
    assert not bpy.ops.cabletwin.synthesise_render.poll()
    bpy.ops.cabletwin.synthesise_add_cable()
    assert bpy.ops.cabletwin.synthesise_render.poll()
    with pytest.raises(RuntimeError, match="no survey folder is chosen"):
        bpy.ops.cabletwin.synthesise_render()


def test_a_dragged_in_cable_is_found_without_being_chosen(scene, cable, settings):
    settings.cable = None
    assert room("synthetic_cable").scene_cable(scene) == cable
    assert room("synthetic_cable").scene_cable(bpy.data.scenes.new("Other")) is None


def test_the_ring_shows_the_cameras_that_synth_will_film_with(scene, cable, settings):
    assert bpy.ops.cabletwin.synthesise_add_ring() == {"FINISHED"}
    for cameras, direction in ((4, "right"), (6, "down"), (2, "left")):
        settings.cameras, settings.standoff, settings.travel_in_image = cameras, 0.35, direction
        spec = written(scene)
        for frame in (0, spec.robot.frames - 1):
            scene.frame_set(frame + 1)
            for number, poses in enumerate(block_poses(spec)):
                found = np.array(cameras_of(scene)[number].matrix_world)
                blender = found[:3, :3] @ np.diag([1, -1, -1])
                assert blender == pytest.approx(poses.rotations[frame].T, abs=1e-5)
                centre = -poses.rotations[frame].T @ poses.translations[frame]
                assert found[:3, 3] == pytest.approx(centre, abs=1e-5)
        assert len(cameras_of(scene)) == cameras
        assert len([o for o in scene.objects if o.type == "LIGHT"]) == cameras


def cameras_of(scene):
    return sorted((o for o in scene.objects if o.type == "CAMERA"), key=lambda o: o["cabletwin_number"])


def test_a_second_ring_takes_the_place_of_the_first(scene):
    bpy.ops.cabletwin.synthesise_add_ring()
    bpy.ops.cabletwin.synthesise_add_ring()
    assert len(cameras_of(scene)) == 4


def test_strengths_show_on_the_cable(cable, settings):
    settings.dirt = 0.25
    node = cable.material_slots[0].material.node_tree.nodes["Sheath"]
    assert node.inputs["Dirt"].default_value == pytest.approx(0.25)


def test_the_library_is_named_to_blender_once_and_only_when_asked(cabletwin):
    libraries = bpy.context.preferences.filepaths.asset_libraries
    assert "CableTwin" not in libraries
    assert bpy.ops.cabletwin.synthesise_add_library() == {"FINISHED"}
    assert (Path(libraries["CableTwin"].path) / "blender_assets.cats.txt").is_file()
    assert not bpy.ops.cabletwin.synthesise_add_library.poll()
    libraries.remove(libraries["CableTwin"])


def test_a_survey_is_rendered_and_opened_with_its_truth(scene, cable, settings, tmp_path):
    thumbnails(cable, settings, tmp_path / "survey")
    expected = written(scene)
    assert bpy.ops.cabletwin.synthesise_render() == {"FINISHED"}
    survey = scene.cabletwin.survey
    assert survey.filepath == str(tmp_path / "survey" / "survey.toml")
    assert [block.name for block in survey.blocks] == ["Block1", "Block2"]
    assert [(s.name, round(s.position, 6)) for s in survey.stations] == [("A", 0.02)]
    truth = json.loads(Path(scene.cabletwin.run.truth).read_text())
    assert parse_spec(json.loads(json.dumps(plain(truth["spec"])))) == expected
    assert len(truth["poses"]["Block2"]) == 3
    assert read_survey(Path(survey.filepath)).robot.standoff_m == pytest.approx(0.3)
    assert not bpy.context.window_manager.cabletwin_job.running


def plain(spec):
    """A specification as truth.json has it, without the keys that TOML would leave out."""
    if isinstance(spec, dict):
        return {key: plain(value) for key, value in spec.items() if value is not None}
    return [plain(value) for value in spec] if isinstance(spec, list) else spec


def test_what_synth_refuses_is_told_in_its_own_sentence(scene, cable, settings, tmp_path):
    thumbnails(cable, settings, tmp_path)
    settings.standoff = 0.06
    with pytest.raises(RuntimeError, match=r"spec: robot\.standoff_m is 0\.06 m; give at least"):
        bpy.ops.cabletwin.synthesise_render()
    assert not (tmp_path / "survey.toml").exists()
    assert bpy.context.window_manager.cabletwin_job.failure.startswith("spec: robot.standoff_m")


def test_the_cable_survives_save_and_reload(cable, settings, tmp_path):
    put(cable, {("", "Diameter (mm)"): 160.0, ("Fillet", "Fillet"): True})
    settings.frames = 31
    before = written(bpy.context.scene)
    file = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(file))
    bpy.ops.wm.open_mainfile(filepath=str(file))
    after = written(bpy.context.scene)
    assert isinstance(after, Spec)
    assert after == before
    assert (after.cable.diameter_mm, after.robot.frames) == (160.0, 31)


def test_the_estimate_grows_with_frames_and_shutter(scene, cable, settings):
    seconds = room("render_cost").render_seconds
    plain_s = seconds(scene)
    assert 60 < plain_s < 600  # the demo survey: about three minutes
    settings.frames = 48
    assert 1.6 * plain_s < seconds(scene) < 2.1 * plain_s
    settings.motion_blur_mm, settings.readout_share = 1.0, 0.2
    assert seconds(scene) > 8 * plain_s


def test_rendering_leaves_the_packages_of_this_blender_alone(cabletwin, scene, cable, settings, tmp_path):
    wheels = room("library").library_path()[1]
    before = sorted(path.name for path in wheels.iterdir())
    assert "cv2" in before
    thumbnails(cable, settings, tmp_path)
    settings.cameras, settings.frames = 1, 2
    assert bpy.ops.cabletwin.synthesise_render() == {"FINISHED"}
    assert sorted(path.name for path in wheels.iterdir()) == before
