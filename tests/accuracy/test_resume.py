"""A run that is started again makes what is missing or has changed, and nothing else."""

import json
import shutil
import signal
import threading
import time

import pytest

from tests.command import pipeline, start_pipeline


def products(folder):
    """When each product was written: name to nanoseconds."""
    return {f.stem: f.stat().st_mtime_ns for f in (folder / "products").glob("*.npz")}


def run_again(rendered, folder, *words, survey=None):
    """Run on an existing folder; gives the command and the names of the products that were made anew."""
    before = products(folder)
    toml = (survey or rendered) / "survey.toml"
    done = pipeline("run", toml, "--out", folder, *words, "--events", "none")
    assert done.code == 0, done.stderr[-2000:]
    after = products(folder)
    assert set(after) == set(before)
    return done, {name for name in after if after[name] != before[name]}


def stations(folder):
    return json.loads((folder / "report.json").read_text())["stations"]


def test_a_run_started_again_makes_nothing_twice(rendered, finished, copied):
    done, remade = run_again(rendered, copied)
    assert remade == set()
    assert not (copied / "outdated").exists()
    assert done.seconds < 0.5 * finished.command.seconds
    assert stations(copied) == stations(finished.folder)
    assert "truth" not in json.loads((copied / "report.json").read_text())


def test_a_changed_option_makes_again_only_what_depends_on_it(rendered, finished, copied):
    _, remade = run_again(rendered, copied, "--set", "measure.slice_mm=8")
    assert remade == {"all-measure"}
    changed, before = stations(copied), stations(finished.folder)
    assert [s["diameter_mm"] for s in changed] == pytest.approx([s["diameter_mm"] for s in before], abs=0.05)
    assert changed != before
    assert json.loads((copied / "options.json").read_text())["measure"]["slice_mm"] == 8.0


def test_from_a_stage_on_all_is_made_again(rendered, finished, copied):
    _, remade = run_again(rendered, copied, "--from", "mosaic")
    assert remade == {"all-mosaic", "all-ring", "all-measure"}
    assert stations(copied) == stations(finished.folder)


def test_only_one_stage_is_made_again(rendered, finished, copied):
    done, remade = run_again(rendered, copied, "--only", "surface")
    assert remade == {f"Block{n}-surface" for n in (1, 2, 3, 4)}
    assert done.stdout.startswith("surface is done")


def interrupt_at(stage, *words, by=signal.SIGINT):
    """Start a run and interrupt it at the first event of a stage: exit code, seconds to stop, last line."""
    process = start_pipeline("run", *words, "--events", "json")
    for line in process.stderr:
        if f'"stage": "{stage}"' in line:
            break
    rest = []
    drain = threading.Thread(target=lambda: rest.extend(process.stderr))
    drain.start()
    began = time.monotonic()
    process.send_signal(by)
    code = process.wait(timeout=30)
    took_s = time.monotonic() - began
    drain.join()
    return code, took_s, rest[-1]


def test_one_block_filmed_again_leaves_the_others_alone_until_all_are_joined(rendered, copied, tmp_path):
    again = tmp_path / "again"
    shutil.copytree(rendered, again, ignore=shutil.ignore_patterns(".synth", "depth"))
    with (again / "block2.mp4").open("ab") as file:
        file.write(b"\x00\x00\x00\x08free")  # an empty box: another file that shows the same
    before = products(copied)
    # as far as the blocks are worked on alone, and joined
    code, *_ = interrupt_at("dense", again / "survey.toml", "--out", copied)
    assert code == 130
    after = products(copied)
    remade = {name for name in before if after.get(name) != before[name]}
    alone = {f"Block2-{stage}" for stage in ("lens", "pos", "match", "adjust", "undistort")}
    assert not (copied / "report.json").exists()  # it tells of the film before
    assert (copied / "outdated" / "report.json").exists()
    assert remade - {"Block1-dense"} == {"all-frames", *alone, "all-closing", "all-joint"}


@pytest.fixture(scope="module")
def interrupted(rendered, tmp_path_factory):
    """A run without truth that gets Ctrl-C at its first match: folder, exit code, seconds it took to stop."""
    folder = tmp_path_factory.mktemp("interrupted") / "run"
    code, took_s, said = interrupt_at("match", rendered / "survey.toml", "--out", folder)
    left = [path for path in folder.rglob("*") if ".part" in path.name]
    return folder, code, took_s, said, left


def test_an_interrupted_run_stops_at_once_and_says_that_it_can_go_on(interrupted):
    _, code, took_s, said, _ = interrupted
    assert code == 130
    assert took_s < 2.0
    assert said == "interrupted; what is finished is kept, start again to go on\n"


def test_a_run_that_another_program_ends_stops_the_same_way(rendered, tmp_path):
    """SIGTERM is what the Blender extension sends."""
    words = (rendered / "survey.toml", "--out", tmp_path / "run")
    code, took_s, said = interrupt_at("lens", *words, by=signal.SIGTERM)
    assert (code, said) == (130, "interrupted; what is finished is kept, start again to go on\n")
    assert took_s < 2.0
    assert [path for path in tmp_path.rglob("*") if ".part" in path.name] == []


def test_an_interrupted_run_leaves_nothing_half_written(interrupted):
    folder, *_, left = interrupted
    assert left == []
    assert not (folder / "report.json").exists()
    assert {"all-frames", "Block1-lens"} <= set(products(folder))


def test_an_interrupted_run_ends_as_if_nothing_had_been_and_never_knew_the_truth(
    rendered, finished, interrupted
):
    """To the last digit: the chain is deterministic, and truth.json reaches nothing but the comparison."""
    folder = interrupted[0]
    kept = products(folder)
    done = pipeline("run", rendered / "survey.toml", "--out", folder, "--events", "none")
    assert done.code == 0, done.stderr[-2000:]
    assert {name: when for name, when in products(folder).items() if name in kept} == kept
    assert stations(folder) == stations(finished.folder)
    assert "truth" not in json.loads((folder / "report.json").read_text())
