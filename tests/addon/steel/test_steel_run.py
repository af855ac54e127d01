"""A steel survey reconstructed from Blender: the command line's figures and sentences."""

import json
import shutil
import sys
import threading
import time

import bpy
import pytest

from tests.addon.shown_run import library
from tests.addon.steel.scene import cable_run, job, named, told


@pytest.fixture
def scene(surveyed, tmp_path):
    steel = bpy.context.scene.cabletwin.steel
    steel.survey, steel.run_folder = str(surveyed / "survey.toml"), str(tmp_path / "run")
    return steel


def test_reconstructing_gives_the_command_lines_figures_and_shows_them(scene, run, tmp_path):
    assert bpy.ops.cabletwin.steel_run() == {"FINISHED"}
    assert told(tmp_path / "run")["stations"] == told(run)["stations"]
    assert len(named("Targets")) == len(told(run)["targets"])
    assert scene.folder == str(tmp_path / "run")
    assert not job().running


def test_every_stage_of_the_run_has_a_name(scene, tmp_path):
    assert bpy.ops.cabletwin.steel_run() == {"FINISHED"}
    lines = (tmp_path / "run" / "log.jsonl").read_text().splitlines()
    stages = {json.loads(line)["stage"] for line in lines if line.startswith("{")}
    assert stages
    assert stages <= set(library("panels.steel")._STAGE_NAMES)


def test_a_failure_is_the_pipelines_sentence(scene, surveyed, tmp_path):
    copied = shutil.copytree(surveyed, tmp_path / "spoiled")
    (copied / "targets" / "S05.csv").write_text("name,x,y,z\nT01,1,2\n")
    scene.survey = str(copied / "survey.toml")
    with pytest.raises(RuntimeError, match=r"S05"):
        bpy.ops.cabletwin.steel_run()
    assert "S05" in job().failure
    assert "\n" not in job().failure
    assert (job().kind, job().running) == ("steel", False)


def test_a_bad_survey_is_refused_before_anything_starts(scene, tmp_path):
    (tmp_path / "cable.toml").write_text('format = 1\nname = "x"\n')
    scene.survey = str(tmp_path / "cable.toml")
    with pytest.raises(RuntimeError, match="kind is missing"):
        bpy.ops.cabletwin.steel_run()
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("key", ["survey", "run_folder"])
def test_what_is_not_chosen_is_asked_for(scene, key):
    scene.property_unset(key)
    with pytest.raises(RuntimeError, match="is chosen; choose one in the panel Steel structure"):
        bpy.ops.cabletwin.steel_run()


def test_the_run_of_a_cable_is_not_written_over(scene, tmp_path):
    cable_run(tmp_path / "run")
    with pytest.raises(RuntimeError, match="holds the run of a cable"):
        bpy.ops.cabletwin.steel_run()
    assert (tmp_path / "run" / "products" / "all-frames.npz").exists()


def test_cancelling_takes_at_most_two_seconds_and_shows_nothing(scene, tmp_path):
    """The word is left as the button leaves it, from beside the waiting operator."""
    asked = []

    def ask():
        deadline = time.monotonic() + 60
        while not (job().running and list((tmp_path / "run").glob("products/*.stamp"))):
            assert time.monotonic() < deadline
            time.sleep(0.02)
        asked.append(time.monotonic())
        job().cancelling = True

    other = threading.Thread(target=ask)
    other.start()
    assert bpy.ops.cabletwin.steel_run() == {"CANCELLED"}
    took = time.monotonic() - asked[0]
    other.join()
    assert took < 2.0
    assert not (tmp_path / "run" / "report.json").exists()
    assert not job().running
    assert named("Targets") == {}
    assert bpy.ops.cabletwin.steel_run() == {"FINISHED"}


def test_one_job_at_a_time(scene):
    job().running = True
    assert not bpy.ops.cabletwin.steel_run.poll()
    job().running = False
    assert bpy.ops.cabletwin.steel_run.poll()


def test_a_survey_proposes_the_folder_beside_it(tmp_path):
    steel = bpy.context.scene.cabletwin.steel
    steel.survey = str(tmp_path / "survey.toml")
    assert steel.run_folder == str(tmp_path / "run")


def test_every_cloud_format_can_be_read_from_the_installed_extension(cabletwin):
    jobs, python = library("jobs"), library("library").python_executable()
    words = "import laspy, lazrs, plyfile, pye57, small_gicp; print(pye57.__file__)"
    home = library("library").library_path()[1]
    outcome = jobs.Job([str(python), "-c", words], home.parent / "log.jsonl").outcome()
    assert outcome.failure == ""
    assert outcome.said.startswith(str(home))


def test_no_library_of_scans_came_into_this_process(shown):
    assert {"laspy", "lazrs", "pye57", "small_gicp", "pycolmap"}.isdisjoint(sys.modules)
