"""The suite: which commands in which order, what becomes of failures, and the figures it draws."""

import json
import sys
from pathlib import Path

import pytest

from pipeline.core.errors import Cancelled, StageError
from pipeline.core.events import silent
from synth.__main__ import main
from synth.child import Finished, last_sentence, run_child
from synth.suite import SuiteOptions, read_results, run_suite
from synth.suite_figures import figures
from synth.suite_records import Case, Results, StationFigures, case_from_json
from synth.suite_table import results_json, results_markdown

TRUTH = {
    "stations": [
        {"name": "A", "diameter_mm": 100.1, "base_diameter_mm": 100.0},
        {"name": "B", "diameter_mm": 100.1, "base_diameter_mm": 100.0},
    ]
}
EVALUATION = {
    "diameters": {
        "stations": [
            {"name": "A", "truth_mm": 100.1, "model_mm": 100.13, "difference_mm": 0.03, "sigma_mm": 0.02},
            {"name": "B", "truth_mm": 100.1, "model_mm": 100.06, "difference_mm": -0.04, "sigma_mm": 0.01},
        ]
    },
    "lenses": [{"focal_percent": 0.1}, {"focal_percent": -0.3}],
    "surface": {"coverage_percent": 97.5, "stations": [{"overclaimed_deg": 1.0}, {"overclaimed_deg": 4.0}]},
    "axis": {"bow_difference_mm": -0.2},
    "relief": {"largest_mm": 0.07, "missed": 1, "false": 2},
}


class Bench:
    """A runner that writes what the commands would, and fails where it is told to."""

    def __init__(self, failures=None):
        self.commands = []
        self.failures = failures or {}

    def __call__(self, command, log, beat):
        assert command[:2] == [sys.executable, "-m"]
        self.commands.append(command[2:])
        beat()
        for words, sentence in self.failures.items():
            if all(any(word in part for part in command) for word in words):
                return Finished(failure=sentence, seconds=4.0)
        self._write(command[2:])
        return Finished(failure=None, seconds=12.0)

    def _write(self, command):
        match command:
            case ["synth", "render", _, out, *_]:
                Path(out).mkdir(parents=True, exist_ok=True)
                (Path(out) / "truth.json").write_text(json.dumps(TRUTH))
            case ["pipeline", "run", _, "--out", out, *_]:
                Path(out).mkdir(parents=True)  # the suite has taken the old one away
                (Path(out) / "report.json").write_text(json.dumps({"peak_memory_mb": 900.0}))
            case ["pipeline", "evaluate", *_, "--json", file]:
                Path(file).write_text(json.dumps(EVALUATION))
            case ["pipeline.evaluate.stock_colmap", *_, "--json", file]:
                Path(file).write_text(json.dumps({"mae_mm": 0.5, "seconds": {"total": 100.0, "masks": 7.0}}))


@pytest.fixture
def specs(tmp_path):
    paths = [tmp_path / "easy.toml", tmp_path / "hard.toml"]
    for path in paths:
        path.write_text("seed = 5\n")
    return paths


def test_every_specification_meets_every_seed_through_the_public_commands(specs, tmp_path):
    bench, out = Bench(), tmp_path / "out"
    results = run_suite(specs, out, SuiteOptions(seeds=(1, 2)), silent, bench)
    assert [(c.scenario, c.seed) for c in results.cases] == [
        ("easy", 1),
        ("easy", 2),
        ("hard", 1),
        ("hard", 2),
    ]
    assert len(bench.commands) == 12
    folder = out / "easy" / "seed-2"
    survey, run = folder / "survey", folder / "run"
    truth, found = str(survey / "truth.json"), str(folder / "evaluation.json")
    assert bench.commands[3] == [*("synth", "render", str(specs[0]), str(survey), "--seed", "2", "--quiet")]
    assert bench.commands[4] == [
        *("pipeline", "run", str(survey / "survey.toml"), "--out", str(run), "--events", "none")
    ]
    assert bench.commands[5] == ["pipeline", "evaluate", str(run), "--truth", truth, "--json", found]


