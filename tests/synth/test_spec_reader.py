"""A specification is read strictly: every refusal names the key and what to do."""

import re
from pathlib import Path

import pytest

from pipeline.core.errors import StageError
from synth.spec import MaterialKind, Spec
from synth.spec_reader import parse_spec, read_spec

ROOT = Path(__file__).parents[2]


def test_an_empty_specification_is_all_defaults():
    assert parse_spec({}) == Spec()


def test_values_arrive_in_their_types():
    table = {
        "cable": {"diameter_mm": 95, "material": {"kind": "painted"}},
        "lens": {"principal_point_px": [480, 301]},
    }
    spec = parse_spec(table)
    assert spec.cable.diameter_mm == 95.0
    assert spec.cable.material.kind is MaterialKind.PAINTED
    assert spec.lens.principal_point_px == (480.0, 301.0)


@pytest.mark.parametrize("name", ["demo", "gate/paper", "gate/sway"])
def test_the_shipped_specifications_are_good(name):
    spec = read_spec(ROOT / "specs" / f"{name}.toml")
    assert spec.name == name.removeprefix("gate/")
    assert len(spec.blocks) == 4
    assert spec.lens.division_lambda == -0.02


DEFECT = {"kind": "dent", "height_mm": 1, "position_m": 0.1, "azimuth_deg": 20}
STATIONS = {"station": [{"name": "A", "position_m": 0.1}, {"name": "A", "position_m": 0.2}]}


@pytest.mark.parametrize(
    ("table", "key"),
    [
        ({"cabel": {}}, "cabel is unknown"),
        ({"cable": {"colour": 1}}, "cable.colour is unknown"),
        (
            {"cable": {"station": [{"name": "A", "position_m": 0.1, "diam": 1}]}},
            "cable.station[0].diam is unknown",
        ),
        ({"cable": {"station": [{"name": "A"}]}}, "cable.station[0].position_m is missing"),
        ({"cable": 5}, "cable must be a table"),
        ({"cable": STATIONS}, "cable.station has a name twice"),
        ({"cable": {"station": [{"name": "A", "position_m": 0.9}]}}, "cable.station[0].position_m is 0.9"),
        ({"cable": {"diameter_mm": -1}}, "cable.diameter_mm is -1"),
        ({"cable": {"material": {"dirt": 1.5}}}, "cable.material.dirt is 1.5"),
        ({"cable": {"material": {"kind": "wood"}}}, "cable.material.kind is 'wood'"),
        ({"cable": {"fillet": {"width_mm": 200.0}}}, "cable.fillet.width_mm is 200"),
        ({"robot": {"travel_m": 0}}, "robot.travel_m is 0"),
        ({"robot": {"travel_m": float("nan")}}, "robot.travel_m is nan"),
        ({"robot": {"frames": 1}}, "robot.frames is 1"),
        ({"robot": {"frames": 2.5}}, "robot.frames is 2.5"),
        ({"robot": {"frames": True}}, "robot.frames is True"),
        ({"robot": {"synchronised": 1}}, "robot.synchronised is 1"),
        ({"robot": {"standoff_m": 0.05}}, "robot.standoff_m is 0.05"),
        ({"robot": {"angles_deg": [0, 360]}}, "robot.angles_deg names the same place twice"),
        ({"lens": {"division_lambda": -1.2}}, "lens.division_lambda is -1.2"),
        ({"lens": {"principal_point_px": [1]}}, "lens.principal_point_px has 1 values"),
        ({"lens": {"width_px": 961}}, "lens.width_px, lens.height_px are odd"),
        ({"sensor": {"video_crf": 60}}, "sensor.video_crf is 60"),
        ({"depth_frames": [24]}, "depth_frames[0] is 24"),
        ({"name": ""}, "name is empty"),
        ({"cable": {"defect": [DEFECT | {"kind": "hole"}]}}, "cable.defect[0].kind is 'hole'"),
        ({"cable": {"defect": [DEFECT | {"position_m": 0.5}]}}, "cable.defect[0].position_m is 0.5"),
        ({"cable": {"defect": [DEFECT | {"width_mm": 180}]}}, "cable.defect[0].width_mm is 180"),
        ({"cable": {"defect": [DEFECT | {"length_mm": 3}]}}, "cable.defect[0].height_mm is 1.0"),
        ({"cable": {"defect": [DEFECT], "fillet": {}}}, "cable.defect does not go with cable.fillet"),
        ({"cable": {"bow_mm": 80}}, "robot.standoff_m is 0.3"),
        ({"cable": {"material": {"drawn_out": 0.5}}}, "cable.material.drawn_out is 0.5"),
        ({"cable": {"material": {"gloss": 2}}}, "cable.material.gloss is 2"),
        ({"sensor": {"readout_share": 1.5}}, "sensor.readout_share is 1.5"),
        ({"survey": {"lost_blocks": ["Block5"]}}, "survey.lost_blocks[0] is 'Block5'"),
        ({"robot": {"cameras": 1}, "survey": {"lost_blocks": ["Block1"]}}, "survey.lost_blocks leaves no"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_cannot_be_is_refused_by_its_full_name(table, key):
    with pytest.raises(StageError, match=re.escape(key)) as refusal:
        parse_spec(table)
    assert str(refusal.value).count("\n") == 0
    assert refusal.value.remedy


def test_stations_must_be_in_order_and_agree_on_giving_diameters():
    rows = [{"name": "A", "position_m": 0.2}, {"name": "B", "position_m": 0.1}]
    with pytest.raises(StageError, match="not in order"):
        parse_spec({"cable": {"station": rows}})
    rows = [{"name": "A", "position_m": 0.1, "diameter_mm": 100.0}, {"name": "B", "position_m": 0.2}]
    with pytest.raises(StageError, match="for some stations"):
        parse_spec({"cable": {"station": rows}})


def test_a_missing_file_and_broken_toml_are_refused(tmp_path):
    with pytest.raises(StageError, match="cannot be read"):
        read_spec(tmp_path / "none.toml")
    broken = tmp_path / "broken.toml"
    broken.write_text("seed = = 1")
    with pytest.raises(StageError, match="is not TOML"):
        read_spec(broken)
