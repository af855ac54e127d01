"""Results are brought in piece by piece: as at one go, never half shown, never holding Blender long."""

import time

import bpy
import numpy as np
import pytest

from tests.addon.shown_run import library, named, show

KINDS = ("Sparse points", "Cameras", "Block meshes", "Dense cloud", "Mosaic", "Stations")
MOST_MAIN_S = 0.2
"""The interface may be held no longer than this; by the processor's clock, whatever else the machine does."""


@pytest.fixture
def state(rendered, finished, tmp_path):
    show(rendered, finished.folder, tmp_path)
    return bpy.context.scene.cabletwin


def in_turns(folder):
    """What an operator has at the end of a reconstruction."""
    present, name = library("operators.results").present_run, bpy.context.scene.name

    def begin():
        scene = bpy.data.scenes.get(name)
        if scene is not None:
            yield from present(bpy.context, scene, folder)

    return library("pieces").InTurns(begin)


def finish(turns):
    """Processor time of the main thread in each turn."""
    took = []
    while True:
        began = time.thread_time()
        more = turns.turn()
        took.append(time.thread_time() - began)
        if not more:
            return took
        time.sleep(0.002)


def half_way(turns):
    """Until something has been made that nobody sees yet."""
    while bpy.context.scene.cabletwin.results.folder or "Block3" not in bpy.data.meshes:
        assert turns.turn()
        time.sleep(0.002)


def counts():
    kinds = ("objects", "meshes", "pointclouds", "cameras", "materials", "images", "curves", "collections")
    return {kind: len(getattr(bpy.data, kind)) for kind in kinds}


def scene_now():
    """All that is shown, by its collection and name, down to the coordinates."""
    found = {}
    for kind in KINDS:
        for name, item in named(kind).items():
            place = tuple(np.round(np.array(item.matrix_world), 9).ravel())
            data = tuple(sorted((a.name, len(a.data)) for a in getattr(item.data, "attributes", ())))
            found[kind, name] = (item.data.name, place, data, coordinates(item), item.hide_viewport)
    results = bpy.context.scene.cabletwin.results
    told = [(s.name, s.diameter_mm, s.sigma_mm, s.truth_mm) for s in results.stations]
    return found, told, [b.name for b in results.blocks], results.folder


def coordinates(item):
    if item.type != "MESH":
        return 0.0
    values = np.empty(3 * len(item.data.vertices), dtype=np.float32)
    item.data.attributes["position"].data.foreach_get("vector", values)
    return float(np.abs(values).sum(dtype=np.float64))


def test_the_scene_is_the_same_in_turns_and_at_one_go(state, finished):
    at_one_go, before = scene_now(), counts()
    finish(in_turns(finished.folder))
    assert scene_now() == at_one_go
    assert counts() == before


def test_no_turn_holds_blender_longer_than_it_may(state, finished):
    took = finish(in_turns(finished.folder))
    assert max(took) < MOST_MAIN_S
    assert len(took) > 10


def test_until_all_is_there_no_run_is_shown(state, finished):
    turns = in_turns(finished.folder)
    half_way(turns)
    assert [len(named(kind)) for kind in KINDS] == [0] * len(KINDS)
    assert (state.results.folder, len(state.results.blocks), len(state.results.stations)) == ("", 0, 0)
    assert not bpy.ops.cabletwin.crop_preview.poll()
    with pytest.raises(library("pipeline.core.errors").StageError, match="no results are shown"):
        library("opened").opened(bpy.context.scene)
    turns.stop()


def test_undo_in_between_changes_nothing_of_what_comes_out(state, finished):
    bpy.ops.ed.undo_push(message="shown")
    whole = scene_now()
    state.survey.name = "another"
    bpy.ops.ed.undo_push(message="named")
    turns = in_turns(finished.folder)
    half_way(turns)
    bpy.ops.ed.undo()
    finish(turns)
    assert scene_now() == whole
    assert bpy.context.scene.cabletwin.survey.name != "another"


def test_redo_to_a_step_that_was_kept_half_way_changes_nothing_either(state, finished):
    whole = scene_now()
    turns = in_turns(finished.folder)
    bpy.ops.ed.undo_push(message="before")
    half_way(turns)
    bpy.ops.ed.undo_push(message="half way")
    bpy.ops.ed.undo()
    turns.turn()
    bpy.ops.ed.redo()
    finish(turns)
    assert scene_now() == whole


