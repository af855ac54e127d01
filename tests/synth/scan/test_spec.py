"""A specification is read strictly: every refusal names the key and what to do."""

import re
from pathlib import Path

import pytest

from pipeline.core.errors import StageError
from synth.scan.spec import Level, read_scan_spec

ROOT = Path(__file__).parents[3]
SPECS = sorted((ROOT / "specs/steel").glob("*.toml"))


@pytest.mark.parametrize("path", SPECS, ids=lambda path: path.stem)
def test_the_specifications_of_the_repository_are_good(path):
    assert read_scan_spec(path).name


def test_there_are_specifications_of_both_levels():
    assert {read_scan_spec(path).level for path in SPECS} == set(Level)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[scanner]\nstep = 0.2", "unknown key scanner.step"),
        ("[structure]\nbays = [2]", "structure.bays has 1 values"),
        ("[structure]\nmodule_m = 0.0", "structure.module_m is 0"),
        ("[structure]\nball_diameter_mm = 95.0", "structure.ball_diameter_mm leaves no room"),
        ("[structure]\ntilt_mm = [9.0, 3.0]", "structure.tilt_mm is 9.0 to 3.0"),
        ('[scanner]\nformat = "dxf"', 'scanner.format is "dxf"'),
        ("[scanner]\nelevation_deg = [10.0, -10.0]", "scanner.elevation_deg is 10.0 to -10.0"),
        ("[stations]\ncount = [0, 3]", "stations.count leaves no station"),
        ("[scanner]\nmin_range_m = 99.0", "scanner.min_range_m is not below"),
        ("[targets]\nleast = 11", "targets.least is above targets.nearest"),
        ('[[gross.misnamed]]\nstation = "S01"', "gross.misnamed needs the targets' lists"),
    ],
)
def test_what_cannot_be_is_refused_by_name(tmp_path, text, said):
    file = tmp_path / "spec.toml"
    file.write_text(f'name = "x"\n{text}\n', encoding="utf-8")
    with pytest.raises(StageError, match=re.escape(said)):
        read_scan_spec(file)


def test_a_name_is_needed_and_a_file_too(tmp_path):
    file = tmp_path / "spec.toml"
    file.write_text("seed = 1\n", encoding="utf-8")
    with pytest.raises(StageError, match="name is missing"):
        read_scan_spec(file)
    with pytest.raises(StageError, match="cannot be read"):
        read_scan_spec(tmp_path / "none.toml")
    file.write_text("name = \n", encoding="utf-8")
    with pytest.raises(StageError, match="is not TOML"):
        read_scan_spec(file)
