"""Things that a station's cloud shows are named by a point on them; unclear rows are refused by line."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.core.errors import StageError
from pipeline.core.events import silent
from pipeline.steel.clouds import StationCloud
from pipeline.steel.name_table import read_name_table, sought, with_names
from pipeline.steel.records import Feature, FeatureKind, StationFeatures
from pipeline.steel.registration_options import TargetOptions
from pipeline.steel.station_features import station_features
from pipeline.steel.survey import steel_survey_from
from pipeline.steel.survey_records import Scanner, ScanStation, SteelSurvey
from tests.steel.test_planes import HEIGHT_M, WALL_M, scanned

HEADER = "name,kind,x,y,z\n"


def feature(kind, place, direction=(0.0, 0, 1), radius_m=0.0, reach_m=2.0, name=""):
    d = np.array(direction, dtype=float)
    size = {FeatureKind.POINT: 3, FeatureKind.LINE: 4, FeatureKind.PLANE: 3}[kind]
    return Feature(
        kind=kind,
        name=name,
        place=np.array(place, dtype=float),
        direction=np.zeros(3) if kind is FeatureKind.POINT else d / np.linalg.norm(d),
        frame=np.eye(3),
        covariance=np.eye(size) * 1e-6,
        radius_m=radius_m,
        points=500,
        rms_m=0.002,
        reach_m=reach_m,
    )


FOUND = StationFeatures(
    station="S01",
    features=(
        feature(FeatureKind.POINT, [2, 0, 0], radius_m=0.0725),
        feature(FeatureKind.POINT, [0, 3, 1], radius_m=0.0725),
        feature(FeatureKind.LINE, [4, 0, 0], radius_m=0.15),
        feature(FeatureKind.LINE, [4, 0.6, 0], radius_m=0.15),
        feature(FeatureKind.PLANE, [5, 5, -1.6], [0, 0, 1], reach_m=4.0),
        feature(FeatureKind.PLANE, [8, 0, 0], [-1, 0, 0], reach_m=3.0),
    ),
)


@pytest.fixture
def names_of(tmp_path):
    """Names of the features of FOUND after a table of some rows."""

    def given(rows, found=FOUND, options=None):
        path = tmp_path / "S01_names.csv"
        path.write_text(HEADER + rows)
        return [f.name for f in with_names(found, read_name_table(path), options or TargetOptions()).features]

    return given


def test_a_point_on_or_in_a_thing_names_it_and_nothing_else(names_of):
    rows = "T7,target,2.05,0.05,0\n8-N,axis,3.85,0,1.2\nfloor,plane,1,-1,-1.6\n8-N,plane,8.0,2,1\n"
    assert names_of(rows) == ["T7", "", "8-N", "", "floor", "8-N"]
    # a point on the axis itself, as from a drawing, and spaces
    assert names_of(" 7-P , Axis ,4.0,0.6,-1\n\n") == ["", "", "", "7-P", "", ""]


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        (
            "8-N,axis,6,3,0\n",
            'line 2: station S01 shows no axis within 0.25 m of the point of "8-N" (the nearest',
        ),
        ("8-N,axis,4,0,9\n", "line 2: station S01 shows no axis"),
        ("8-N,axis,4,0.29,0\n", 'the point of "8-N" lies 140 mm off one axis and 160 mm off another'),
        ("edge,plane,8,1,-1.6\n", 'the point of "edge" lies 0 mm off one plane and 0 mm off another'),
        ("T1,target,2,0,0\nT2,target,2,0.05,0\n", 'line 3 names the same target "T2" that'),
        ("a,axis,4,0,0\na,axis,4,0.6,0\n", 'line 3 names a second axis "a"'),
        (",axis,4,0,0\n", "line 2 has no name"),
        ("a,column,4,0,0\n", 'line 2: kind is "column"; write one of target, axis, plane'),
        ("a,axis,4,,0\n", 'line 2: y is ""'),
        ("a,axis,4,nan,0\n", "line 2: y is nan"),
        ("", "names nothing"),
    ],
)
def test_what_is_not_clear_is_refused_by_its_row(names_of, rows, said):
    with pytest.raises(StageError) as caught:
        names_of(rows)
    assert said in str(caught.value)
    assert "S01_names.csv" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_station_that_shows_none_of_the_kind_is_told(names_of):
    with pytest.raises(StageError, match=r"it shows no plane at all"):
        names_of("a,plane,4,0,0\n", replace(FOUND, features=FOUND.features[:4]))


def test_a_target_cannot_be_named_where_targets_are_listed(tmp_path):
    table, targets = tmp_path / "S01_names.csv", tmp_path / "S01.csv"
    table.write_text(HEADER + "T7,target,2,0,0\n")
    station = ScanStation(name="S01", names=table, targets=targets)
    survey = SteelSurvey(
        format=1, kind="steel", name="x", scanner=Scanner(), stations=(station, ScanStation(name="S02"))
    )
    with pytest.raises(
        StageError, match=r'line 2 names the target "T7", but .*S01.csv lists the targets'
    ) as said:
        station_features(station, None, survey, TargetOptions(), tmp_path, silent)
    assert "leave the row out" in str(said.value)


def test_kinds_that_are_off_are_looked_for_where_one_is_named_and_only_that_is_kept(names_of, tmp_path):
    path = tmp_path / "names.csv"
    path.write_text(HEADER + "8-N,axis,4,0,0\n")
    off = TargetOptions(planes=False, axes=False)
    wanted = sought(off, read_name_table(path))
    assert (wanted.planes, wanted.axes) == (False, True)
    assert names_of("8-N,axis,4,0,0\n", options=off) == ["", "", "8-N"]


def test_a_wall_named_in_a_real_cloud_is_fitted_to_its_points(tmp_path):
    cloud, table = tmp_path / "S01.npy", tmp_path / "names.csv"
    points = scanned(3)
    np.save(cloud, points)
    table.write_text(HEADER + f"north wall,plane,{WALL_M},1.0,0.4\n")
    station = ScanStation(name="S01", cloud=cloud, names=table)
    survey = SteelSurvey(
        format=1, kind="steel", name="x", scanner=Scanner(), stations=(station, ScanStation(name="S02"))
    )
    imported = StationCloud(station="S01", path=cloud, points=len(points), median_range_m=5.0)
    found = station_features(
        station, imported, survey, TargetOptions(planes=False, axes=False), tmp_path, silent
    )
    (wall,) = found.features
    assert wall.name == "north wall"
    assert abs(wall.direction[0]) == pytest.approx(1, abs=1e-6)
    off_m = WALL_M - wall.place[0]
    assert 0 < abs(off_m) < 4 * np.sqrt(wall.covariance[0, 0])
    # the floor was seen as well: it is left only because nobody named it
    table.write_text(HEADER + f"north wall,plane,{WALL_M},1.0,0.4\nfloor,plane,2,0,{-HEIGHT_M}\n")
    both = station_features(station, imported, survey, TargetOptions(axes=False), tmp_path, silent)
    assert {f.name for f in both.features} == {"north wall", "floor"}


def test_names_need_a_cloud_and_a_file(tmp_path):
    (tmp_path / "T.csv").write_text("name,x,y,z\nT1,1,2,3\n")
    (tmp_path / "N.csv").write_text(HEADER + "a,axis,1,2,3\n")
    (tmp_path / "S.xyz").write_text("1 2 3\n")
    second = {"name": "S02", "targets": "T.csv"}

    def survey(first):
        return steel_survey_from(
            {"format": 1, "kind": "steel", "name": "x", "station": [{"name": "S01", **first}, second]},
            tmp_path,
        )

    with pytest.raises(StageError, match=r"station\[S01\].names is given without station\[S01\].cloud"):
        survey({"targets": "T.csv", "names": "N.csv"})
    with pytest.raises(StageError, match=r"station\[S01\].names: .*M.csv does not exist"):
        survey({"cloud": "S.xyz", "names": "M.csv"})
    assert survey({"cloud": "S.xyz", "names": "N.csv"}).stations[0].names == (tmp_path / "N.csv").resolve()
