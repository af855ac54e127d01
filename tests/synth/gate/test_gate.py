"""The gate: it opens for a run inside its bounds and for no other."""

import json
from dataclasses import replace

import pytest

from pipeline.core.errors import StageError
from pipeline.core.events import silent
from synth.gate.__main__ import main
from synth.gate.bounds import BOUNDS_FILE, Bounds, read_bounds
from synth.gate.figures import FIGURES, Case, figures_of
from synth.gate.run import run_gate
from synth.gate.verdict import Verdict, judge, verdict_table
from synth.spec_reader import read_spec
from tests.synth.gate import sample

COMMITTED = read_bounds()
EVERY_FIGURE = [(scenario, figure) for scenario in COMMITTED for figure in COMMITTED[scenario]]


def gate(tmp_path, bench=None, **changes):
    return run_gate(
        tmp_path / "out", 7, silent, sample.write_bounds(tmp_path, **changes), bench or sample.Bench()
    )


def middle(scenario):
    return {name: (b.least + b.most) / 2 for name, b in COMMITTED[scenario].items()}


class TestCommittedBounds:
    def test_they_are_those_of_paper_and_sway(self):
        assert list(COMMITTED) == ["paper", "sway"]

    @pytest.mark.parametrize("scenario", COMMITTED)
    def test_in_their_middle_the_gate_opens(self, scenario):
        assert all(line.holds for line in judge(scenario, middle(scenario), COMMITTED[scenario]))

    @pytest.mark.parametrize(("scenario", "figure"), EVERY_FIGURE)
    @pytest.mark.parametrize("side", ["below", "above", "not there"])
    def test_any_single_figure_on_either_side_closes_it(self, scenario, figure, side):
        bound = COMMITTED[scenario][figure]
        step = 0.01 * (bound.most - bound.least) + 1e-9
        value = {"below": bound.least - step, "above": bound.most + step, "not there": None}[side]
        lines = judge(scenario, middle(scenario) | {figure: value}, COMMITTED[scenario])
        verdict = Verdict(seed=1, lines=lines, failures={})
        (complaint,) = verdict.complaints
        assert complaint.startswith(f"{scenario}: {figure} ")
        assert side in complaint
        assert verdict_table(verdict).count("OUT") == 1

    def test_they_ask_at_least_what_the_issue_asks(self):
        asked = {"paper": 0.05, "sway": 0.10}
        for scenario, most_mm in asked.items():
            bounds = COMMITTED[scenario]
            assert 0 < bounds["mae_mm"].least < bounds["mae_mm"].most <= most_mm
            assert bounds["focal_percent"].most <= 0.3
            assert bounds["peak_memory_mb"].most <= 4096
            assert bounds["calibrated_percent"].least >= 95

    def test_the_surveys_are_as_hard_as_those_of_the_benchmark(self):
        for scenario in COMMITTED:
            small = read_spec(BOUNDS_FILE.parent / f"{scenario}.toml")
            large = read_spec(BOUNDS_FILE.parents[1] / "bench" / f"{scenario}.toml")
            sizes = {"frames": 24, "travel_m": 0.46}
            assert replace(small.robot, **sizes) == replace(large.robot, **sizes)
            assert small.survey == large.survey
            assert small.lens.division_lambda == large.lens.division_lambda
            assert [s.diameter_mm for s in small.cable.station] == [
                s.diameter_mm for s in large.cable.station
            ]


class TestBoundsFile:
    @pytest.mark.parametrize(
        ("change", "word"),
        [
            ({"mae_mm": (0.02, 0.001)}, "starts above its end"),
            ({"mae_mm": (0.001,)}, "two finite numbers"),
            ({"mae_mm": (0.001, "inf")}, "two finite numbers"),
            ({"colour": (0, 1)}, "colour is no figure"),
        ],
    )
    def test_what_is_no_pair_of_bounds_is_refused(self, tmp_path, change, word):
        with pytest.raises(StageError, match=word):
            read_bounds(sample.write_bounds(tmp_path, **change))

    @pytest.mark.parametrize("figure", FIGURES)
    def test_a_figure_without_bounds_is_refused(self, tmp_path, figure):
        path = sample.write_bounds(tmp_path)
        lines = [line for line in path.read_text().splitlines() if not line.startswith(f"{figure} ")]
        path.write_text("\n".join(lines))
        with pytest.raises(StageError, match=f"{figure} is missing"):
            read_bounds(path)

    def test_an_empty_file_is_refused(self, tmp_path):
        (tmp_path / "bounds.toml").write_text("")
        with pytest.raises(StageError, match="names no scenario"):
            read_bounds(tmp_path / "bounds.toml")

    def test_bounds_hold_their_own_ends(self):
        bounds = Bounds(least=1, most=2)
        assert [bounds.hold(value) for value in (0.999, 1, 2, 2.001, None)] == [
            False,
            True,
            True,
            False,
            False,
        ]


