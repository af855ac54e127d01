"""A steel survey is read strictly: what is wrong is told in one sentence with the key's full name."""

import numpy as np
import pytest

from pipeline.core.errors import StageError
from pipeline.steel.survey import read_steel_survey
from pipeline.steel.survey_records import LengthUnit, Scanner
from pipeline.steel.target_table import read_target_table

WHOLE = """
format = 1
kind = "steel"
name = "hall-3"
[scanner]
range_sigma_mm = 2.0
angle_sigma_arcsec = 8.0
levelled = true
level_sigma_arcsec = 5.0
[targets]
radius_mm = 72.5
[[station]]
name = "S01"
cloud = "S01.e57"
[[station]]
name = "S02"
cloud = "S02.PTS"
unit = "mm"
targets = "S02.csv"
base = true
[[control]]
name = "T01"
position_m = [1.0, 2.0, 3.0]
[[control]]
name = "T02"
position_m = [1, 2, 4]
sigma_mm = 0.5
[[control]]
name = "T03"
position_m = [5.0, 2.0, 3.0]
[structure]
north_deg = 12.0
rod_diameters_mm = [60.0, 89.0]
span_m = 24.0
[[column]]
name = "8-N"
place_m = [0.0, 6.0]
bottom_m = 0.5
top_m = 5.5
[photos]
source = "photos"
focal_px = 1500.0
[options.register]
rounds = 20
"""


@pytest.fixture
def written(tmp_path):
    for name in ("S01.e57", "S02.PTS", "S02.csv"):
        (tmp_path / name).write_text("")
    (tmp_path / "photos").mkdir()

    def write(text):
        path = tmp_path / "survey.toml"
        path.write_text(text)
        return path

    return write


def test_the_example_is_read_in_full(written):
    survey = read_steel_survey(written(WHOLE))
    first, second = survey.stations
    assert (survey.name, survey.base.name) == ("hall-3", "S02")
    assert survey.scanner.range_sigma_m == 0.002
    assert survey.scanner.angle_sigma_rad == pytest.approx(np.radians(8 / 3600))
    assert first.cloud.is_absolute()
    assert (first.unit, second.unit) == (LengthUnit.METRE, LengthUnit.MILLIMETRE)
    assert [(c.name, c.sigma_mm) for c in survey.control] == [("T01", 1.0), ("T02", 0.5), ("T03", 1.0)]
    assert (survey.structure.deflection_limit, survey.columns[0].top_m) == (250.0, 5.5)
    assert survey.photos.source.name == "photos"
    assert survey.stage_options("register") == {"rounds": 20}


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('kind = "steel"', 'kind = "cable"', 'kind is "cable"'),
        ('kind = "steel"', "", "kind is missing"),
        ("format = 1", "format = 2", "format is 2"),
        ("levelled = true", "leveled = true", "unknown key scanner.leveled; perhaps scanner.levelled"),
        ("radius_mm = 72.5", "radius_mm = -1", "targets.radius_mm is -1"),
        ("radius_mm = 72.5", 'radius_mm = "x"', "targets.radius_mm is "),
        ("radius_mm = 72.5", "", "targets.radius_mm is missing, but the targets of station[S01]"),
        ('name = "S02"', 'name = "s01"', 'station.name "s01" is there more than once'),
        ('name = "S02"', 'name = "a/b"', 'station.name "a/b" cannot be the name of a file'),
        ('unit = "mm"', 'unit = "cm"', "station[S02].unit"),
        ('cloud = "S01.e57"', 'cloud = "gone.e57"', "station[S01].cloud: "),
        ('cloud = "S01.e57"', 'cloud = "S02.csv"', "is of a kind that is not known"),
        ('cloud = "S01.e57"', "base = true\ntargets = 'S02.csv'", "station[S01].base and station[S02].base"),
        ('cloud = "S01.e57"', "", "station[S01] has neither cloud nor targets"),
        ('targets = "S02.csv"', 'targets = "no.csv"', "station[S02].targets: "),
        ('name = "T02"', 'name = "T01"', 'control.name "T01" is there more than once'),
        ("position_m = [1, 2, 4]", "position_m = [1, 2]", "control[T02].position_m has 2 values"),
        (
            "position_m = [1, 2, 4]",
            "position_m = [1, 2, 3]",
            "control[T01].position_m is the place of another",
        ),
        ("top_m = 5.5", "top_m = 0.1", "column[8-N].top_m = 0.1 does not lie above"),
        ('source = "photos"', 'source = "none"', "photos.source: "),
    ],
)
def test_what_is_wrong_is_told_with_its_key(written, old, new, said):
    with pytest.raises(StageError) as caught:
        read_steel_survey(written(WHOLE.replace(old, new, 1)))
    assert said in str(caught.value)
    assert str(caught.value).startswith("survey: ")


def test_one_station_is_too_few(written):
    text = 'format = 1\nkind = "steel"\nname = "x"\n[[station]]\nname = "S01"\ntargets = "S02.csv"\n'
    with pytest.raises(StageError, match="at least two"):
        read_steel_survey(written(text))


def test_two_control_targets_define_no_frame(written):
    text = WHOLE.replace('[[control]]\nname = "T03"\nposition_m = [5.0, 2.0, 3.0]\n', "")
    with pytest.raises(StageError, match="control has 2 targets"):
        read_steel_survey(written(text))


def test_a_missing_file_is_told(tmp_path):
    with pytest.raises(StageError, match=r"survey\.toml cannot be read"):
        read_steel_survey(tmp_path / "survey.toml")


@pytest.mark.parametrize(
    ("content", "said"), [(b"format = ", "is no TOML"), (b"\xff\xfe\x00", "is no UTF-8 text")]
)
def test_a_file_that_is_no_survey_is_told(tmp_path, content, said):
    (tmp_path / "survey.toml").write_bytes(content)
    with pytest.raises(StageError, match=said):
        read_steel_survey(tmp_path / "survey.toml")


def test_a_table_of_targets_gives_points_with_their_noise(tmp_path):
    path = tmp_path / "S01.csv"
    path.write_text("name,x,y,z,sigma_mm\nT01,10,0,0,\n\nT02,1,2,3,0.5\n")
    scanner = Scanner(range_sigma_mm=2.0, angle_sigma_arcsec=8.0)
    far, near = read_target_table(path, "S01", scanner).features
    across = 10 * np.radians(8 / 3600)
    assert np.sqrt(np.diag(far.covariance)) == pytest.approx([0.002, across, across])
    assert np.allclose(near.covariance, 0.0005**2 * np.eye(3))
    assert (near.name, near.place.tolist()) == ("T02", [1, 2, 3])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "has no column name"),
        ("name,x,y\nT1,1,2\n", "has no column z"),
        ("name,x,y,z,w\nT1,1,2,3,4\n", 'has an unknown column "w"'),
        ("name,x,y,z\n", "has no target"),
        ("name,x,y,z\nT1,1,2,3\nT1,4,5,6\n", 'has the target "T1" more than once'),
        ("name,x,y,z\nT1,1,2,nan\n", "line 2: z is nan"),
        ("name,x,y,z\nT1,1,,3\n", 'line 2: y is ""'),
        ("name,x,y,z\n,1,2,3\n", "line 2 has no name"),
        ("name,x,y,z,sigma_mm\nT1,1,2,3,0\n", "sigma_mm is 0"),
    ],
)
def test_a_bad_table_of_targets_is_refused(tmp_path, text, said):
    path = tmp_path / "S01.csv"
    path.write_text(text)
    with pytest.raises(StageError) as caught:
        read_target_table(path, "S01", Scanner())
    assert said in str(caught.value)
