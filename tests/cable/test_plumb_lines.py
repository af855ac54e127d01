"""Lambda from the cable's edges: exact on clean edges, unbiased under noise, honest under a real shape."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.cable.plumb_lines import fit_plumb_lines
from pipeline.cable.plumb_records import PlumbEdges, PlumbLineOptions, PlumbScene
from pipeline.core.errors import StageError

HALF_DIAGONAL, FOCAL, STANDOFF, RADIUS = np.hypot(480, 300), 720.0, 0.30, 0.055
COSINE2 = 1 - (RADIUS / STANDOFF) ** 2
"""A ray that touches the cylinder has sin b = r / D."""


def scene_of(frames=24):
    return PlumbScene(
        half_diagonal_px=HALF_DIAGONAL,
        focal_px=FOCAL,
        standoff_m=STANDOFF,
        positions_m=np.linspace(0, 0.46, frames),
        forward=1,
    )


def waves(rng, shortest_m, longest_m, sigma_mm, count=10):
    """A random smooth function of the place (m), in mm, of about that standard deviation."""
    length = np.exp(rng.uniform(np.log(shortest_m), np.log(longest_m), count))
    phase = rng.uniform(0, 2 * np.pi, count)
    size = sigma_mm * np.sqrt(2 / count) * rng.normal(size=count)
    return lambda y: np.cos(2 * np.pi * np.asarray(y)[:, None] / length + phase) @ size


def edges_of(rng, *, division_lambda=-0.02, noise_px=0.15, frames=24, diameter_mm=None, axis_mm=None):
    """Edges of a cable with the given deviations of diameter and axis, seen by a swaying robot."""
    nothing = np.zeros_like
    diameter_mm, axis_mm = diameter_mm or nothing, axis_mm or nothing
    points, frame, side = [], [], []
    for k, position in enumerate(scene_of(frames).positions_m):
        shift, turn = rng.normal(0, 2.0), rng.normal(0, 0.004)
        for sign in (-1, 1):
            x = np.arange(-500, 500, 14.3)
            place = position + x * STANDOFF * COSINE2 / FOCAL
            outward_mm = sign * diameter_mm(place) / 2 + axis_mm(place)
            y = sign * FOCAL * np.tan(np.arcsin(RADIUS / STANDOFF))
            y = y + outward_mm / 1000 * FOCAL / (STANDOFF * COSINE2**1.5)
            ideal = np.column_stack(
                [x * np.cos(turn) - y * np.sin(turn), x * np.sin(turn) + y * np.cos(turn) + shift]
            )
            # distorted radius d of the undistorted u = d / (1 + lambda d^2), smaller root
            u = np.linalg.norm(ideal, axis=1) / HALF_DIAGONAL
            root = (
                1
                if division_lambda == 0
                else (1 - np.sqrt(1 - 4 * division_lambda * u**2)) / (2 * division_lambda * u**2)
            )
            bent = ideal * np.atleast_1d(root)[:, None] + [0, 1] * rng.normal(0, noise_px, (len(x), 1))
            bent = bent[np.abs(bent[:, 0]) < 476]
            points.append(bent)
            frame.append(np.full(len(bent), k))
            side.append(np.full(len(bent), sign))
    return PlumbEdges(
        points_px=np.concatenate(points), frame=np.concatenate(frame), side=np.concatenate(side)
    )


def fit(edges, frames=24, **options):
    return fit_plumb_lines(edges, scene_of(frames), PlumbLineOptions(**options))


@pytest.mark.parametrize("division_lambda", [-0.1, -0.02, 0.0, 0.03])
def test_clean_edges_of_a_perfect_cable_give_lambda_exactly(division_lambda):
    found = fit(
        edges_of(np.random.default_rng(0), division_lambda=division_lambda, noise_px=0.0, frames=6), 6
    )
    assert found.lambda_half_diagonal == pytest.approx(division_lambda, abs=2e-6)
    assert found.start_lambda == pytest.approx(division_lambda, abs=1e-6)  # the circle identity is exact too
    assert found.straight_px < 1e-3
    assert (found.bent_px > 0.3) == (division_lambda != 0)


def test_noise_alone_does_not_bias_lambda():
    """Noise of 0.4 px on a perfect cable, whose perfection is known: only noise is left."""
    seeds = range(1000, 1030)
    edges = (edges_of(np.random.default_rng(seed), noise_px=0.4, frames=8) for seed in seeds)
    fits = [fit(each, 8, shape_sigma_mm=1e-4) for each in edges]
    errors = np.array([f.lambda_half_diagonal for f in fits]) + 0.02
    assert abs(errors.mean()) < 3 * errors.std() / np.sqrt(30)
    assert np.mean([f.sigma for f in fits]) == pytest.approx(errors.std(), rel=0.35)
    assert fits[0].noise_px == pytest.approx(0.4, rel=0.1)


def test_sigma_is_honest_for_a_cable_that_swells_and_bends():
    """0.3 mm in waves of 0.1 to 0.5 m: errors within two sigma, and sigma not above three times their RMS."""
    errors, sigmas = [], []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        shapes = {"diameter_mm": waves(rng, 0.1, 0.5, 0.3), "axis_mm": waves(rng, 0.1, 0.5, 0.3)}
        found = fit(edges_of(rng, **shapes))
        errors.append(found.lambda_half_diagonal + 0.02)
        sigmas.append(found.sigma)
    errors, sigmas = np.array(errors), np.array(sigmas)
    assert np.mean(np.abs(errors) <= 2 * sigmas) >= 0.9
    assert np.mean(sigmas) <= 3 * np.sqrt(np.mean(errors**2))
    assert np.sqrt(np.mean(errors**2)) < 0.0015


def test_a_rougher_cable_than_expected_raises_the_shape_and_sigma():
    """Three times the expected variation: the fit sees it in the edges themselves."""
    rough, even = [], []
    for seed in range(3):
        rng = np.random.default_rng(seed)
        shapes = {"diameter_mm": waves(rng, 0.1, 1.0, 0.9), "axis_mm": waves(rng, 0.1, 1.0, 0.9)}
        rough.append(fit(edges_of(rng, **shapes)))
        even.append(fit(edges_of(rng)))
    assert 0.5 < np.median([f.shape_sigma_mm for f in rough]) < 1.8
    assert all(f.shape_sigma_mm == pytest.approx(0.3) for f in even)
    assert np.median([f.sigma for f in rough]) > 1.5 * np.median([f.sigma for f in even])


def test_edge_errors_that_stay_in_the_picture_widen_sigma():
    """Uneven light shifts the edges by 0.15 px in the same 50 columns of every frame: no small errors."""
    errors, together, apart = [], [], []
    for seed in range(8):
        rng = np.random.default_rng(seed)
        edges = edges_of(rng, noise_px=0.1, frames=16)
        columns = np.floor((edges.points_px[:, 0] + 480) / 50).astype(int)
        light = 0.15 * rng.normal(size=(20, 2))[columns, (edges.side > 0) * 1]
        for shifts, sigmas in ((light, together), (rng.permutation(light), apart)):
            found = fit(
                replace(edges, points_px=edges.points_px + shifts[:, None] * [0, 1]), 16, shape_sigma_mm=1e-4
            )
            sigmas.append(found.sigma)
            errors.append((found.lambda_half_diagonal + 0.02) / found.sigma)
    assert np.mean(together) > 3 * np.mean(apart)
    assert 0.5 < np.sqrt(np.mean(np.square(errors))) < 1.7


def test_gross_errors_are_left_out():
    rng = np.random.default_rng(4)
    edges = edges_of(rng, noise_px=0.1)
    bad = rng.choice(len(edges.points_px), len(edges.points_px) // 10, replace=False)
    points = edges.points_px.copy()
    points[bad, 1] += rng.uniform(1, 5, len(bad))
    assert fit(replace(edges, points_px=points)).lambda_half_diagonal == pytest.approx(-0.02, abs=0.0006)


def test_one_edge_is_too_few():
    edges = edges_of(np.random.default_rng(0), frames=3)
    first = (edges.frame == 0) & (edges.side == 1)
    alone = PlumbEdges(points_px=edges.points_px[first], frame=edges.frame[first], side=edges.side[first])
    with pytest.raises(StageError, match="too few edges"):
        fit(alone, 3)
