"""The report tells exactly what the run found, in its own units, and adds nothing."""

import math
from pathlib import Path

import numpy as np
import pytest

from pipeline.core.vocabulary import Lens, Poses
from pipeline.report.steel.collect import collect
from pipeline.steel.photo_records import OrientedPhotos
from pipeline.steel.registration_records import Residual
from pipeline.steel.survey_records import ControlTarget
from tests.report.steel import sample


@pytest.fixture(scope="module")
def report():
    return collect(sample.run(), {"register": 1.5}, 321.0)


def test_a_station_carries_its_sigmas_in_millimetres_and_arc_seconds(report):
    station = report.stations[2]
    assert station.position_m == pytest.approx((20.0, 0.0, 0.0))
    assert station.sigma_mm == pytest.approx(0.4)
    assert station.sigma_xyz_mm == pytest.approx((0.4, 0.4, 0.4))
    assert station.sigma_arcsec == pytest.approx(math.degrees(2.4e-5) * 3600)
    assert (station.ring, station.parent) == (2, "S02")


def test_the_base_defines_the_frame_and_has_no_sigma(report):
    assert (report.base, report.stations[0].sigma_mm, report.stations[0].parent) == ("S01", 0.0, "")


def test_with_control_targets_no_station_is_the_base():
    control = (ControlTarget(name="T01", position_m=(0.0, 0.0, 0.0)),)
    assert collect(sample.run(survey=sample.survey(control=control)), {}, 0.0).base == ""


def test_a_targets_sigma_is_that_of_one_coordinate(report):
    assert report.targets[0].sigma_mm == pytest.approx(math.sqrt((0.09 + 0.16 + 0.25) / 3))
    assert [row.seen_by for row in report.targets] == [2, 3, 4, 3, 3, 3, 2, 1]


def test_the_other_ways_are_measured_from_the_adjusted_place(report):
    last = report.comparison[-1]
    assert (last.station, last.position) == ("S05", 4)
    assert last.chained_offset_mm == 8.0
    assert last.chained_m == pytest.approx((40.008, 0.0, 0.0))
    assert last.icp_offset_mm == pytest.approx(20.0)
    assert last.icp_turn_arcsec == pytest.approx(0.0, abs=1e-6)


def test_without_icp_its_columns_are_unknown():
    row = collect(sample.run(icp=None), {}, 0.0).comparison[-1]
    assert row.icp_m is None
    assert math.isnan(row.icp_offset_mm)


def test_a_column_reads_as_in_the_papers_table(report):
    column = report.columns[0]
    assert (column.north_mm, column.east_mm) == (32.1, 17.3)
    assert column.deviation_mm == pytest.approx(math.hypot(32.1, 17.3))
    assert column.direction_deg == pytest.approx(math.degrees(math.atan2(17.3, 32.1)))
    assert column.height_m == pytest.approx(13.914)
    assert column.ratio == pytest.approx(13_914 / math.hypot(32.1, 17.3))
    assert column.over_limit
    assert column.certain


def test_a_deviation_within_two_sigma_of_the_limit_is_not_certain(report):
    near = report.columns[2]  # 34.8 +- 0.3 mm against 35 mm
    assert not near.over_limit
    assert not near.certain


def test_nodes_keep_ball_rods_and_both_centres(report):
    node = report.nodes[0]
    assert node.size_mm == pytest.approx(10.0)
    assert np.subtract(node.ball_m, node.rods_m) * 1000 == pytest.approx([6.0, 8.0, 0.0])
    assert np.subtract(node.by_perpendiculars_m, node.rods_m) * 1000 == pytest.approx([0, 0, 0.7])
    assert math.isnan(report.nodes[5].size_mm)


def test_members_are_told_from_end_to_end(report):
    assert (len(report.rods), len(report.uprights), len(report.balls)) == (7, 2, 6)
    assert report.rods[0].start_m == pytest.approx(sample.CORNERS[0])
    assert report.rods[0].end_m == pytest.approx(sample.CORNERS[1])
    assert report.rods[0].radius_mm == pytest.approx(30.0)
    assert report.rods[0].radius_sigma_mm == pytest.approx(0.2)
    assert report.balls[0].sigma_mm == pytest.approx(0.3)


def test_the_fusion_tells_scale_and_what_is_left_open():
    fused = collect(sample.run(fusion=sample.fusion()), {}, 0.0).fusion
    assert fused.scale == 1.25
    assert fused.scale_sigma_percent == pytest.approx(0.02)
    assert fused.pairs == (("sphere 1", 5.0),)
    assert fused.undetermined == ("a turn about the axis",)


def test_residuals_and_gross_errors_pass_unchanged(report):
    assert all(isinstance(row, Residual) for row in report.residuals)
    assert report.gross == (sample.MOVED, sample.MISNAMED, sample.MOVED_TOO)
    assert report.warnings == ("S05 hangs on two targets alone.",)


def test_cameras_are_told_in_the_site_frame():
    poses = Poses(rotations=np.eye(3)[None], translations=np.array([[-4.0, 0.0, 0.0]]))  # centre (4, 0, 0)
    lens = Lens(width_px=8, height_px=6, focal_px=9.0, principal_point_px=(4.0, 3.0), division_lambda=0.0)
    photos = OrientedPhotos(
        files=(Path("roof/a.jpg"),), lens=lens, poses=poses, points=np.zeros((0, 3)),
        observations=np.zeros((0, 2), dtype=np.int64), pixels=np.zeros((0, 2)), left_out=(),
        reprojection_px=0.4,
    )  # fmt: skip
    fused = collect(sample.run(fusion=sample.fusion(), photos=photos), {}, 0.0).fusion
    # scale 1.25 and the shift of the sample
    assert fused.photos == (("a.jpg", (6.0, 2.0, 3.0)),)
