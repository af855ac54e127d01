"""Files of an earlier run never pass for the result of a run that was refused."""

from concurrent.futures import ThreadPoolExecutor

import pytest

from pipeline.core.errors import StageError
from pipeline.set_aside import OPENED_FILES, OUTDATED, drop_set_aside, none_if_refused, set_aside
from tests.bad_input import cylinder
from tests.command import pipeline


@pytest.fixture
def run(tmp_path):
    """A finished run, as far as a person sees it."""
    folder = tmp_path / "run"
    (folder / "products").mkdir(parents=True)
    for name in OPENED_FILES:
        (folder / name).write_text(f"old {name}")
    return folder


def standing(folder):
    return sorted(path.name for path in folder.iterdir())


def test_what_is_set_aside_is_kept_under_another_name(run):
    set_aside(run)
    assert standing(run) == ["outdated", "products"]
    assert standing(run / "outdated") == sorted(OPENED_FILES)
    assert (run / "outdated" / "report.html").read_text() == "old report.html"


def test_what_is_newer_replaces_what_was_set_aside_before(run):
    set_aside(run)
    (run / "report.json").write_text("newer")
    set_aside(run)
    set_aside(run)
    assert (run / "outdated" / "report.json").read_text() == "newer"
    drop_set_aside(run)
    assert standing(run) == ["products"]


def test_a_scan_that_was_held_against_the_run_goes_with_it(run):
    for text in ("old", "new"):
        (run / "scan").mkdir()
        (run / "scan" / "scan.json").write_text(text)
        set_aside(run)
        assert "scan" not in standing(run)
        assert (run / "outdated" / "scan" / "scan.json").read_text() == text


def test_a_folder_that_no_run_made_is_left_alone(tmp_path):
    (tmp_path / "report.json").write_text("mine")
    set_aside(tmp_path)
    set_aside(tmp_path / "nowhere")
    assert standing(tmp_path) == ["report.json"]


def test_a_refusal_sets_aside_and_still_tells_itself(run):
    with pytest.raises(StageError, match="survey: bad; mend it"), none_if_refused(run):
        raise StageError("survey", "bad", "mend it")
    assert standing(run) == ["outdated", "products"]


def test_what_ends_well_or_is_interrupted_stays(run):
    with none_if_refused(run):
        pass
    with pytest.raises(KeyboardInterrupt), none_if_refused(run):
        raise KeyboardInterrupt
    assert (run / "report.json").exists()


SPOILT = {
    "a survey that cannot be read": lambda toml: toml.write_text("format = 2"),
    "another angle": lambda toml: toml.write_text(toml.read_text().replace("90.0", "0.0")),
    "a video that is gone": lambda toml: (toml.parent / "block2.mp4").unlink(),
    "a video that is broken": lambda toml: (toml.parent / "block2.mp4").write_bytes(b"nothing"),
}


@pytest.mark.parametrize("spoil", SPOILT.values(), ids=SPOILT)
def test_a_refused_run_leaves_no_report_that_looks_like_its_result(run, tmp_path, spoil):
    (tmp_path / "survey").mkdir()
    toml = cylinder.write_survey(tmp_path / "survey")
    spoil(toml)
    done = pipeline("run", toml, "--out", run, "--events", "none")
    assert done.code == 2
    assert not (run / "report.json").exists()
    assert not (run / "report.html").exists()
    assert (run / "outdated" / "report.html").read_text() == "old report.html"


def test_a_run_that_makes_anything_again_sets_aside_before_it_begins(run, tmp_path):
    """Even where it is not refused: between the first new product and the new report there is none."""
    (tmp_path / "survey").mkdir()
    toml = cylinder.write_survey(tmp_path / "survey")
    assert pipeline("run", toml, "--out", run, "--events", "none", "--only", "frames").code == 0
    assert standing(run / "outdated") == sorted(OPENED_FILES)
    assert standing(run) == ["blocks", "options.json", "outdated", "products"]


def test_blocks_that_are_made_side_by_side_may_set_aside_at_once(tmp_path):
    (tmp_path / "products").mkdir()
    for _ in range(60):
        for name in OPENED_FILES:
            (tmp_path / name).write_text(name)
        with ThreadPoolExecutor(8) as workers:
            for done in [workers.submit(set_aside, tmp_path) for _ in range(8)]:
                done.result()
        assert all((tmp_path / OUTDATED / name).read_text() == name for name in OPENED_FILES)
