"""Sphere targets are found in a cloud, to within their sigmas, and nothing else is taken for one."""

import numpy as np
import pytest

from pipeline.core.events import silent
from pipeline.steel.range_image import range_image
from pipeline.steel.records import FeatureKind
from pipeline.steel.registration_options import TargetOptions
from pipeline.steel.survey_records import Scanner, ScanStation, SteelSurvey, Structure, Targets
from pipeline.steel.targets import find_targets
from tests.steel.scanned_spheres import scan

RADIUS_M = 0.0725
CENTRES = np.array(
    [
        [3.0, 1.0, 0.2],
        [-4.0, 0.001, 1.0],  # across the seam of the azimuth
        [0.5, -6.0, -0.6],
        [-5.0, 5.0, 2.0],
        [2.0, 8.0, 0.4],
        [9.0, -4.0, 1.1],
    ]
)
BALL = np.array([[1.0, -4.0, 1.5], [5.0, 3.0, 2.0]])


def survey(ball_diameters_mm=()):
    return SteelSurvey(
        format=1,
        kind="steel",
        name="x",
        scanner=Scanner(range_sigma_mm=2.0, angle_sigma_arcsec=8.0),
        targets=Targets(radius_mm=1000 * RADIUS_M),
        stations=(ScanStation(name="S1"), ScanStation(name="S2")),
        structure=Structure(ball_diameters_mm=ball_diameters_mm),
    )


def found_in(points, **known):
    return find_targets(points, "S1", survey(**known), TargetOptions(), silent).features


@pytest.fixture(scope="module")
def several():
    radii = np.full(len(CENTRES), RADIUS_M)
    return [found_in(scan(CENTRES, radii, seed)) for seed in range(3)]


def test_all_are_found_and_nothing_else(several):
    for features in several:
        assert len(features) == len(CENTRES)
        assert {(f.kind, f.name, f.radius_m) for f in features} == {(FeatureKind.POINT, "", RADIUS_M)}


def test_errors_are_as_large_as_the_sigmas_say(several):
    z, along = [], []
    for feature in (f for features in several for f in features):
        error = feature.place - CENTRES[np.argmin(np.linalg.norm(CENTRES - feature.place, axis=1))]
        z.append(np.linalg.solve(np.linalg.cholesky(feature.covariance), error))
        along.append(error @ feature.place / np.linalg.norm(feature.place))
    assert 0.7 < np.sqrt(np.mean(np.square(z))) < 1.4
    # mixed pixels at the rim would pull the centres away from the scanner
    assert abs(np.mean(along)) < 0.0003
    assert np.sqrt(np.mean(np.square(along))) < 0.0008


def test_balls_of_another_radius_and_columns_are_no_targets():
    centres = np.vstack([CENTRES[:2], BALL])
    points = scan(centres, [RADIUS_M, RADIUS_M, 0.1, 0.05], 7, column=(-3.0, -3.0, 0.15))
    assert len(found_in(points)) == 2


def test_a_far_ball_is_told_from_a_target_by_the_radius_in_the_survey():
    centres = np.array([[7.5, 3.0, 1.0], [-7.0, 4.0, 1.0]])
    features = found_in(scan(centres, [RADIUS_M, 0.1], 3), ball_diameters_mm=(200.0,))
    assert len(features) == 1
    assert np.linalg.norm(features[0].place - centres[0]) < 0.01


def test_a_target_cut_in_half_by_a_column_is_left_out():
    # the column stands in front and hides all on one side of the middle
    points = scan(CENTRES[:1], [RADIUS_M], 1, column=(1.5, 0.42, 0.1))
    assert not found_in(points)


def test_the_step_of_the_scanner_is_found_on_grids_and_random_points():
    points = scan(CENTRES, np.full(6, RADIUS_M), 0)
    assert np.degrees(range_image(points).step_rad) == pytest.approx(0.15, rel=0.15)
    rng = np.random.default_rng(0)
    shuffled = points[rng.permutation(len(points))[: len(points) // 2]]
    assert np.degrees(range_image(shuffled).step_rad) == pytest.approx(0.15 * np.sqrt(2), rel=0.3)


def test_a_window_of_the_image_gives_its_points_across_the_seam():
    points = scan(CENTRES, np.full(6, RADIUS_M), 0)
    image = range_image(points)
    near = image.near(CENTRES[1], 0.02)
    rays = points / np.linalg.norm(points, axis=1, keepdims=True)
    wanted = np.flatnonzero(rays @ (CENTRES[1] / np.linalg.norm(CENTRES[1])) > np.cos(0.02))
    assert len(wanted) > 100
    assert set(wanted) <= set(near.tolist())
    assert len(near) < 3 * len(wanted)