def test_the_figures_of_a_case_are_those_of_its_evaluation(specs, tmp_path):
    run_suite(specs[:1], tmp_path / "out", SuiteOptions(seeds=(1,)), silent, Bench())
    (case,) = json.loads((tmp_path / "out" / "results.json").read_text())["cases"]
    assert case["mae_mm"] == pytest.approx(0.035)
    assert case["stations"][0]["base_difference_mm"] == pytest.approx(0.13)  # no own base: its only diameter
    assert case["largest_mm"] == pytest.approx(0.04)
    assert case["within_2_sigma"] == 0.5
    assert case["sigma_over_rms"] == pytest.approx(0.015 / 0.0353553, rel=1e-5)
    assert case["focal_percent"] == 0.3
    assert (case["height_mm"], case["relief_missed"], case["relief_false"], case["bow_mm"]) == (
        0.07,
        1,
        2,
        0.2,
    )
    assert (case["coverage_percent"], case["overclaimed_deg"]) == (97.5, 4.0)
    assert (case["seconds"], case["peak_memory_mb"], case["failure"]) == (12.0, 900.0, None)
    assert case["stations"][0]["truth_mm"] == 100.1
    row = "| easy | 1 | 0.035 |  | 0.040 | 50 % | 0.4 | 0.30 | 0.070 | 0.200 | 97.5 | 4 | 12 | 900 |  |"
    assert row in (tmp_path / "out" / "results.md").read_text()


def test_on_a_cable_with_ribs_the_bare_sheath_counts(specs, tmp_path):
    class Ribbed(Bench):
        def _write(self, command):
            super()._write(command)
            if command[:2] == ["synth", "render"]:
                truth = {**TRUTH, "spec": {"cable": {"fillet": {"height_mm": 2.0}}}}
                (Path(command[3]) / "truth.json").write_text(json.dumps(truth))
            if command[:2] == ["pipeline", "evaluate"]:
                stations = [
                    {**s, "base_model_mm": 100.01, "base_sigma_mm": 0.006}
                    for s in EVALUATION["diameters"]["stations"]
                ]
                told = {**EVALUATION, "diameters": {"stations": stations}}
                Path(command[-1]).write_text(json.dumps(told))

    (case,) = run_suite(specs[:1], tmp_path / "out", SuiteOptions(seeds=(1,)), silent, Ribbed()).cases
    found = figures([case])
    assert (found.mae_mm, found.mae_mean_mm) == (pytest.approx(0.01), pytest.approx(0.035))
    assert (found.within_1_sigma, found.within_2_sigma) == (0.0, 1.0)  # 0.01 against 0.006


def test_several_calls_add_up_and_the_same_case_is_replaced(specs, tmp_path):
    out = tmp_path / "out"
    run_suite(specs[1:], out, SuiteOptions(seeds=(1,)), silent, Bench({("run", "hard"): "match: no; sorry."}))
    run_suite(specs[:1], out, SuiteOptions(seeds=(2, 1)), silent, Bench())
    cases = read_results(out).cases
    assert [(c.scenario, c.seed) for c in cases] == [("easy", 1), ("easy", 2), ("hard", 1)]
    assert cases[2].failure == "match: no; sorry."
    assert len(run_suite(specs[1:], out, SuiteOptions(seeds=(1,)), silent, Bench()).cases) == 1
    assert [(c.scenario, c.seed, c.failure) for c in read_results(out).cases][2] == ("hard", 1, None)
    (out / "results.json").write_text('{"format": 1, "cases": []}')
    with pytest.raises(StageError, match=r"results\.json cannot be added to \(format is 1"):
        run_suite(specs, out, SuiteOptions(), silent, Bench())


