"""The command line keeps its contract: help, exit codes, results on stdout, progress on stderr."""

import json
import os
import pty
import subprocess
from collections import Counter

import pytest

from pipeline.__main__ import STAGE_NAMES
from pipeline.cable.run import STAGES
from tests.bad_input import cylinder
from tests.command import ENVIRONMENT, ROOT, line_of, pipeline, start_pipeline, synth


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["--help"], ["run", "evaluate", "lens"]),
        (
            ["run", "--help"],
            ["--out", "--truth", "--only", "--from", "--pairs", "--set", "--adjust", "--no-lens-correction"],
        ),
        (["evaluate", "--help"], ["--truth", "--json"]),
        (["lens", "--help"], ["--chessboard", "9x6", "--square-mm", "--block", "--json", "--events"]),
    ],
)
def test_help_names_every_word_at_once(words, named):
    done = pipeline(*words)
    assert (done.code, done.stderr) == (0, "")
    assert [word for word in named if word not in done.stdout] == []


def test_synth_helps_too():
    done = synth("render", "--help")
    assert done.code == 0
    assert "SPEC.toml" in done.stdout


def test_the_stages_that_can_be_named_are_those_that_run():
    assert (*STAGES, "report") == STAGE_NAMES


@pytest.mark.parametrize(
    "words",
    [
        [],
        ["measure"],
        ["run"],
        ["run", "survey.toml"],
        ["run", "survey.toml", "--out", "x", "--only", "polish"],
        ["run", "survey.toml", "--out", "x", "--only", "match", "--from", "match"],
        ["run", "survey.toml", "--out", "x", "--language", "fr"],
        ["evaluate", "run"],
    ],
    ids=" ".join,
)
def test_words_that_make_no_command_are_refused_with_the_usage(words):
    done = pipeline(*words)
    assert (done.code, done.stdout) == (2, "")
    assert done.stderr.startswith("usage: python -m pipeline")
    assert "error: " in done.stderr


def test_an_error_wipes_the_half_drawn_bar_from_a_terminal(tmp_path):
    """Else the sentence would begin behind the bar and the time left."""
    line = line_of("pipeline", ["run", tmp_path / "nothing.toml", "--out", tmp_path / "run"])
    outer, inner = pty.openpty()
    done = subprocess.run(line, cwd=ROOT, env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=inner, check=False)
    os.close(inner)
    shown = os.read(outer, 4096).decode()
    os.close(outer)
    assert done.returncode == 2
    assert shown.startswith("\r\x1b[Kerror: ")


def test_a_run_whose_listener_has_gone_stops_and_is_no_success(tmp_path):
    """Exit code 0 only when the product is there: the extension's Blender may be closed half way."""
    words = ("run", cylinder.write_survey(tmp_path), "--out", tmp_path / "run", "--events", "json")
    process = start_pipeline(*words)
    assert json.loads(process.stderr.readline())["stage"] == "frames"
    process.stderr.close()
    assert process.wait(timeout=60) == 130
    assert not (tmp_path / "run" / "report.json").exists()


class TestAFinishedRun:
    """What a run of the whole chain told on its way."""

    def test_stderr_is_one_json_event_a_line(self, finished):
        lines = finished.command.stderr.splitlines()
        events = [json.loads(line) for line in lines]
        assert all(set(event) == {"stage", "done", "total", "block", "message"} for event in events)
        assert all(0 <= event["done"] <= event["total"] and event["total"] >= 1 for event in events)

    def test_every_stage_tells_of_itself_in_order_and_says_when_it_is_done(self, finished):
        over_all = [event for event in finished.command.events if event["block"] == ""]
        closed = [event["stage"] for event in over_all if event["done"] == event["total"]]
        assert tuple(closed) == STAGE_NAMES

    def test_no_stage_ever_goes_back(self, finished):
        reached = {}
        for event in finished.command.events:
            key, share = (event["stage"], event["block"]), event["done"] / event["total"]
            assert share >= reached.get(key, 0.0) - 1e-3, event
            reached[key] = share
        assert len(reached) > len(STAGE_NAMES)  # stages that work block by block tell so

    def test_no_step_between_two_events_is_long(self, finished):
        """A run that is silent cannot be stopped; measured in shares of the run, for machines differ."""
        timing_s = finished.report["timing_s"]
        told = Counter(event["stage"] for event in finished.command.events)
        shares = {stage: s / told[stage] / sum(timing_s.values()) for stage, s in timing_s.items()}
        assert {stage: share for stage, share in shares.items() if share > 0.04} == {}

    def test_stdout_is_the_table_and_the_files_to_open(self, finished):
        shown = finished.command.stdout
        for station in finished.report["stations"]:
            assert f"{station['diameter_mm']:.3f}" in shown
        assert f"mean absolute error {finished.report['truth']['mean_absolute_error_mm']:.3f} mm" in shown
        assert str(finished.folder / "model.glb") in shown
        assert str(finished.folder / "report.html") in shown
        assert "{" not in shown

    def test_evaluate_prints_its_table_and_writes_the_same_as_json(self, finished, rendered, tmp_path):
        words = ("--truth", rendered / "truth.json", "--json", tmp_path / "evaluation.json")
        done = pipeline("evaluate", finished.folder, *words)
        assert (done.code, done.stderr) == (0, "")
        written = json.loads((tmp_path / "evaluation.json").read_text())
        mae_mm = written["diameters"]["mean_absolute_mm"]
        assert mae_mm == pytest.approx(finished.report["truth"]["mean_absolute_error_mm"], abs=1e-9)
        assert f"MAE {mae_mm:.4f} mm" in done.stdout
        assert [f.name for f in tmp_path.iterdir()] == ["evaluation.json"]
