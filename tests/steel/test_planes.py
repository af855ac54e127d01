"""Planes found in one station's cloud: all of them, within their sigmas, also where floors are not flat."""

import numpy as np
import pytest

from pipeline.steel.planes import find_planes
from pipeline.steel.survey_records import Scanner

SCANNER = Scanner(range_sigma_mm=2.0, angle_sigma_arcsec=8.0)
ARCSEC = np.pi / 180 / 3600
HEIGHT_M, WALL_M = 1.6, 6.0


def directions(step_deg=0.5, lowest_deg=-50):
    step = np.radians(step_deg)
    azimuth, elevation = np.meshgrid(
        np.arange(-np.pi, np.pi, step), np.arange(np.radians(lowest_deg), np.radians(30), step)
    )
    flat = np.cos(elevation)
    return np.column_stack(
        [(flat * np.cos(azimuth)).ravel(), (flat * np.sin(azimuth)).ravel(), np.sin(elevation).ravel()]
    )


def scanned(seed, height=lambda x, y: 0.0 * x, column=False):
    """A floor 1.6 m below, as high as ``height`` says, a wall across x; (n, 3) with noise of a scanner."""
    rng = np.random.default_rng(seed)
    rays = directions()
    with np.errstate(divide="ignore"):
        floor = np.where(rays[:, 2] < 0, -HEIGHT_M / rays[:, 2], np.inf)
        wall = np.where(rays[:, 0] > 0, WALL_M / rays[:, 0], np.inf)
    for _ in range(6):  # the floor's height where the ray meets it
        known = np.isfinite(floor)
        met = floor[known, None] * rays[known]
        floor[known] = (height(met[:, 0], met[:, 1]) - HEIGHT_M) / rays[known, 2]
    ranges = np.minimum(floor, wall)
    if column:
        away = rays[:, :2] @ [0.8, 0.6] / np.linalg.norm(rays[:, :2], axis=1)
        ranges = np.where(
            (away > np.cos(0.06)) & (ranges > 4), 4 / np.linalg.norm(rays[:, :2], axis=1), ranges
        )
    seen = ranges < 15
    rays, ranges = rays[seen], ranges[seen] + rng.normal(scale=0.002, size=seen.sum())
    rays = rays + rng.normal(scale=8 * ARCSEC, size=rays.shape)
    return (rays / np.linalg.norm(rays, axis=1, keepdims=True) * ranges[:, None]).astype(np.float32)


def planes_in(points, least_area_m2=4.0, floor_m=0.0):
    return find_planes(points, SCANNER, least_area_m2, floor_m, lambda done, total: None)


def against(plane, normal, off_m):
    """Offset and slopes of a plane from a true one, n . x = off, over their covariance: chi-square of 3."""
    n = np.asarray(normal, dtype=float)
    height = (off_m - n @ plane.place) / (n @ plane.frame[2])
    slopes = plane.frame[:2] @ n / (n @ plane.frame[2])
    error = np.array([height, *slopes])
    return error, error @ np.linalg.solve(plane.covariance, error)


@pytest.fixture(scope="module")
def flat():
    return [planes_in(scanned(seed, column=True)) for seed in range(6)]


def test_floor_and_wall_are_found_and_nothing_else(flat):
    for planes in flat:
        assert len(planes) == 2
        floor, wall = sorted(planes, key=lambda plane: -plane.frame[2] @ [0, 0, 1])
        assert floor.frame[2] @ [0, 0, 1] > 0.99999  # normals point to the scanner
        assert wall.frame[2] @ [-1, 0, 0] > 0.99999


def test_even_planes_are_within_their_sigmas(flat):
    squares = []
    for planes in flat:
        floor, wall = sorted(planes, key=lambda plane: -plane.frame[2] @ [0, 0, 1])
        squares += [against(floor, [0, 0, 1], -HEIGHT_M)[1], against(wall, [-1, 0, 0], -WALL_M)[1]]
        assert np.sqrt(floor.covariance[0, 0]) < 5e-5
    # 12 times 3 degrees of freedom: 1 within noise, and sigmas not more than twice too large
    assert 0.25 < np.mean(squares) / 3 < 1.7


def test_a_floor_of_uneven_slabs_says_so():
    """Slabs of 2.4 m, each at its own height: what one station sees of them does not average to nothing."""
    squares, sigmas = [], []
    for seed in range(10):
        slabs = np.random.default_rng(seed + 50).normal(scale=0.003, size=(40, 40))

        def height(x, y, slabs=slabs):
            return slabs[(np.floor(x / 2.4).astype(int) + 20) % 40, (np.floor(y / 2.4).astype(int) + 20) % 40]

        floor = max(planes_in(scanned(seed, height)), key=lambda plane: plane.frame[2] @ [0, 0, 1])
        squares.append(against(floor, [0, 0, 1], -HEIGHT_M)[1])
        sigmas.append(np.sqrt(floor.covariance[0, 0]))
        assert 0.001 < floor.uneven_m < 0.006
    # some 28 slabs of 3 mm: 0.55 mm
    assert 0.0003 < np.median(sigmas) < 0.001
    assert 0.3 < np.mean(squares) / 3 < 2.5


def test_a_small_plane_is_left():
    assert len(planes_in(scanned(3), least_area_m2=1000.0)) == 0


def test_nothing_is_better_known_than_the_floor_allows():
    floor = planes_in(scanned(3), floor_m=0.0005)[0]
    assert 0.0005 < np.sqrt(floor.covariance[0, 0]) < 0.00052
