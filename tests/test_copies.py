"""A finished run's files can be handed on; an unfinished run's cannot."""

import pytest

from pipeline.copies import copy_results, finished_file
from pipeline.core.errors import StageError


@pytest.fixture
def run(tmp_path):
    folder = tmp_path / "run"
    folder.mkdir()
    for name in ("report.json", "report.html", "model.glb"):
        (folder / name).write_bytes(name.encode() * 1000)
    return folder


def test_copies_are_the_same_and_replace_older_ones(run, tmp_path):
    target = tmp_path / "for" / "them"
    target.mkdir(parents=True)
    (target / "report.html").write_text("older")
    (target / "notes.txt").write_text("theirs")
    copied = copy_results(run, ("report.html", "model.glb"), target)
    assert copied == (target / "report.html", target / "model.glb")
    for path in copied:
        assert path.read_bytes() == (run / path.name).read_bytes()
    assert sorted(p.name for p in target.iterdir()) == ["model.glb", "notes.txt", "report.html"]


def test_a_run_that_is_not_finished_is_refused_and_nothing_written(run, tmp_path):
    (run / "report.json").unlink()
    with pytest.raises(StageError, match="is not finished; reconstruct first"):
        copy_results(run, ("report.html",), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_file_that_is_gone_is_named_before_anything_is_copied(run, tmp_path):
    with pytest.raises(StageError, match=r"cloud\.ply is gone"):
        copy_results(run, ("report.html", "cloud.ply"), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_the_run_folder_itself_and_an_empty_choice_are_refused(run, tmp_path):
    with pytest.raises(StageError, match="is the run folder itself"):
        copy_results(run, ("report.html",), run / ".." / "run")
    with pytest.raises(StageError, match="no file is chosen"):
        copy_results(run, (), tmp_path / "out")


def test_a_folder_that_cannot_be_made_is_named(run, tmp_path):
    (tmp_path / "file").write_text("no folder")
    with pytest.raises(StageError, match="cannot write"):
        copy_results(run, ("report.html",), tmp_path / "file" / "out")


def test_the_file_to_open_is_the_runs_own(run):
    assert finished_file(run, "report.html") == run / "report.html"
