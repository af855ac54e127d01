"""Cylinders and spheres seen from one side: no bias, honest sigmas, and the stations' own errors in them."""

import numpy as np
import pytest

from pipeline.core.errors import StageError
from pipeline.steel.fitting import fit_ball, fit_rod
from pipeline.steel.member_records import MemberOptions
from tests.steel.seen_surfaces import seen_cylinder, seen_sphere, station

START, END = np.array([4.0, -1.0, 3.0]), np.array([4.5, 1.0, 3.2])
AXIS = (END - START) / np.linalg.norm(END - START)
OPTIONS = MemberOptions(angle_sigma_arcsec=0.0)
TRIALS = 40


def rods(radius=0.03, stations=None, **more):
    """Fits of many scans of one rod, and their errors (n, 3): along u, along v, radius, in metres."""
    stations = stations or (station((0, 0, 1.6)),)
    fits, errors = [], []
    for seed in range(TRIALS):
        points = seen_cylinder(START, END, radius, stations, seed, **more)
        fit = fit_rod(points, np.add(AXIS, [0.01, 0.02, -0.01]), stations, OPTIONS)
        middle = 0.5 * (START + END)
        foot = fit.place + ((middle - fit.place) @ fit.direction) * fit.direction
        errors.append([*(fit.frame[:2] @ (foot - middle)), fit.radius_m - radius])
        fits.append(fit)
    return fits, np.array(errors)


def within(errors, sigmas):
    """Share of errors that are at most two of their sigmas."""
    return np.mean(np.abs(errors) <= 2 * sigmas)


@pytest.mark.parametrize("radius", [0.03, 0.15])
def test_a_rod_seen_from_one_side_is_not_pulled_towards_the_scanner(radius):
    fits, errors = rods(radius)
    sigmas = np.array([np.sqrt(np.diag(f.covariance)[[0, 1, 4]]) for f in fits])
    # the mean over all trials is as near zero as the sigmas say
    assert (np.abs(errors.mean(axis=0)) < 3.5 * sigmas.mean(axis=0) / np.sqrt(TRIALS)).all()
    assert within(errors, sigmas) >= 0.9
    assert (sigmas.mean(axis=0) < 3 * errors.std(axis=0)).all()


def test_mixed_pixels_at_the_rim_do_not_widen_a_rod():
    fits, errors = rods(mixed=0.7)
    sigmas = np.array([np.sqrt(np.diag(f.covariance)[[0, 1, 4]]) for f in fits])
    assert (np.abs(errors.mean(axis=0)) < 0.00012).all()
    assert within(errors, sigmas) >= 0.88


def test_a_ball_seen_from_one_side_is_where_it_is():
    poses, centre = (station((0, 0, 1.6)),), np.array([3.0, 2.0, 4.0])
    errors, sigmas = [], []
    for seed in range(TRIALS):
        points = seen_sphere(centre, 0.1, poses, seed, mixed=0.5)
        fit = fit_ball(points, np.add(centre, [0.004, -0.003, 0.005]), 0.103, poses, OPTIONS)
        errors.append([*(fit.place - centre), fit.radius_m - 0.1])
        sigmas.append(np.sqrt(np.diag(fit.covariance)))
    errors, sigmas = np.array(errors), np.array(sigmas)
    assert (np.abs(errors.mean(axis=0)) < 3.5 * sigmas.mean(axis=0) / np.sqrt(TRIALS)).all()
    assert within(errors, sigmas) >= 0.9
    assert (sigmas.mean(axis=0) < 3 * errors.std(axis=0)).all()


def test_the_error_of_registration_does_not_average_out_over_points():
    places = ((0, 0, 1.6), (8, 0, 1.6))
    exact = tuple(station(p) for p in places)
    points = seen_cylinder(START, END, 0.03, exact, 1, count=8000)
    shaky = tuple(station(p, 0.003) for p in places)
    fit = fit_rod(points, AXIS, shaky, OPTIONS)
    across = np.sqrt(np.diag(fit.covariance)[:2])
    assert np.sqrt(np.diag(fit.noise_covariance)[:2]).max() < 0.0001
    # two stations: no better than sigma / sqrt(2) along their rays, no worse than one of them
    assert (across > 0.9 * 0.003 / np.sqrt(2)).all()
    assert (across < 1.6 * 0.003).all()


def test_the_share_says_how_a_rod_follows_its_station():
    places = ((0, 0, 1.6), (8, 0, 1.6))
    poses = tuple(station(p) for p in places)
    points = seen_cylinder(START, END, 0.03, poses, 1, noise=0.0, widest=0.8)
    before = fit_rod(points, AXIS, poses, OPTIONS)
    move = np.array([0.0004, -0.0003, 0.0005])
    moved = tuple(station(np.add(p, move if k == 0 else 0)) for k, p in enumerate(places))
    shifted = points.places + np.where(points.stations[:, None] == 0, move, 0.0)
    after = fit_rod(type(points)(places=shifted, stations=points.stations), AXIS, moved, OPTIONS)
    told = before.share.gains[0] @ [0, 0, 0, *move, 0]
    foot = after.place + ((before.place - after.place) @ after.direction) * after.direction
    got = [*(before.frame[:2] @ (foot - before.place)), after.radius_m - before.radius_m]
    np.testing.assert_allclose(got, told[[0, 1, 4]], atol=6e-5)


def test_points_on_no_cylinder_are_refused():
    poses = (station((0, 0, 1.6)),)
    points = seen_cylinder(START, END, 0.03, poses, 1, count=4)
    with pytest.raises(StageError):
        fit_rod(points, AXIS, poses, OPTIONS)


@pytest.mark.filterwarnings("error")
def test_a_figure_that_no_ray_meets_is_refused():
    poses = (station((0, 0, 1.6)),)
    points = seen_sphere(np.array([3.0, 2.0, 4.0]), 0.1, poses, 1)
    with pytest.raises(StageError, match=r"only 0 of .* rays meet the figure"):
        fit_ball(points, np.array([3.0, 3.0, 4.0]), 0.1, poses, OPTIONS)
