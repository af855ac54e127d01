"""Where a ray meets a sphere, a cylinder, a rectangle and a disc: distances worked out by hand."""

import numpy as np
import pytest

from synth.scan.hits import hit_cylinder, hit_disc, hit_rectangle, hit_sphere

X, Y, Z = np.eye(3)


def test_a_ray_through_a_spheres_centre_hits_at_the_distance_less_the_radius():
    hit = hit_sphere(np.array([3.0, 4.0, 0.0, 0.5]), np.array([[0.6, 0.8, 0.0]]))
    assert hit.range_m == pytest.approx([4.5], abs=1e-12)
    assert hit.cosine == pytest.approx([1.0])
    assert hit.inside_m == pytest.approx([0.5])


def test_a_ray_beside_a_sphere_passes_it_by_the_distance_of_its_centre():
    angle = np.arcsin(0.6 / 5.0)  # passes the centre by 0.6 m
    hit = hit_sphere(np.array([5.0, 0.0, 0.0, 0.5]), np.array([[np.cos(angle), np.sin(angle), 0.0]]))
    assert np.isinf(hit.range_m[0])
    assert hit.inside_m == pytest.approx([-0.1], abs=1e-12)


def test_what_lies_behind_is_not_met():
    for hit in (
        hit_sphere(np.array([-5.0, 0, 0, 0.5]), X[None]),
        hit_cylinder(np.array([-5.0, 0, -1, -5, 0, 1, 0.5]), X[None]),
        hit_rectangle(np.array([-5.0, -1, -1, 0, 2, 0, 0, 0, 2]), X[None]),
        hit_disc(np.array([-5.0, 0, 0, 1, 0, 0, 1.0]), X[None]),
    ):
        assert np.isinf(hit.range_m[0])
        assert hit.inside_m[0] == -np.inf


def test_a_ray_at_45_degrees_up_meets_a_plumb_column_of_10_cm_radius():
    up = np.array([[1.0, 0.0, 1.0]]) / np.sqrt(2.0)
    hit = hit_cylinder(np.array([2.0, 0.0, 0.0, 2.0, 0.0, 4.0, 0.1]), up)
    assert hit.range_m == pytest.approx([1.9 * np.sqrt(2.0)], abs=1e-12)
    assert hit.cosine == pytest.approx([np.sqrt(0.5)])


def test_a_cylinder_ends_where_it_ends():
    column = np.array([2.0, 0.0, 0.5, 2.0, 0.0, 1.0, 0.1])
    heights = np.array([0.4, 0.6, 0.9, 1.1])  # at the range of the near side, 1.9 m
    directions = np.column_stack([np.full(4, 1.9), np.zeros(4), heights])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    assert np.isfinite(hit_cylinder(column, directions).range_m).tolist() == [False, True, True, False]


def test_a_rectangle_is_met_within_its_edges_from_both_sides():
    wall = np.array([4.0, -1.0, -1.0, 0.0, 2.0, 0.0, 0.0, 0.0, 3.0])
    turned = np.array([4.0, 1.0, -1.0, 0.0, -2.0, 0.0, 0.0, 0.0, 3.0])
    directions = np.array([[4.0, 0.0, 0.0], [4.0, 0.9, 1.9], [4.0, 1.1, 0.0], [4.0, 0.0, -1.1]])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    for rectangle in (wall, turned):
        hit = hit_rectangle(rectangle, directions)
        assert hit.range_m[:2] == pytest.approx([4.0, np.sqrt(16 + 0.81 + 3.61)], abs=1e-12)
        assert np.isinf(hit.range_m[2:]).all()
        assert hit.inside_m[0] == pytest.approx(1.0)


def test_a_disc_is_met_within_its_radius():
    disc = np.array([0.0, 0.0, 3.0, 0.0, 0.0, 1.0, 0.5])
    directions = np.array([[0.0, 0.0, 3.0], [0.49, 0.0, 3.0], [0.36, 0.36, 3.0]])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    hit = hit_disc(disc, directions)
    assert hit.range_m[:2] == pytest.approx([3.0, np.hypot(0.49, 3.0)], abs=1e-12)
    assert np.isinf(hit.range_m[2])


def test_points_of_random_rays_lie_on_the_surfaces():
    rng = np.random.default_rng(3)
    for _ in range(50):
        start, end, radius = rng.uniform(-20, 20, 3), rng.uniform(-20, 20, 3), rng.uniform(0.02, 0.3)
        axis = (end - start) / np.linalg.norm(end - start)
        towards = (
            start + rng.uniform(0.0, 1.0, (200, 1)) * (end - start) + radius * rng.uniform(-1, 1, (200, 3))
        )
        directions = towards / np.linalg.norm(towards, axis=1, keepdims=True)
        hit = hit_cylinder(np.array([*start, *end, radius]), directions)
        met = np.isfinite(hit.range_m)
        off = hit.range_m[met, None] * directions[met] - start
        across = np.linalg.norm(off - (off @ axis)[:, None] * axis, axis=1)
        assert np.count_nonzero(met) > 50
        assert across == pytest.approx(np.full(len(across), radius), abs=1e-9)
