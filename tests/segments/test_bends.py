"""How segments bend against each other, and the axis of the whole, on cables whose axis is known."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.cable.joint_path import RingPath
from pipeline.segments.bends import whole_axis
from pipeline.segments.plan import SegmentOptions, TraverseOptions, cut
from pipeline.segments.traverse import AdjustedSegment, close_traverse
from tests.cable import scene
from tests.segments import bent_scene

FRAMES = 100
OPTIONS = SegmentOptions(frames=30, shared=8)
LEAN_STEP, PLACE_NOISE_M = 2e-5, 4e-6
"""What each frame adds to the error of the lean (rad), and the error of a single place."""


def errors_by_noise(frames):
    """(2 frames, 2 frames) places (m) and leans (rad) of standard noise: leans walk, places follow them."""
    walk = LEAN_STEP * np.tril(np.ones((frames, frames)))
    return np.block(
        [
            [PLACE_NOISE_M * np.eye(frames), scene.STEP_M * np.tril(np.ones((frames, frames))) @ walk],
            [np.zeros((frames, frames)), walk],
        ]
    )


def adjusted(cable, segment, views, rng):
    """Its cameras and its axis in its own frame, with errors as its covariance says; none without ``rng``."""
    y_m = scene.STEP_M * np.arange(segment.first, segment.last + 1)
    axis, own = cable.into(segment, cable.axis(y_m))
    count = len(y_m)
    by_noise = errors_by_noise(count)
    noise = np.zeros((2 * count, 2)) if rng is None else rng.normal(size=(2 * count, 2))
    places, leans = np.split(by_noise @ noise, 2)
    axis[:, [0, 2]] += places
    turn = Rotation.from_rotvec(np.stack([leans[:, 1], 0 * y_m, -leans[:, 0]], axis=1))
    rotations = [v.poses.rotations[segment.frames] @ own.as_matrix() @ turn.inv().as_matrix() for v in views]
    path = RingPath(
        y_m=y_m - y_m[0],
        covariance_m2=1e-14 * np.eye(count),
        size_m=0.3,
        size_sigma_m=3e-6,
        across_covariance=by_noise @ by_noise.T if rng is not None else np.zeros((2 * count, 2 * count)),
    )
    return AdjustedSegment(path=path, rotations=np.stack(rotations)), axis


def parts_of(cable, seed=None):
    rng = None if seed is None else np.random.default_rng(seed)
    segments = cut(FRAMES, OPTIONS)
    views = cable.views(FRAMES, seed=1)
    made = [adjusted(cable, s, views, rng) for s in segments]
    known = TraverseOptions(ring_ppm=1e-3, link_ppm=1e-3)
    travel_m = scene.STEP_M * (FRAMES - 1)
    placed = close_traverse(segments, tuple(a for a, _ in made), travel_m, 1e-6, known)
    return [
        bent_scene.aligned_part(s, a, p, axis) for s, (a, axis), p in zip(segments, made, placed, strict=True)
    ]


def true_bow_mm(cable, y_m):
    axis_mm = 1000 * cable.axis(y_m)[:, [0, 2]]
    share = ((y_m - y_m[0]) / (y_m[-1] - y_m[0]))[:, None]
    return axis_mm - axis_mm[0] * (1 - share) - axis_mm[-1] * share


def true_bends(cable, parts):
    lines = [np.polyfit(p.y_m, 1000 * cable.axis(p.y_m)[:, [0, 2]], 1)[0] for p in parts]
    return np.diff(lines, axis=0)


@pytest.mark.parametrize("roll_per_m", [0.0, 1.5])
def test_without_noise_the_axis_is_the_true_one_however_the_robot_turns(roll_per_m):
    cable = bent_scene.Cable(radius_m=300.0, wave_m=3e-4, roll_per_m=roll_per_m)
    parts = parts_of(cable)
    turned = np.degrees(parts[-1].placement.roll - parts[0].placement.roll)
    assert abs(turned) > 100 if roll_per_m else abs(turned) < 0.1
    found = whole_axis(parts, to_the_end=True)
    first = cable.rolled(scene.STEP_M * (parts[0].segment.first + parts[0].segment.last) / 2)
    from_global = Rotation.from_rotvec([0, -first.as_rotvec()[1], 0])

    def in_first(mm):
        return from_global.apply(np.stack([mm[:, 0], 0 * mm[:, 0], mm[:, 1]], axis=1))[:, [0, 2]]

    assert found.bow_mm == pytest.approx(in_first(true_bow_mm(cable, found.y_m)), abs=0.004)
    assert np.abs(found.bow_mm).max() > 1, "the cable must be bent for this to be a test"
    assert found.bend_mm_per_m == pytest.approx(in_first(true_bends(cable, parts)), abs=0.01)
    assert found.sigma_mm.max() < 0.01


def test_the_axis_runs_from_end_to_end_and_ends_on_its_chord():
    found = whole_axis(parts_of(bent_scene.Cable(radius_m=200.0)), to_the_end=True)
    assert (found.y_m[0], found.y_m[-1]) == pytest.approx((0, scene.STEP_M * (FRAMES - 1)), abs=1e-4)
    steps = np.diff(found.y_m) / scene.STEP_M  # a place next to a hand-over may be told by neither
    assert 0.99 < steps.min() <= steps.max() < 2.01
    assert np.sum(steps > 1.01) < len(cut(FRAMES, OPTIONS))
    assert found.bow_mm[[0, -1]] == pytest.approx(np.zeros((2, 2)), abs=1e-9)
    assert found.sigma_mm[[0, -1]] == pytest.approx(0, abs=1e-9)


def test_straightness_is_that_of_the_whole_not_of_its_segments():
    radius_m, length_m = 200.0, scene.STEP_M * (FRAMES - 1)
    cable = bent_scene.Cable(radius_m=radius_m, wave_m=0.0, roll_per_m=0.0)
    found = whole_axis(parts_of(cable), to_the_end=True)
    # an arc's largest distance from the line that fits best is two thirds of its sagitta, at its ends
    assert found.straightness_mm_per_m == pytest.approx(1000 * length_m / 8 / radius_m * 2 / 3, rel=0.03)


def test_sigma_tells_the_spread_of_bow_and_bends():
    cable = bent_scene.Cable(radius_m=300.0, wave_m=0.0, roll_per_m=0.0)
    bows, bends = [], []
    for seed in range(60):
        parts = parts_of(cable, seed)
        found = whole_axis(parts, to_the_end=True)
        inner = slice(10, -10)
        bows.append((found.bow_mm - true_bow_mm(cable, found.y_m))[inner] / found.sigma_mm[inner, None])
        bends.append((found.bend_mm_per_m - true_bends(cable, parts)) / found.bend_sigma_mm_per_m[:, None])
    assert np.sqrt(np.mean(np.square(np.concatenate(bows)))) == pytest.approx(1, abs=0.25)
    assert np.sqrt(np.mean(np.square(bends))) == pytest.approx(1, abs=0.15)
    assert abs(np.mean(bends)) < 0.15


def test_errors_add_up_along_the_chain():
    cable = bent_scene.Cable(roll_per_m=0.0)
    parts = parts_of(cable, 1)
    two, all_of_them = (whole_axis(p, to_the_end=True).sigma_mm.max() for p in (parts[:2], parts))
    assert all_of_them > 2 * two


def test_bends_of_adjusted_rings_are_right_within_what_their_sigma_says():
    """The real adjustment of four cameras, with noise: the covariance is its own."""
    cable = bent_scene.Cable(radius_m=100.0, wave_m=0.0, roll_per_m=0.05)
    options = SegmentOptions(frames=14, shared=5)
    bows, bends = [], []
    for seed in range(2):
        parts = bent_scene.measured_parts(cable, options, 30, seed, count=150, marks=40)
        found = whole_axis(parts, to_the_end=True)
        bends.append((found.bend_mm_per_m - true_bends(cable, parts)) / found.bend_sigma_mm_per_m[:, None])
        middle = len(found.y_m) // 2
        bows.append((found.bow_mm - true_bow_mm(cable, found.y_m))[middle] / found.sigma_mm[middle])
        assert np.all(np.abs(found.bend_mm_per_m[:, 0]) > 5 * found.bend_sigma_mm_per_m)
    assert 0.4 < np.sqrt(np.mean(np.square(bends))) < 1.8
    assert 0.3 < np.sqrt(np.mean(np.square(bows))) < 2.2


def test_a_single_segment_is_told_about_its_own_chord():
    (first, *_) = parts_of(bent_scene.Cable(radius_m=100.0, wave_m=0.0))
    alone = replace(first, placement=replace(first.placement, to_m=first.y_m[-1] + 1e-6))
    found = whole_axis([alone], to_the_end=False)
    length_m = found.y_m[-1] - found.y_m[0]
    assert np.hypot(*found.bow_mm.T).max() == pytest.approx(1000 * length_m**2 / 8 / 100.0, rel=0.02)
    assert found.bend_mm_per_m.shape == (0, 2)
