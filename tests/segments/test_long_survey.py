"""A survey cut into segments, from the command line: the same product as in one piece, in bounded memory."""

import json
import shutil

import numpy as np
import pytest

from pipeline.cable.chain import Chain
from pipeline.cable.survey import read_survey
from pipeline.core.errors import StageError
from pipeline.core.events import silent
from pipeline.opened import open_run
from pipeline.product import make_product
from tests.command import pipeline

CUT = ("segments.frames=13", "segments.shared=4")


def words(rendered, folder):
    truth = rendered / "truth.json"
    sets = [w for key in CUT for w in ("--set", key)]
    return (rendered / "survey.toml", "--out", folder, "--truth", truth, "--events", "json", *sets)


@pytest.fixture(scope="module")
def long_run(rendered, tmp_path_factory):
    folder = tmp_path_factory.mktemp("long") / "run"
    done = pipeline("run", *words(rendered, folder))
    assert done.code == 0, done.stderr[-2000:]
    return folder


@pytest.fixture(scope="module")
def report(long_run):
    return json.loads((long_run / "report.json").read_text())


def test_diameters_agree_with_truth_within_what_sigma_says(report):
    truth = report["truth"]
    assert truth["mean_absolute_error_mm"] < 0.05
    sigma_mm = {s["name"]: s["sigma_mm"] for s in report["stations"]}
    for row in truth["stations"]:
        assert abs(row["difference_mm"]) < 3 * sigma_mm[row["name"]] < 0.3


def test_every_station_is_told_once_at_its_place(report, rendered):
    asked = {s.name: s.position_m for s in read_survey(rendered / "survey.toml").cable.stations}
    told = {s["name"]: s["position_m"] for s in report["stations"]}
    assert list(told) == sorted(asked, key=asked.get)
    assert [told[n] for n in told] == pytest.approx([asked[n] for n in told], abs=1e-9)


def test_segments_lie_end_to_end_and_their_scale_is_that_of_the_travel(report, rendered):
    segments = report["segments"]
    assert len(segments) > 1
    ends = [s["from_m"] for s in segments] + [segments[-1]["to_m"]]
    assert ends == sorted(ends)
    travel_m = read_survey(rendered / "survey.toml").cable.travel_m
    assert (ends[0], ends[-1]) == pytest.approx((0, travel_m), abs=1e-4)
    for segment in segments:
        assert segment["scale"] == pytest.approx(1, abs=0.02)
        assert 0 < segment["scale_sigma"] < 1e-3


def test_the_profile_of_the_axis_runs_from_end_to_end(report):
    places = [row["position_m"] for row in report["axis"]["profile"]]
    assert places == sorted(places)
    assert np.diff(places).max() < 0.011


def test_the_axis_is_one_curve_whose_bow_and_bends_agree_with_the_straight_truth(report):
    axis, segments = report["axis"], report["segments"]
    assert axis["bow_mm"] < 5 * axis["bow_sigma_mm"] < 1
    sigma_mm = [row["bow_sigma_mm"] for row in axis["profile"]]
    assert sigma_mm[0] == sigma_mm[-1] == 0 < min(sigma_mm[1:-1])
    for segment in segments[:-1]:
        assert np.abs(segment["bend_mm_per_m"]).max() < 4 * segment["bend_sigma_mm_per_m"] < 4
    assert segments[-1]["bend_mm_per_m"] == [None, None]


def test_the_whole_and_every_segment_have_all_files(long_run, report):
    files = ("report.html", "model.glb", "model.ply", "cloud.ply", "unrolled.png", "diameters.csv")
    for folder in (long_run, *(long_run / "segments" / s["name"] for s in report["segments"])):
        for name in files:
            assert (folder / name).stat().st_size > 100, folder / name
    assert "segments/002/report.html" in (long_run / "report.html").read_text(encoding="utf-8")


def test_a_second_start_makes_no_stage_again(long_run, rendered):
    before = {f: f.stat().st_mtime_ns for f in long_run.glob("segments/*/products/*.npz")}
    assert len(before) > 50
    done = pipeline("run", *words(rendered, long_run))
    assert done.code == 0
    assert {f: f.stat().st_mtime_ns for f in long_run.glob("segments/*/products/*.npz")} == before


