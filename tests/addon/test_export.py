"""What is exported is what the run wrote."""

import shutil

import bpy
import pytest

FILES = {
    "report": "report.html",
    "diameters": "diameters.csv",
    "model_glb": "model.glb",
    "model_ply": "model.ply",
    "cloud": "cloud.ply",
    "unrolled": "unrolled.png",
}


@pytest.fixture
def scene(finished):
    bpy.context.scene.cabletwin.run.folder = str(finished.folder)
    assert bpy.ops.cabletwin.results_open() == {"FINISHED"}
    return bpy.context.scene


def test_the_chosen_files_are_copied_and_no_others(scene, finished, tmp_path):
    export = scene.cabletwin.export
    export.folder = str(tmp_path / "out")
    for chosen in ({"report", "model_glb"}, set(FILES)):
        for key in FILES:
            setattr(export, key, key in chosen)
        assert bpy.ops.cabletwin.export_files() == {"FINISHED"}
        names = {FILES[key] for key in chosen}
        assert {p.name for p in (tmp_path / "out").iterdir()} == names
        for name in names:
            assert (tmp_path / "out" / name).read_bytes() == (finished.folder / name).read_bytes()


@pytest.mark.parametrize("operator", ["export_files", "export_report", "export_folder"])
def test_without_results_it_says_what_to_do(operator, tmp_path):
    if operator == "export_files":
        bpy.context.scene.cabletwin.export.folder = str(tmp_path / "out")
    with pytest.raises(RuntimeError, match="no results are shown; open a run folder"):
        getattr(bpy.ops.cabletwin, operator)()


def test_an_unfinished_run_is_told(scene, finished, tmp_path):
    half = tmp_path / "half"
    shutil.copytree(finished.folder / "products", half / "products")
    scene.cabletwin.results.folder = str(half)
    scene.cabletwin.export.folder = str(tmp_path / "out")
    for operator in (bpy.ops.cabletwin.export_files, bpy.ops.cabletwin.export_report):
        with pytest.raises(RuntimeError, match="is not finished; reconstruct first"):
            operator()
    assert not (tmp_path / "out").exists()


def test_a_folder_must_be_chosen_and_the_runs_own_will_not_do(scene, finished):
    with pytest.raises(RuntimeError, match="no folder is chosen"):
        bpy.ops.cabletwin.export_files()
    scene.cabletwin.export.folder = str(finished.folder)
    with pytest.raises(RuntimeError, match="is the run folder itself"):
        bpy.ops.cabletwin.export_files()
    for key in FILES:
        setattr(scene.cabletwin.export, key, False)
    with pytest.raises(RuntimeError, match="no file is chosen"):
        bpy.ops.cabletwin.export_files()


def test_a_folder_that_is_not_there_is_not_opened(scene, tmp_path):
    scene.cabletwin.export.folder = str(tmp_path / "nowhere")
    with pytest.raises(RuntimeError, match="nowhere is not there; export first"):
        bpy.ops.cabletwin.export_folder()


def test_the_choice_survives_saving_and_loading(scene, tmp_path):
    scene.cabletwin.export.cloud, scene.cabletwin.export.report = True, False
    scene.cabletwin.export.folder = str(tmp_path / "out")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "saved.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "saved.blend"))
    export = bpy.context.scene.cabletwin.export
    assert (export.cloud, export.report, export.folder) == (True, False, str(tmp_path / "out"))
