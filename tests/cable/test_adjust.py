"""The block's orientation is found from tie points and a rough POS, and tells how well the POS holds it."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.cable.adjust import AdjustOptions, adjust_block
from pipeline.cable.match import TiePoints
from pipeline.core.fits.cylinder import fit_cylinder
from pipeline.core.fits.similarity import fit_similarity
from tests.cable import scene


def tie_points(view, points=450, noise_px=0.0, seed=8):
    """Exact sights of random surface points, with noise, and starts that are a millimetre wrong."""
    rng = np.random.default_rng(seed)
    spots = scene.cable_points(view, points)
    frame, point, pixels = scene.observe(view, spots)
    keep = np.bincount(point, minlength=points)[point] >= 3
    number = np.cumsum(np.bincount(point[keep], minlength=points) > 0) - 1
    used = np.unique(point[keep])
    return TiePoints(
        frame=frame[keep],
        point=number[point[keep]],
        pixels=pixels[keep] + rng.normal(0, noise_px, (keep.sum(), 2)),
        starts=spots[used] + rng.normal(0, 0.001, (len(used), 3)),
        epipolar_px=np.zeros(0),
        pos_epipolar_px=np.zeros(0),
        rejected=0.0,
    ), spots[used]


def adjust(view, ties, pos=None, options=None, emit=scene.silent):
    pos = pos or scene.pos_priors(scene.poses())
    return adjust_block("Block1", ties, view.lens, pos, options or AdjustOptions(), emit)


def shape_error_mm(found, truth):
    """Root mean square distance after the best similarity: what is wrong beside place and scale."""
    return 1000 * float(np.sqrt(np.mean(np.sum(fit_similarity(found, truth).residuals ** 2, axis=1))))


@pytest.fixture(scope="module")
def exact(barrel_view):
    ties, spots = tie_points(barrel_view)
    return adjust(barrel_view, ties), spots


@pytest.fixture(scope="module")
def noisy(barrel_view):
    ties, spots = tie_points(barrel_view, noise_px=0.1)
    return adjust(barrel_view, ties), spots, ties


def test_a_swaying_way_is_found_from_a_pos_that_knows_no_sway(exact, barrel_view):
    found, spots = exact
    assert np.abs(scene.poses().centres - barrel_view.poses.centres).max() > 0.5e-3  # what there is to find
    assert shape_error_mm(found.poses.centres, barrel_view.poses.centres) < 0.02
    assert shape_error_mm(found.points, spots) < 0.02
    assert found.reprojection_px < 0.01


def test_place_and_scale_are_those_of_the_pos(exact, barrel_view):
    """Only the ends of the travel are known well: they set the scale."""
    found, spots = exact
    np.testing.assert_allclose(found.poses.centres[[0, -1], 1], [0, scene.TRAVEL_M], atol=5e-5)
    assert fit_similarity(found.points, spots).scale == pytest.approx(1, abs=0.002)
    np.testing.assert_allclose(
        found.poses.centres.mean(axis=0), scene.poses().centres.mean(axis=0), atol=3e-4
    )


def test_residuals_are_as_large_as_the_noise_that_went_in(noisy):
    """0.1 px a coordinate is 0.141 px a point; the unknowns take up a part of it."""
    found, spots, ties = noisy
    unknowns = 3 * len(spots) + 6 * scene.FRAMES
    expected = 0.1 * np.sqrt(2) * np.sqrt(1 - unknowns / (2 * len(ties.frame)))
    assert found.reprojection_px == pytest.approx(expected, rel=0.05)
    truth = np.linalg.norm(found.residuals, axis=1)
    assert found.reprojection_px == pytest.approx(np.sqrt(np.mean(truth**2)))


def test_noise_costs_micrometres_not_millimetres(noisy, barrel_view):
    found, spots, _ = noisy
    assert 0.001 < shape_error_mm(found.poses.centres, barrel_view.poses.centres) < 0.15
    assert shape_error_mm(found.points, spots) < 0.4


def test_gross_errors_are_left_out_and_nothing_else(barrel_view, noisy):
    ties, _ = tie_points(barrel_view, noise_px=0.1)
    rng = np.random.default_rng(2)
    wrong = rng.random(len(ties.frame)) < 0.03
    turn = rng.uniform(0, 2 * np.pi, len(wrong))
    off = 10.0 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    found = adjust(barrel_view, replace(ties, pixels=ties.pixels + wrong[:, None] * off))
    kept = set(zip(found.frame.tolist(), found.point.tolist(), strict=True))
    pairs = list(zip(ties.frame.tolist(), ties.point.tolist(), strict=True))
    bad_kept = sum(pair in kept for pair, w in zip(pairs, wrong, strict=True) if w)
    good_lost = sum(pair not in kept for pair, w in zip(pairs, wrong, strict=True) if not w)
    assert bad_kept <= 0.01 * wrong.sum()
    assert good_lost <= 0.02 * (~wrong).sum()
    assert found.reprojection_px == pytest.approx(noisy[0].reprojection_px, rel=0.1)


def test_every_accepted_measurement_belongs_to_its_residual(noisy, barrel_view):
    found, _, _ = noisy
    view = replace(barrel_view, poses=found.poses)
    for k in (0, 6):
        rows = found.frame == k
        projected = view.project(k, found.points[found.point[rows]])
        np.testing.assert_allclose(found.residuals[rows], found.pixels[rows] - projected, atol=1e-9)


def test_a_frame_with_too_few_measurements_does_not_count_as_calibrated(barrel_view):
    ties, _ = tie_points(barrel_view, noise_px=0.1)
    drop = (ties.frame == 3) & (np.cumsum(ties.frame == 3) > 12)
    poor = replace(ties, frame=ties.frame[~drop], point=ties.point[~drop], pixels=ties.pixels[~drop])
    found = adjust(barrel_view, poor)
    assert found.keypoints[3] <= 12
    assert found.calibrated.tolist() == [k != 3 for k in range(scene.FRAMES)]
    np.testing.assert_array_equal(found.keypoints, np.bincount(found.frame, minlength=scene.FRAMES))


def test_a_tight_pos_is_kept_and_a_loose_one_is_not(barrel_view):
    ties, _ = tie_points(barrel_view, noise_px=0.1)
    tight = scene.pos_priors(scene.poses(), deg=1e-6, mm=1e-6, along_mm=1e-6, ends_mm=1e-6)
    held = adjust(barrel_view, ties, pos=tight)
    np.testing.assert_allclose(held.poses.centres, scene.poses().centres, atol=1e-6)
    assert held.reprojection_px > 0.5  # the sway is not explained


def test_without_correction_the_barrel_lens_bends_the_model(noisy):
    found, _, _ = noisy
    straight = fit_cylinder(found.points, direction=(0, 1, 0))
    bent = fit_cylinder(found.lens_effect.points_uncorrected, direction=(0, 1, 0))
    assert straight.radius == pytest.approx(scene.RADIUS_M, abs=0.3e-3)
    assert abs(bent.radius - scene.RADIUS_M) > 1.5e-3
    roughness = [
        float(np.sqrt(np.mean(c.distances(p) ** 2)))
        for c, p in ((bent, found.lens_effect.points_uncorrected), (straight, found.points))
    ]
    assert roughness[0] > 3 * roughness[1]


def test_a_lens_without_distortion_has_no_effect_to_show(straight_view):
    ties, _ = tie_points(straight_view, points=200)
    assert adjust(straight_view, ties).lens_effect is None


def test_the_datum_is_the_closed_form_where_all_frames_are_known_alike(barrel_view):
    """n frames of equal sigma, of which 1 + travel / correlation are independent."""
    ties, _ = tie_points(barrel_view, points=300)
    deg, mm = 0.4, 2.0
    pos = scene.pos_priors(barrel_view.poses, deg=deg, mm=mm, along_mm=mm, ends_mm=mm)
    options = AdjustOptions(correlation_m=0.06)
    found = adjust(barrel_view, ties, pos=pos, options=options)
    independent = 1 + scene.TRAVEL_M / 0.06
    arms = found.poses.centres - found.datum_origin
    information = found.datum_information
    per_shift, per_turn = 1 / (mm / 1000) ** 2, 1 / np.radians(deg) ** 2
    assert found.datum_origin[[0, 2]].tolist() == [0, 0]
    assert arms[:, 1].mean() == pytest.approx(0, abs=1e-12)
    rel = {"rel": 0.005}  # the adjusted travel differs by a hair from the given
    np.testing.assert_allclose(
        information[3:6, 3:6], independent * per_shift * np.eye(3), rtol=0.005, atol=1e-3 * per_shift
    )
    square = np.mean(np.sum(arms**2, axis=1))
    assert information[6, 6] == pytest.approx(independent * per_shift * square, **rel)
    inertia = np.mean([a @ a * np.eye(3) - np.outer(a, a) for a in arms], axis=0)
    np.testing.assert_allclose(
        information[:3, :3],
        independent * (per_turn * np.eye(3) + per_shift * inertia),
        rtol=0.005,
        atol=1e-3 * per_turn,
    )
    np.testing.assert_allclose(
        information[3:6, 6], independent * per_shift * arms.mean(axis=0), rtol=0.005, atol=1e-6
    )


def test_frames_close_together_are_no_independent_evidence(barrel_view):
    ties, _ = tie_points(barrel_view, points=200)
    wide, narrow = (
        adjust(barrel_view, ties, options=AdjustOptions(correlation_m=c)).datum_information
        for c in (0.09, 1e-6)
    )
    # at most as many as there are frames: 3 against 10
    np.testing.assert_allclose(wide, 0.3 * narrow, rtol=0.01, atol=1e-6)


def test_progress_grows_and_ends_within_its_total(barrel_view):
    ties, _ = tie_points(barrel_view, points=200)
    events = []
    adjust(barrel_view, ties, emit=events.append)
    shares = [e.done / e.total for e in events]
    assert {(e.stage, e.block) for e in events} == {("adjust", "Block1")}
    assert min(shares) >= 0
    assert max(shares) <= 1