def test_a_case_is_the_same_after_it_was_written_and_read(specs, tmp_path):
    options = SuiteOptions(seeds=(1,), stock=True)
    results = run_suite(specs[:1], tmp_path / "out", options, silent, Bench())
    (written,) = json.loads(json.dumps(results_json(results)))["cases"]
    assert case_from_json(written) == results.cases[0]


def test_a_run_is_kept_when_asked_unless_survey_or_run_are_others(specs, tmp_path):
    out, keep = tmp_path / "out", SuiteOptions(seeds=(1,), stock=True, keep_runs=True)
    folder = out / "easy" / "seed-1"

    def steps():
        bench = Bench()
        (case,) = run_suite(specs[:1], out, keep, silent, bench).cases
        assert (case.seconds, case.stock["seconds"]) == (12.0, 100.0)
        return [
            command[1] if command[0] != "pipeline.evaluate.stock_colmap" else "stock"
            for command in bench.commands
        ]

    assert steps() == ["render", "run", "evaluate", "stock"]
    assert steps() == ["render", "evaluate"]
    (folder / "survey" / "survey.toml").write_text("other claims")
    assert steps() == ["render", "run", "evaluate", "stock"]
    (folder / "run" / "report.json").unlink()
    assert steps() == ["render", "run", "evaluate"]
    note = json.loads((folder / "made.json").read_text())
    (folder / "made.json").write_text(json.dumps({**note, "program": "another"}))
    assert steps() == ["render", "run", "evaluate"]


def test_a_case_that_fails_is_named_and_the_others_go_on(specs, tmp_path):
    bench = Bench({("run", "easy", "seed-1"): "match: too few points in Block2; clean the lens."})
    results = run_suite(specs, tmp_path / "out", SuiteOptions(seeds=(1, 2)), silent, bench)
    assert [case.failure is None for case in results.cases] == [False, True, True, True]
    text = (tmp_path / "out" / "results.md").read_text()
    assert "- easy, seed 1: match: too few points in Block2; clean the lens." in text
    assert "| easy | 1 | failed |" in text
    written = json.loads((tmp_path / "out" / "results.json").read_text())["scenarios"]
    assert [(s["scenario"], s["failures"]) for s in written] == [("easy", 1), ("hard", 0)]


def test_only_rendering_starts_nothing_else(specs, tmp_path):
    bench = Bench({("hard",): "render: no space; make some."})
    options = SuiteOptions(seeds=(3,), only_render=True)
    results = run_suite(specs, tmp_path / "out", options, silent, bench)
    assert [command[:2] for command in bench.commands] == [["synth", "render"]] * 2
    assert [case.failure for case in results.cases] == [None, "render: no space; make some."]
    assert not (tmp_path / "out" / "results.json").exists()  # an earlier table would be lost


def test_a_run_is_made_anew_and_a_rendering_kept(specs, tmp_path):
    bench, out = Bench(), tmp_path / "out"
    run_suite(specs[:1], out, SuiteOptions(seeds=(1,)), silent, bench)
    mark = out / "easy" / "seed-1" / "run" / "old"
    kept = out / "easy" / "seed-1" / "survey" / "block1.mp4"
    for file in (mark, kept):
        file.write_text("")
    run_suite(specs[:1], out, SuiteOptions(seeds=(1,)), silent, bench)
    assert not mark.exists()
    assert kept.exists()


def test_stock_colmap_gets_the_run_and_its_failure_is_no_failure_of_the_case(specs, tmp_path):
    bench = Bench({("evaluate.stock_colmap", "hard"): "mapper: no pair to start from; none."})
    options = SuiteOptions(seeds=(1,), stock=True)
    easy, hard = run_suite(specs, tmp_path / "out", options, silent, bench).cases
    assert (easy.stock["mae_mm"], easy.stock["seconds"], easy.stock["failure"]) == (0.5, 100.0, None)
    assert hard.failure is None
    assert hard.stock["failure"] == "mapper: no pair to start from; none."
    text = (tmp_path / "out" / "results.md").read_text()
    assert "| 0.500 | 14.3 | 100 | 8.3 |" in text  # 0.5 mm against 0.035, 100 s against 12
    assert "Stock COLMAP failed:" in text


