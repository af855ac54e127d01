"""report.json and the tables say what the run found, read back by json and csv."""

import csv
import json

import pytest

from pipeline.core.files import write_json
from pipeline.report.steel.collect import collect
from pipeline.report.steel.document import report_tree
from pipeline.report.steel.spreadsheets import write_spreadsheets
from tests.report.steel import sample


def read_json(path):
    def refuse(constant):
        raise ValueError(f"{constant} is not JSON")

    return json.loads(path.read_text(encoding="utf-8"), parse_constant=refuse)


def read_csv(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def tree_of(tmp_path, **changes):
    write_json(
        tmp_path / "report.json", report_tree(collect(sample.run(**changes), {"register": 1.5}, 321.0))
    )
    return read_json(tmp_path / "report.json")


def test_report_json_holds_the_contract(tmp_path):
    tree = tree_of(tmp_path)
    assert (tree["format"], tree["kind"], tree["name"]) == (1, "steel", "hall-3")
    assert tree["frame"] == {"base": "S01", "north_deg": 90.0}
    assert tree["stations"][1]["parent"] == "S01"
    assert len(tree["stations"][1]["rotation"]) == 3
    assert tree["gross"][0]["kind"] == "moved"
    assert tree["timing_s"] == {"register": 1.5}
    assert tree["comparison"][4]["chained"]["offset_mm"] == 8.0
    assert tree["comparison"][4]["icp"]["position_m"] == pytest.approx([40.02, 0.0, 0.0])
    assert tree["columns"][0]["direction"] == "north-east"
    assert tree["columns"][0]["ratio"] == pytest.approx(381.57, abs=0.01)
    assert tree["deflection"]["largest_node"] == "N003"
    assert [row["support"] for row in tree["deflection"]["rows"]].count(True) == 4
    assert set(tree["members"]) == {"rods", "balls", "columns"}
    assert tree["fusion"] is None


def test_what_is_not_known_is_null(tmp_path):
    tree = tree_of(tmp_path)
    assert tree["nodes"][5]["size_mm"] is None
    assert tree["nodes"][5]["rods_m"] == [None, None, None]


def test_a_fusion_is_told_without_its_single_distances(tmp_path):
    fused = tree_of(tmp_path, fusion=sample.fusion())["fusion"]
    assert fused["pairs"] == [{"name": "sphere 1", "residual_mm": 5.0}]
    assert "residuals_mm" not in fused
    assert fused["photos"] == []
    assert fused["median_mm"] == 1.44


def test_the_tables_hold_the_figures(tmp_path):
    names = write_spreadsheets(tmp_path, collect(sample.run(), {}, 0.0))
    assert names == ("stations.csv", "residuals.csv", "nodes.csv", "columns.csv", "deflection.csv")
    station = read_csv(tmp_path / "stations.csv")[1]
    assert (station["name"], station["x_m"], station["sigma_mm"], station["r00"]) == (
        "S02", "10.00000", "0.400", "1.000000000000",
    )  # fmt: skip
    column = read_csv(tmp_path / "columns.csv")[0]
    assert (column["north_mm"], column["east_mm"], column["height_difference_mm"]) == (
        "32.100",
        "17.300",
        "13914.0",
    )
    assert (column["north_ratio"], column["east_ratio"], column["over_limit"]) == ("1/433", "1/804", "yes")
    assert read_csv(tmp_path / "columns.csv")[2]["east_ratio"] == ""  # it does not lean that way at all
    nodes = read_csv(tmp_path / "nodes.csv")
    assert (nodes[0]["eccentricity_mm"], nodes[0]["significant"], nodes[5]["eccentricity_mm"]) == (
        "10.000",
        "yes",
        "",
    )
    assert read_csv(tmp_path / "deflection.csv")[2]["deflection_mm"] == "9.500"
    assert len(read_csv(tmp_path / "residuals.csv")) == 41


def test_a_survey_of_target_lists_leaves_two_tables(tmp_path):
    assert write_spreadsheets(tmp_path, collect(sample.targets_only(), {}, 0.0)) == (
        "stations.csv",
        "residuals.csv",
    )
    assert sorted(path.name for path in tmp_path.iterdir()) == ["residuals.csv", "stations.csv"]