class TestFigures:
    def test_they_are_those_of_the_worst_station_block_and_lens(self):
        case = Case(evaluation=sample.evaluation(), report=sample.report(), seconds=60.0)
        assert figures_of(case) == pytest.approx(
            {
                "mae_mm": 0.0035,
                "largest_mm": 0.004,
                "sigma_mm": 0.015,
                "sigma_over_rms": 0.015 / (0.5 * (0.003**2 + 0.004**2)) ** 0.5,
                "within_2_sigma": 1.0,
                "coverage_deg": 350.0,
                "coverage_percent": 98.0,
                "surface_bias_mm": 0.005,
                "surface_noise_mm": 0.05,
                "camera_along_mm": 0.004,
                "camera_radial_mm": 0.003,
                "focal_percent": 0.1,
                "lens_px": 0.5,
                "calibrated_percent": 100.0,
                "keypoints_per_image": 2000.0,
                "reprojection_px": 0.06,
                "shared_marks": 1500.0,
                "seconds": 60.0,
                "peak_memory_mb": 512.0,
            }
        )

    def test_a_station_outside_two_sigmas_counts(self):
        evaluation = sample.evaluation()
        evaluation["diameters"]["stations"][1]["difference_mm"] = 0.041
        found = figures_of(Case(evaluation=evaluation, report=sample.report(), seconds=1.0))
        assert found["within_2_sigma"] == 0.5

    def test_what_the_documents_do_not_hold_is_none_and_not_a_pass(self):
        evaluation = sample.evaluation() | {"lenses": None, "surface": {}}
        evaluation["diameters"]["stations"][0]["sigma_mm"] = None
        found = figures_of(Case(evaluation=evaluation, report={}, seconds=1.0))
        missing = {name for name, value in found.items() if value is None}
        assert missing == set(FIGURES) - {
            *("mae_mm", "largest_mm", "camera_along_mm", "camera_radial_mm", "seconds")
        }


class TestRun:
    def test_it_opens_for_a_run_inside_its_bounds(self, tmp_path):
        assert gate(tmp_path).complaints == ()
        written = json.loads((tmp_path / "out" / "results.json").read_text())
        assert (written["passed"], written["seed"], written["failures"]) == (True, 7, {})
        assert len(written["lines"]) == 2 * len(FIGURES)
        assert written["lines"][0] == {
            "scenario": "paper",
            "figure": "mae_mm",
            "value": 0.0035,
            "least": 0.001,
            "most": 0.02,
            "holds": True,
        }

    @pytest.mark.parametrize(("error_mm", "word"), [(0.03, "above 0.02"), (0.0001, "below 0.001")])
    def test_a_run_too_far_off_or_too_good_to_be_true_closes_it(self, tmp_path, error_mm, word):
        def evaluation():
            found = sample.evaluation()
            found["diameters"]["mean_absolute_mm"] = error_mm
            return found

        verdict = gate(tmp_path, sample.Bench("sway", evaluation=evaluation))
        (complaint,) = verdict.complaints
        assert complaint.startswith("sway: mae_mm = ")
        assert complaint.endswith(word)
        assert not json.loads((tmp_path / "out" / "results.json").read_text())["passed"]

    def test_a_run_that_takes_too_long_closes_it(self, tmp_path):
        verdict = gate(tmp_path, sample.Bench(seconds=301.0))
        assert [c.split(" =")[0] for c in verdict.complaints] == ["paper: seconds", "sway: seconds"]

    def test_a_step_that_fails_closes_it_with_its_sentence(self, tmp_path):
        bench = sample.Bench("paper", failure="match: too few points in Block2; clean the lens.")
        verdict = gate(tmp_path, bench)
        assert verdict.complaints == ("paper: match: too few points in Block2; clean the lens.",)
        assert {line.scenario for line in verdict.lines} == {"sway"}


class TestCommandLine:
    @staticmethod
    def call(monkeypatch, tmp_path, bench):
        path = sample.write_bounds(tmp_path)

        def run(out, seed, emit):
            return run_gate(out, seed, emit, path, bench)

        monkeypatch.setattr("synth.gate.__main__.run_gate", run)
        return main(["--seed", "3", "--out", str(tmp_path / "out")])

    def test_a_passed_gate_prints_its_table_and_ends_with_0(self, monkeypatch, tmp_path, capsys):
        assert self.call(monkeypatch, tmp_path, sample.Bench()) == 0
        said = capsys.readouterr()
        assert "paper     mae_mm" in said.out
        assert "results.json" in said.out
        assert "OUT" not in said.out
        assert "paper seed 3: render" in said.err

    def test_a_closed_gate_ends_with_1_and_the_line_that_failed(self, monkeypatch, tmp_path, capsys):
        assert self.call(monkeypatch, tmp_path, sample.Bench(seconds=1.0)) == 1
        said = capsys.readouterr()
        assert said.out.count("OUT") == 2
        assert said.err.endswith("paper: seconds = 1 is below 5\nsway: seconds = 1 is below 5\n")

    def test_a_negative_seed_is_refused(self, capsys):
        assert main(["--seed", "-1"]) == 2
        assert "the seed -1 is negative" in capsys.readouterr().err
