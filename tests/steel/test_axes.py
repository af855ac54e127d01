"""Axes found in clouds of single stations: two arcs of one column are one axis, and out of round is told."""

import numpy as np
import pytest

from pipeline.core.events import silent
from pipeline.steel.axes import find_axes
from pipeline.steel.registration_options import TargetOptions
from pipeline.steel.survey_records import Scanner, ScanStation, SteelSurvey

ARCSEC = np.pi / 180 / 3600
RADIUS_M, FOOT, LEAN = 0.15, np.array([5.0, 1.0, -1.6]), np.array([0.004, -0.003, 1.0])
OPPOSITE = np.array([9.5, 2.5, 0.1])
SURVEY = SteelSurvey(
    format=1,
    kind="steel",
    name="x",
    scanner=Scanner(range_sigma_mm=2.0, angle_sigma_arcsec=8.0),
    stations=(ScanStation(name="S1"), ScanStation(name="S2")),
)


def column_from(scanner, seed, oval_m=0.0, phase=0.0, bias_m=0.0):
    """Points (n, 3) of a leaning column, 5 m high, in the frame of a scanner at a place (3,) of the site."""
    rng = np.random.default_rng(seed)
    axis = LEAN / np.linalg.norm(LEAN)
    foot = FOOT - scanner
    middle = np.arctan2(foot[1], foot[0])
    step = np.radians(0.15)
    azimuth, elevation = np.meshgrid(middle + np.arange(-0.1, 0.1, step), np.arange(-0.4, 0.75, step))
    flat = np.cos(elevation)
    rays = np.column_stack(
        [(flat * np.cos(azimuth)).ravel(), (flat * np.sin(azimuth)).ravel(), np.sin(elevation).ravel()]
    )
    across, off = rays - np.outer(rays @ axis, axis), foot - (foot @ axis) * axis
    a, b, c = np.sum(across**2, axis=1), across @ off, off @ off - RADIUS_M**2
    hit = b**2 - a * c > 0
    rays, across = rays[hit], across[hit]
    ranges = (b[hit] - np.sqrt(b[hit] ** 2 - a[hit] * c)) / a[hit]
    normal = (ranges[:, None] * across - off) / RADIUS_M
    facing = -np.sum(normal * rays, axis=1)
    # an ellipse: where a ray meets it, to first order
    angle = np.arctan2(normal[:, 1], normal[:, 0])
    ranges = ranges - oval_m * np.cos(2 * (angle - phase)) / np.maximum(facing, 0.1)
    along = ranges * (rays @ axis) - foot @ axis
    seen = (along > 0) & (along < 5)
    rays, ranges = rays[seen], ranges[seen] + bias_m + rng.normal(scale=0.002, size=seen.sum())
    rays = rays + rng.normal(scale=8 * ARCSEC, size=rays.shape)
    return (rays / np.linalg.norm(rays, axis=1, keepdims=True) * ranges[:, None]).astype(np.float32)


def axes_in(points, folder, **options):
    cloud = folder / "S1.npy"
    np.save(cloud, points)
    return find_axes(cloud, "S1", SURVEY, TargetOptions(**options), folder, silent)


def apart(one, other, shift):
    """Offsets and slopes of an axis from another (moved by ``shift``) at the first's place; covariance."""
    frame, away = one.frame, one.place - (other.place + shift)
    direction = other.direction / (other.direction @ frame[2])
    along = float(away @ other.direction)
    offsets = frame[:2] @ (along * other.direction - away)
    turn, sign = frame[:2] @ other.frame[:2].T, np.sign(other.direction @ frame[2])
    gain = np.block([[turn, along * turn], [np.zeros((2, 2)), sign * turn]])
    covariance = one.covariance + gain @ other.covariance @ gain.T
    return np.concatenate([offsets, frame[:2] @ direction]), covariance


def both_sides(seed, folder, **form):
    first = axes_in(column_from(np.zeros(3), seed, **form), folder)
    second = axes_in(column_from(OPPOSITE, seed + 1000, **form), folder)
    assert len(first) == len(second) == 1
    return first[0], second[0]


def test_one_arc_gives_the_true_axis_within_its_sigma(tmp_path):
    squares = []
    for seed in range(6):
        (axis,) = axes_in(column_from(np.zeros(3), seed), tmp_path, figure_sigma_mm=0.0, roundness_share=0.0)
        assert axis.radius_m == pytest.approx(RADIUS_M, abs=0.002)
        assert axis.reach_m == pytest.approx(2.5, abs=0.2)
        d = LEAN / np.linalg.norm(LEAN)
        d = d * np.sign(d @ axis.direction)
        away = FOOT - axis.place
        error = np.concatenate([axis.frame[:2] @ (away - (away @ d) * d), axis.frame[:2] @ d])
        squares.append(error @ np.linalg.solve(axis.covariance, error) / 4)
    assert 0.3 < np.mean(squares) < 2.2


@pytest.mark.parametrize(("oval_m", "least"), [(0.0, 0.0), (0.0002, 0.0005)])
def test_two_arcs_of_one_column_are_one_axis_within_their_sigmas(oval_m, least, tmp_path):
    """Out of round by 0.2 mm, arcs from opposite sides lie 0.5 mm and more apart: three times as far."""
    squares, offsets = [], []
    for seed in range(4):
        one, other = both_sides(seed, tmp_path, oval_m=oval_m, phase=0.2)
        difference, covariance = apart(one, other, OPPOSITE)
        squares.append(difference @ np.linalg.solve(covariance, difference) / 4)
        offsets.append(np.linalg.norm(difference[:2]))
    assert np.mean(offsets) > least
    assert np.mean(squares) < 2.0
    # and not by sigmas that hold anything
    assert np.sqrt(np.linalg.eigvalsh(covariance[:2, :2])).max() < 0.0012


def test_an_error_common_to_all_ranges_is_within_the_sigma_for_it(tmp_path):
    one, other = both_sides(7, tmp_path, bias_m=0.0003)
    difference, covariance = apart(one, other, OPPOSITE)
    assert difference @ np.linalg.solve(covariance, difference) / 4 < 2.5


def test_the_line_of_sight_is_known_worse_than_across(tmp_path):
    (axis,) = axes_in(column_from(np.zeros(3), 3), tmp_path)
    towards = axis.frame[:2] @ (axis.place / np.linalg.norm(axis.place))
    side = np.array([-towards[1], towards[0]])
    offsets = axis.covariance[:2, :2]
    assert np.sqrt(towards @ offsets @ towards) > 1.7 * np.sqrt(side @ offsets @ side)


def test_a_cloud_without_anything_round_has_no_axes(tmp_path):
    x, y = np.meshgrid(np.arange(-4, 4, 0.02), np.arange(2, 6, 0.02))
    floor = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, -1.6)])
    assert axes_in(floor.astype(np.float32), tmp_path) == ()
