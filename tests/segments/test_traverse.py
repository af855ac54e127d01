"""Scales, places and their standard deviations of segments, from paths that are made up exactly."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.cable.joint_path import RingPath
from pipeline.segments.plan import SegmentOptions, TraverseOptions, cut
from pipeline.segments.traverse import AdjustedSegment, close_traverse, unseen_segment

FRAMES, STEP_M, RING_M = 200, 0.015, 0.3


def wandering(seed=0, wander_m=0.02):
    """(frames,) a robot whose speed wanders smoothly; the first and the last place are its travel's ends."""
    part = np.linspace(0, 1, FRAMES)
    phase = np.random.default_rng(seed).uniform(0, 2 * np.pi)
    return STEP_M * (FRAMES - 1) * part + wander_m * (
        np.sin(7 * np.pi * part + phase) - (1 - part) * np.sin(phase) - part * np.sin(7 * np.pi + phase)
    )


def surveyed(true_y, noise_m=0.0, seed=1, size_share=1e-5, size_noise=0.0):
    """Each segment as adjusted by itself: its nominal travel taken for the true one."""
    rng = np.random.default_rng(seed)
    segments, paths = cut(FRAMES, SegmentOptions()), []
    for segment in segments:
        mine = true_y[segment.frames]
        scale = STEP_M * (segment.last - segment.first) / (mine[-1] - mine[0])
        y_m = scale * (mine - mine[0]) + rng.normal(0, noise_m, len(mine))
        size_m = scale * RING_M * (1 + rng.normal(0, size_noise))
        paths.append(
            RingPath(
                y_m=y_m,
                covariance_m2=max(noise_m, 1e-7) ** 2 * np.eye(len(mine)),
                size_m=size_m,
                size_sigma_m=size_share * size_m,
                across_covariance=np.zeros((2 * len(mine), 2 * len(mine))),
            )
        )
    return segments, tuple(paths)


def adjusted(segment, path, turn_deg=0.0, cameras=4):
    """As adjusted with a robot that turns steadily: each segment calls its own mean attitude zero."""
    frames = np.arange(segment.first, segment.last + 1)
    angles = np.radians(turn_deg * (frames - frames.mean()))
    turned = Rotation.from_rotvec(np.outer(angles, [0, 1, 0])).inv().as_matrix()
    mounts = Rotation.from_rotvec(np.outer(np.arange(cameras), [0.3, 1.0, -0.2])).as_matrix()
    return AdjustedSegment(path=path, rotations=mounts[:, None] @ turned)


def closed(segments, paths, travel_m, sigma_m=1e-6, **options):
    known = TraverseOptions(**options)
    return close_traverse(segments, tuple(map(adjusted, segments, paths)), travel_m, sigma_m, known)


def true_scales(segments, true_y):
    return [(true_y[s.last] - true_y[s.first]) / (STEP_M * (s.last - s.first)) for s in segments]


def test_without_noise_every_segment_gets_its_true_scale_and_place():
    true_y = wandering()
    segments, paths = surveyed(true_y)
    placed = closed(segments, paths, true_y[-1] - true_y[0])
    expected = true_scales(segments, true_y)
    assert max(abs(np.array(expected) - 1)) > 0.01, "the robot must have wandered for this to be a test"
    for one, scale, segment in zip(placed, expected, segments, strict=True):
        assert one.scale == pytest.approx(scale, rel=1e-8)
        assert one.start_m == pytest.approx(true_y[segment.first] - true_y[0], abs=1e-8)


def test_parts_lie_end_to_end_from_the_first_frame_to_the_last():
    true_y = wandering(3)
    segments, paths = surveyed(true_y, noise_m=3e-6)
    placed = closed(segments, paths, true_y[-1])
    assert placed[0].from_m == pytest.approx(0, abs=1e-5)
    assert placed[-1].to_m == pytest.approx(true_y[-1], abs=1e-5)
    for one, other in pairwise(placed):
        assert one.to_m == other.from_m
    places = np.linspace(0, true_y[-1], 57)
    counts = [sum(p.here(y, p is placed[-1]) for p in placed) for y in places]
    assert counts == [1] * len(places)


def test_a_longer_travel_makes_everything_larger_in_proportion():
    true_y = wandering(4)
    segments, paths = surveyed(true_y)
    short, long = (closed(segments, paths, t * (true_y[-1] - true_y[0])) for t in (1.0, 1.001))
    for one, other in zip(short, long, strict=True):
        assert other.scale / one.scale == pytest.approx(1.001, rel=1e-8)