def test_bad_specifications_are_refused_before_anything_runs(specs, tmp_path):
    bench = Bench()
    specs[1].write_text("shutter = 1\n")
    with pytest.raises(StageError, match="shutter is unknown"):
        run_suite(specs, tmp_path / "out", SuiteOptions(), silent, bench)
    namesake = tmp_path / "other" / "easy.toml"
    namesake.parent.mkdir()
    namesake.write_text("")
    with pytest.raises(StageError, match="two specifications are called easy"):
        run_suite([specs[0], namesake], tmp_path / "out", SuiteOptions(), silent, bench)
    assert bench.commands == []


def station(name, difference_mm, sigma_mm, truth_mm=100.0):
    return StationFigures(
        name=name,
        truth_mm=truth_mm,
        difference_mm=difference_mm,
        sigma_mm=sigma_mm,
        base_difference_mm=difference_mm,
        base_sigma_mm=sigma_mm,
    )


def test_seeds_are_taken_together_for_a_scenario():
    def case(seed, *differences):
        rows = [station(str(i), d, s) for i, (d, s) in enumerate(differences)]
        return Case(scenario="easy", seed=seed, stations=tuple(rows))

    cases = (case(1, (0.03, 0.02), (0.0, 0.02)), case(2, (-0.05, 0.02), (0.0, None)))
    both = figures(cases)
    assert both.mae_mm == pytest.approx(0.02)
    assert both.rms_mm == pytest.approx((0.0034 / 4) ** 0.5)
    assert both.within_2_sigma == 0.5  # 0.05 is 2.5 sigmas, and no sigma is no excuse
    assert both.within_1_sigma == 0.25
    assert "| easy | all | 0.020 |  | 0.050 | 50 % |" in results_markdown(Results(cases=cases))
    assert figures([]).mae_mm is None


def test_a_child_gives_its_last_sentence_and_its_time(tmp_path):
    log = tmp_path / "log.txt"
    talk = "import sys; print('working'); sys.stderr.write('error: lens: folded; give less.\\n'); sys.exit(2)"
    finished = run_child([sys.executable, "-c", talk], log, lambda: None)
    assert finished.failure == "lens: folded; give less."
    assert 0.0 < finished.seconds < 20.0
    assert "working" in log.read_text()
    assert run_child([sys.executable, "-c", ""], log, lambda: None).failure is None
    assert run_child([sys.executable, "-c", "raise SystemExit(3)"], log, lambda: None).failure == (
        "ended with code 3 and no word"
    )
    assert last_sentence("12 %\r34 %\nMemoryError\n\n", 1) == "MemoryError"


def test_a_child_is_ended_when_the_person_has_asked_to_stop(tmp_path):
    def stop():
        raise Cancelled

    sleeping = "import time, pathlib, sys; time.sleep(30); pathlib.Path(sys.argv[1]).touch()"
    with pytest.raises(Cancelled):
        run_child([sys.executable, "-c", sleeping, str(tmp_path / "end")], tmp_path / "log.txt", stop)
    assert not (tmp_path / "end").exists()


def test_the_command_ends_with_1_when_a_case_failed(tmp_path, capsys):
    spec = tmp_path / "none.toml"
    assert main(["suite", str(spec), "--out", str(tmp_path / "out"), "--quiet"]) == 2
    assert "cannot be read" in capsys.readouterr().err
    spec.write_text("[lens]\nwidth_px = 160\nheight_px = 100\n")
    (tmp_path / "out" / "none" / "seed-1").mkdir(parents=True)
    (tmp_path / "out" / "none" / "seed-1" / "survey").write_text("a file in the way")
    words = ["suite", str(spec), "--seeds", "1", "--out", str(tmp_path / "out"), "--quiet"]
    assert main([*words, "--only-render"]) == 1
    assert "none, seed 1: render:" in capsys.readouterr().err
