"""A reconstruction started in Blender: the command line's results and sentences, cancelled in time."""

import json
import shutil
import threading
import time

import bpy
import pytest

from tests.addon.conftest import MODULE
from tests.addon.shown_run import library, named


@pytest.fixture
def scene(rendered, tmp_path):
    """The rendered survey in a folder of the test's own, opened."""
    for file in rendered.iterdir():
        if file.is_file():
            shutil.copy(file, tmp_path / file.name)
    assert bpy.ops.cabletwin.survey_open(filepath=str(tmp_path / "survey.toml")) == {"FINISHED"}
    return bpy.context.scene


def job():
    return bpy.context.window_manager.cabletwin_job


def test_diameters_are_the_command_lines_to_the_last_digit(scene, finished, tmp_path):
    assert bpy.ops.cabletwin.reconstruct_run() == {"FINISHED"}
    ours = json.loads((tmp_path / "run" / "report.json").read_text())
    assert ours["stations"] == finished.report["stations"]
    assert [s.name for s in scene.cabletwin.results.stations] == [s["name"] for s in ours["stations"]]
    assert len(named("Mosaic")) == 1
    assert not job().running
    assert job().fraction == 0.0


def test_a_failure_is_the_pipelines_sentence(scene, tmp_path):
    (tmp_path / "block2.mp4").write_bytes(b"no video at all")
    with pytest.raises(RuntimeError, match=r"block2\.mp4"):
        bpy.ops.cabletwin.reconstruct_run()
    assert "block2.mp4" in job().failure
    assert job().failure.count("\n") == 0
    assert not job().running
    assert not named("Mosaic")


def test_without_a_run_folder_it_says_which_panel_asks_for_it(scene):
    scene.cabletwin.run.folder = ""
    with pytest.raises(RuntimeError, match="no run folder is chosen; choose one in the panel Reconstruct"):
        bpy.ops.cabletwin.reconstruct_run()


def test_cancelling_takes_at_most_two_seconds_and_keeps_what_is_finished(scene, tmp_path):
    """The word is left as the button leaves it, from beside the waiting operator."""
    asked = []

    def ask():
        deadline = time.monotonic() + 60
        while not (tmp_path / "run" / "products" / "all-frames.stamp").exists():
            assert time.monotonic() < deadline
            time.sleep(0.05)
        asked.append(time.monotonic())
        library("operators.following")  # the module is there: nothing but a flag is set from here
        job().cancelling = True

    other = threading.Thread(target=ask)
    other.start()
    assert bpy.ops.cabletwin.reconstruct_run() == {"CANCELLED"}
    took = time.monotonic() - asked[0]
    other.join()
    assert took < 2.0
    assert not job().running
    assert (tmp_path / "run" / "products" / "all-frames.stamp").exists()
    assert not (tmp_path / "run" / "report.json").exists()


def test_one_job_at_a_time(scene):
    job().running = True
    assert not bpy.ops.cabletwin.reconstruct_run.poll()
    assert bpy.ops.cabletwin.reconstruct_cancel.poll()
    job().running = False
    assert not bpy.ops.cabletwin.reconstruct_cancel.poll()


def test_a_process_that_says_nothing_useful_still_gives_a_sentence(tmp_path):
    jobs = library("jobs")
    python = library("library").python_executable()
    failed = jobs.Job([str(python), "-c", "raise SystemExit(3)"], tmp_path / "log.jsonl").outcome()
    assert (failed.code, failed.failure) == (3, "the process ended with code 3 and said nothing")


def test_events_come_once_and_in_order_however_the_lines_are_cut(tmp_path):
    jobs = library("jobs")
    python = library("library").python_executable()
    code = (
        "import sys, time\n"
        "for k in range(6):\n"
        '    sys.stderr.write(\'{"stage": "match", "done": %d, \' % k)\n'
        "    sys.stderr.flush(); time.sleep(0.02)\n"
        '    sys.stderr.write(\'"total": 6, "block": "B", "message": ""}\\n\')\n'
        "    sys.stderr.flush()\n"
    )
    running = jobs.Job([str(python), "-c", code], tmp_path / "log.jsonl")
    seen = []
    while running.running():
        seen += running.events()
        time.sleep(0.005)
    seen += running.events()
    assert [e.done for e in seen] == list(range(6))
    assert running.outcome().code == 0


def test_a_tick_with_a_flood_of_events_holds_the_interface_for_less_than_a_twentieth_of_a_second(tmp_path):
    jobs, following = library("jobs"), library("operators.following")
    python = library("library").python_executable()
    event = '{"stage": "match", "done": 1, "total": 6, "block": "B", "message": ""}'
    code = f"import sys\nfor k in range(1000): sys.stderr.write({event!r} + chr(10))"
    follower = following.Follower(jobs.Job([str(python), "-c", code], tmp_path / "log.jsonl"), ("B",), job())
    while follower.job.running():
        time.sleep(0.01)
    took = []
    for _ in range(2):
        began = time.process_time()
        assert not follower.tick()
        took.append(time.process_time() - began)
    assert (job().stage, job().block) == ("match", "B")
    following.clear(job())
    assert 0 < took[1] < took[0] < 0.05


def test_the_log_is_shown_in_full_after_a_failure(scene, tmp_path):
    (tmp_path / "block2.mp4").write_bytes(b"no video at all")
    with pytest.raises(RuntimeError):
        bpy.ops.cabletwin.reconstruct_run()
    assert "error:" in (tmp_path / "run" / "log.jsonl").read_text()
    assert job().log == str(tmp_path / "run" / "log.jsonl")


def test_pycolmap_never_came_into_this_process():
    import sys

    assert not [name for name in sys.modules if name.split(".")[0] == "pycolmap"]
    assert MODULE in sys.modules