def test_a_stage_made_again_by_itself_leaves_every_segment_whole_in_the_end(long_run, rendered, tmp_path):
    run = tmp_path / "run"
    shutil.copytree(long_run, run)
    survey, truth = read_survey(rendered / "survey.toml"), rendered / "truth.json"
    make_product(survey, run, silent, assignments=CUT, truth=truth, only="measure")
    segments = sorted((run / "segments").iterdir())
    assert not any((s / "report.json").exists() for s in segments), "what rests on it is outdated"
    make_product(survey, run, silent, assignments=CUT, truth=truth)
    for folder in (run, *segments):
        assert (folder / "report.json").is_file()
        assert (folder / "model.ply").is_file()
        assert not (folder / "outdated").exists()


def test_a_segment_opens_like_any_run_and_the_whole_says_so(long_run):
    run = open_run(long_run / "segments" / "002")
    assert len(run.blocks) == 4
    assert run.together is not None
    assert run.ring is not None
    path = run.together.path
    assert path.y_m[-1] - path.y_m[0] == pytest.approx(run.report["length_m"], rel=2e-5)
    with pytest.raises(StageError, match="choose one of the folders in"):
        open_run(long_run)


def test_a_run_folder_that_was_moved_is_still_whole(long_run, rendered, tmp_path):
    moved = tmp_path / "elsewhere"
    shutil.copytree(long_run, moved)
    assert open_run(moved / "segments" / "001").blocks[0].frames.files[0].is_relative_to(moved)


def test_a_segment_without_anything_to_find_is_told_and_left_out(long_run, rendered, tmp_path, monkeypatch):
    copy = tmp_path / "run"
    shutil.copytree(long_run, copy)
    ordinary = Chain.run

    def run(self, name, pairs):
        if self.folder.path.name == "002" and name == "match":
            raise StageError("match", "Block1 has no marks", "film something")
        ordinary(self, name, pairs)

    monkeypatch.setattr(Chain, "run", run)
    survey = read_survey(rendered / "survey.toml")
    make_product(survey, copy, silent, assignments=CUT)
    told = json.loads((copy / "report.json").read_text())
    others = [f.name for f in sorted((long_run / "segments").iterdir()) if f.name != "002"]
    assert [s["name"] for s in told["segments"]] == others
    assert any("Segment 002" in w and "Block1 has no marks" in w for w in told["warnings"])
    names = [s.name for s in survey.cable.stations]
    assert 0 < len(told["stations"]) < len(names)
    for segment, other in zip(told["segments"], others, strict=True):  # a bend needs the next one
        known = f"{int(other) + 1:03d}" in others
        assert (segment["bend_mm_per_m"][0] is not None) == known
    for row in told["axis"]["profile"]:
        assert any(s["from_m"] <= row["position_m"] <= s["to_m"] + 0.01 for s in told["segments"])


def test_where_no_segment_has_anything_the_run_is_refused(rendered, tmp_path, monkeypatch):
    def run(self, name, pairs):
        if name == "match":
            raise StageError("match", "Block1 has no marks", "film something")
        ordinary(self, name, pairs)

    ordinary = Chain.run
    monkeypatch.setattr(Chain, "run", run)
    with pytest.raises(StageError, match="Block1 has no marks"):
        make_product(read_survey(rendered / "survey.toml"), tmp_path / "run", silent, assignments=CUT)
    assert not (tmp_path / "run" / "report.json").exists()


def test_cut_otherwise_nothing_of_the_earlier_cut_is_left_to_be_opened(long_run, rendered, tmp_path):
    run = tmp_path / "run"
    shutil.copytree(long_run, run)
    survey = read_survey(rendered / "survey.toml")
    shutil.copytree(run / "segments" / "002", run / "segments" / "009")
    make_product(survey, run, silent, assignments=CUT)
    assert not (run / "segments" / "009").exists()
    cut = json.loads((run / "report.json").read_text())
    make_product(survey, run, silent, assignments=("segments.frames=0",))
    assert not list((run / "segments").glob("*"))
    assert open_run(run).mosaic is not None
    whole = json.loads((run / "report.json").read_text())
    assert "segments" not in whole
    for one, other in zip(whole["stations"], cut["stations"], strict=True):
        assert abs(one["diameter_mm"] - other["diameter_mm"]) < 2 * np.hypot(
            one["sigma_mm"], other["sigma_mm"]
        )
    make_product(survey, run, silent, assignments=CUT)
    assert not (run / "products" / "all-mosaic.npz").exists()
    with pytest.raises(StageError, match="choose one of the folders in"):
        open_run(run)
