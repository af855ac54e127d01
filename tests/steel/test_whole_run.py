"""A scanned frame from the clouds to the figures, as a person runs it, against its truth.

Bounds have two sides: errors that are too small would mean that the truth has leaked.
"""

import json
import shutil
from pathlib import Path

import pytest

from tests.command import ROOT, pipeline, synth

SPECS = ROOT / "specs" / "steel"
SEED = 31


@pytest.fixture(scope="module")
def survey(tmp_path_factory):
    """Four stations in a frame of four pyramids, two nodes of it 10 mm eccentric."""
    folder = tmp_path_factory.mktemp("scan") / "survey"
    done = synth("scan", SPECS / "small.toml", folder, "--seed", SEED, "--quiet")
    assert done.code == 0, done.stderr[-2000:]
    return folder


@pytest.fixture(scope="module")
def finished(survey, tmp_path_factory):
    folder = tmp_path_factory.mktemp("steel") / "run"
    words = ("--truth", survey / "truth.json", "--events", "json")
    done = pipeline("steel", survey / "survey.toml", "--out", folder, *words)
    assert done.code == 0, done.stderr[-2000:]
    return folder, done


@pytest.fixture(scope="module")
def evaluation(finished, survey, tmp_path_factory):
    path = tmp_path_factory.mktemp("evaluation") / "evaluation.json"
    words = ("--truth", survey / "truth.json", "--json", path)
    assert pipeline("evaluate", finished[0], *words).code == 0
    return json.loads(path.read_text())


def test_everything_that_a_person_opens_is_there(finished):
    folder, done = finished
    tables = {"stations.csv", "residuals.csv", "nodes.csv", "columns.csv", "deflection.csv"}
    opened = {"report.html", "report.json", "cloud.ply", "members.glb", "members.ply"}
    assert {path.name for path in folder.iterdir()} >= tables | opened
    assert "4 stations" in done.stdout
    assert not list(folder.rglob("*.part*"))


def test_stages_tell_of_themselves_in_order_and_close_once(finished):
    closed = [e["stage"] for e in finished[1].events if not e["block"] and e["done"] >= e["total"]]
    wanted = [
        "clouds",
        "targets",
        "register",
        "compare",
        "tiles",
        "members",
        "measure",
        "photos",
        "fuse",
        "report",
    ]
    assert closed == wanted


def test_stations_stand_within_a_millimetre_and_twenty_seconds(evaluation):
    stations = evaluation["stations"]
    assert 0.01 < stations["rms_mm"] < 1.0
    assert 1.0 < stations["rms_arcsec"] < 20.0
    assert stations["sigma"]["within_percent"] >= 66  # three stations share the base's draw
    assert evaluation["targets"]["matched"] == evaluation["targets"]["true"]
    assert evaluation["gross"] == {"named": [], "missed": [], "false": []}


def test_eccentric_nodes_are_found_and_no_others(evaluation):
    nodes = evaluation["nodes"]
    assert (nodes["eccentric"], nodes["missed"], nodes["false"]) == (2, 0, 0)
    assert 0.001 < nodes["amount_largest_mm"] < 0.5


def test_columns_lean_as_they_do_within_a_millimetre(evaluation):
    columns = evaluation["columns"]
    assert (columns["right"], columns["wrong"], columns["missing"]) == (4, 0, [])
    assert 0.01 < columns["component_largest_mm"] < 1.0


def test_the_grid_hangs_as_it_does(evaluation):
    deflection = evaluation["deflection"]
    assert deflection["verdict_right"]
    assert 0.001 < deflection["largest_mm"] < 0.5


def test_rods_and_balls_are_found_and_nothing_else(evaluation):
    rods, balls = evaluation["rods"], evaluation["balls"]
    assert rods["found"] >= 0.97 * rods["true"]
    assert balls["found"] >= 0.9 * balls["true"]
    assert (rods["doubled"], balls["false"]) == (0, 0)
    assert rods["false"] <= 1


def test_a_second_run_finds_everything_made(finished, survey):
    done = pipeline("steel", survey / "survey.toml", "--out", finished[0], "--events", "none")
    assert done.code == 0
    assert done.seconds < 0.5 * finished[1].seconds


def test_without_its_cloud_a_finished_run_is_refused_and_set_aside(finished, survey, tmp_path):
    moved, run = tmp_path / "survey", tmp_path / "run"
    shutil.copytree(survey, moved)
    shutil.copytree(finished[0], run)
    (moved / "clouds" / "S01.e57").unlink()
    done = pipeline("steel", moved / "survey.toml", "--out", run)
    assert done.code == 2
    assert done.stderr.count("\n") == 1
    assert "S01" in done.stderr
    assert not (run / "report.json").exists()
    assert (run / "outdated" / "report.json").exists()


def test_a_gross_error_is_named_from_the_command_line(tmp_path: Path):
    survey, run = tmp_path / "survey", tmp_path / "run"
    assert synth("scan", SPECS / "gross.toml", survey, "--seed", SEED, "--quiet").code == 0
    done = pipeline("steel", survey / "survey.toml", "--out", run, "--events", "none")
    assert done.code == 0, done.stderr
    truth = json.loads((survey / "truth.json").read_text())
    for gross in truth["gross"]:
        assert gross["target"] in done.stdout
        assert gross["kind"] != "misnamed" or gross["station"] in done.stdout