def test_sigma_tells_the_spread_of_the_scales():
    errors, sigmas = [], []
    for seed in range(60):
        true_y = wandering(seed)
        segments, paths = surveyed(true_y, noise_m=3e-6, seed=seed, size_share=4e-5, size_noise=4e-5)
        placed = closed(segments, paths, true_y[-1] - true_y[0], ring_ppm=1e-3, link_ppm=1e-3)
        errors.append([p.scale / t - 1 for p, t in zip(placed, true_scales(segments, true_y), strict=True)])
        sigmas.append([p.scale_sigma for p in placed])
    assert np.std(errors) / np.mean(sigmas) == pytest.approx(1, abs=0.2)


def test_sigma_is_never_better_than_the_travel():
    true_y = wandering()
    segments, paths = surveyed(true_y)
    placed = closed(segments, paths, true_y[-1], sigma_m=0.003)
    for one in placed:
        assert one.scale_sigma / one.scale >= 0.999 * 0.003 / true_y[-1]


def test_the_ring_holds_the_scale_where_shared_frames_say_little():
    true_y = wandering(5)
    segments, paths = surveyed(true_y, noise_m=1e-3, size_share=1e-6)
    placed = closed(segments, paths, true_y[-1] - true_y[0], ring_ppm=1.0)
    ratios = np.array([p.scale for p in placed]) / true_scales(segments, true_y)
    assert ratios / ratios.mean() == pytest.approx(1, abs=1e-5)


def test_a_link_that_disagrees_is_told():
    true_y = wandering(6)
    segments, paths = surveyed(true_y)
    shrunk = paths[1].y_m.copy()
    shrunk[-12:] = shrunk[-12] + 1.002 * (shrunk[-12:] - shrunk[-12])
    bent = replace(paths[1], y_m=shrunk, covariance_m2=100 * paths[1].covariance_m2, size_sigma_m=1e-7)
    told = [p.link_ppm for p in closed(segments, (paths[0], bent, *paths[2:]), true_y[-1], ring_ppm=0.1)]
    assert np.nanargmax(np.abs(told)) == 1
    assert abs(told[1]) > 300
    assert np.isnan(told[-1])


def test_the_roll_of_the_robot_is_followed_from_segment_to_segment():
    true_y = wandering()
    segments, paths = surveyed(true_y)
    turning = tuple(adjusted(s, p, turn_deg=0.1) for s, p in zip(segments, paths, strict=True))
    placed = close_traverse(segments, turning, true_y[-1], 1e-6, TraverseOptions())
    middles = np.array([(s.first + s.last) / 2 for s in segments])
    assert np.degrees([p.roll for p in placed]) == pytest.approx(0.1 * (middles - middles[0]), abs=1e-6)


def test_a_segment_in_which_nothing_was_found_is_bridged_by_the_even_travel():
    true_y = wandering(7)
    segments, paths = surveyed(true_y)
    nominal_m = STEP_M * np.arange(FRAMES)
    made = [adjusted(s, p) for s, p in zip(segments, paths, strict=True)]
    made[1] = unseen_segment(nominal_m[segments[1].frames], RING_M)
    placed = close_traverse(segments, tuple(made), true_y[-1] - true_y[0], 1e-6, TraverseOptions())
    expected = true_scales(segments, true_y)
    for n, (one, scale) in enumerate(zip(placed, expected, strict=True)):
        if n != 1:  # the ring still ties the others to each other; the whole hangs on the gap
            assert one.scale / placed[0].scale == pytest.approx(scale / expected[0], rel=1e-4)
            assert abs(one.scale / scale - 1) < 3 * one.scale_sigma
    assert placed[1].scale_sigma > 20 * 50e-6


def test_shared_frames_carry_the_scale_where_the_ring_says_little():
    true_y = wandering(8)
    segments, paths = surveyed(true_y, size_share=0.01, size_noise=0.01)
    placed = closed(segments, paths, true_y[-1] - true_y[0])
    for one, scale in zip(placed, true_scales(segments, true_y), strict=True):
        assert one.scale == pytest.approx(scale, rel=2e-4)


def test_what_rings_and_links_contradict_each_other_by_they_are_not_worth():
    """Links that are worse by far than the adjustments believe: sigma must not believe them either."""
    errors, sigmas = [], []
    for seed in range(20):
        true_y = wandering(seed)
        segments, paths = surveyed(true_y, noise_m=1e-4, seed=seed, size_noise=1e-3)
        sure = [replace(p, covariance_m2=1e-14 * np.eye(len(p.y_m))) for p in paths]
        placed = closed(segments, tuple(sure), true_y[-1] - true_y[0], ring_ppm=10.0, link_ppm=10.0)
        errors.append([p.scale / t - 1 for p, t in zip(placed, true_scales(segments, true_y), strict=True)])
        sigmas.append([p.scale_sigma for p in placed])
    assert 0.5 < np.sqrt(np.mean(np.square(sigmas)) / np.mean(np.square(errors))) < 3