def test_a_stop_leaves_nothing_behind_and_the_folder_opens_again(state, finished):
    whole = scene_now()
    turns = in_turns(finished.folder)
    half_way(turns)
    turns.stop()
    assert not any(mesh.name.startswith("Block") for mesh in bpy.data.meshes)
    assert not any(image.name.endswith("unrolled") for image in bpy.data.images)
    assert bpy.ops.cabletwin.results_open() == {"FINISHED"}
    assert scene_now() == whole


def test_a_scene_that_is_deleted_meanwhile_ends_it(state, finished):
    other = bpy.data.scenes.new("other")
    turns = in_turns(finished.folder)
    half_way(turns)
    bpy.context.window.scene = other
    bpy.data.scenes.remove(next(s for s in bpy.data.scenes if s != other))
    finish(turns)
    assert not any(collection.name == "CableTwin" for collection in other.collection.children)


def test_what_cannot_be_read_is_refused_and_what_is_shown_stays(state, tmp_path):
    whole = scene_now()
    error = library("pipeline.core.errors").StageError
    with pytest.raises(error, match="is no run folder"):
        finish(in_turns(tmp_path / "nothing"))
    assert scene_now() == whole


def test_listening_to_undo_ends_with_the_work(state, finished):
    handlers = bpy.app.handlers.undo_post, bpy.app.handlers.redo_post
    before = [len(each) for each in handlers]
    turns = in_turns(finished.folder)
    assert [len(each) for each in handlers] == [n + 1 for n in before]
    finish(turns)
    assert [len(each) for each in handlers] == before


class Follower:
    """What follows a job that has ended well."""

    def __init__(self, shown):
        self.shown = shown

    def tick(self):
        return False


def following(state, folder):
    """An operator's turns without a window: what its timer would call."""
    job_operator = library("operators.following").JobOperator

    class Operator:
        _showing, said = None, ()
        _turn, _shown, _finish = job_operator._turn, job_operator._shown, job_operator._finish
        _cancelled = job_operator._cancelled

        def _wrong(self, follower):
            return set()

        def _every(self, context, seconds):
            self.each_s = seconds

        def show(self, context, scene):
            yield from library("operators.results").present_run(context, scene, folder)

        def finished(self, context, scene):
            self.report({"INFO"}, "done")

        def report(self, kind, text):
            self.said = (*self.said, text)

    shown = bpy.context.window_manager.cabletwin_job
    shown.tell(running=True, cancelling=False, scene=bpy.context.scene.name)
    return Operator(), Follower(shown)


def test_the_job_runs_on_until_its_results_are_there(state, finished):
    whole = scene_now()
    operator, follower = following(state, finished.folder)
    stages = set()
    while not (ended := operator._turn(bpy.context, follower)):
        stages.add((follower.shown.running, follower.shown.stage, operator.each_s < 0.1))
        time.sleep(0.002)
    assert (ended, operator.said) == ({"FINISHED"}, ("done",))
    assert stages == {(True, "show", True)}
    assert operator.each_s is None
    assert not follower.shown.running
    assert scene_now() == whole


def test_cancelled_while_results_come_in_there_is_no_run_shown(state, finished):
    operator, follower = following(state, finished.folder)
    for _ in range(3):
        assert not operator._turn(bpy.context, follower)
        time.sleep(0.05)
    while bpy.context.scene.cabletwin.results.folder:
        assert not operator._turn(bpy.context, follower)
    follower.shown.tell(cancelling=True)
    assert operator._turn(bpy.context, follower) == {"CANCELLED"}
    assert operator.said == ("Cancelled: what is finished is kept",)
    assert not follower.shown.running
    assert [len(named(kind)) for kind in KINDS[:5]] == [0] * 5


def test_a_surprise_leaves_nothing_running(state, finished):
    operator, follower = following(state, finished.folder)

    def surprised(context, scene):
        yield
        raise RuntimeError("surprise")

    operator.show = surprised
    with pytest.raises(RuntimeError, match="surprise"):
        operator._turn(bpy.context, follower)
    assert (follower.shown.running, operator.each_s) == (False, None)


def test_no_other_run_is_opened_while_one_comes_in(state):
    job = bpy.context.window_manager.cabletwin_job
    job.tell(running=True, stage="show")
    try:
        assert not bpy.ops.cabletwin.results_open.poll()
        assert not bpy.ops.cabletwin.results_choose.poll()
    finally:
        library("operators.following").clear(job)
    assert bpy.ops.cabletwin.results_open.poll()
