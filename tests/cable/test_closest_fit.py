"""Pieces come back to where they belong, held as firmly as their priors say, with an honest covariance."""

import numpy as np
import pytest
from scipy.linalg import block_diag
from scipy.spatial.transform import Rotation

from pipeline.cable.closest_fit import Placement, Tie, fit_pieces

LOOSE, HELD = np.diag([1.0] * 7), np.diag([1e12] * 7)
MM = 1e-3
SIDEWAYS = np.array([2 * MM, 0, 0])


def still(pieces, origin=(0.0, 0.05, 0.0)):
    return Placement(
        origins=np.tile(np.asarray(origin), (pieces, 1)),
        rotations=np.tile(np.eye(3), (pieces, 1, 1)),
        shifts=np.zeros((pieces, 3)),
        scales=np.ones(pieces),
    )


def astray(pieces, seed=1, turn_deg=1.0, shift_mm=2.0, scale=0.01):
    """Where the pieces truly belong; the first one stands right."""
    rng = np.random.default_rng(seed)
    turns, shifts, scales = (
        rng.normal(0, s, (pieces, n)) for s, n in ((turn_deg, 3), (shift_mm * MM, 3), (scale, 1))
    )
    turns[0], shifts[0], scales[0] = 0, 0, 0
    return Placement(
        origins=still(pieces).origins,
        rotations=Rotation.from_rotvec(np.radians(turns)).as_matrix(),
        shifts=shifts,
        scales=np.exp(scales[:, 0]),
    )


def cloud(count=60, seed=2):
    return np.random.default_rng(seed).uniform(-0.1, 0.1, (count, 3))


def own(truth, piece, points):
    """Points of the joined model as the piece shows them: the similarity undone, written out."""
    arms = points - truth.origins[piece] - truth.shifts[piece]
    return truth.origins[piece] + arms @ truth.rotations[piece] / truth.scales[piece]


def tie(truth, first, second, sigma_m=0.1 * MM, noise_m=0.0, seed=2, count=60):
    points, rng = cloud(count, seed), np.random.default_rng(seed + 100)
    return Tie(
        first=first,
        second=second,
        points_first=own(truth, first, points) + rng.normal(0, noise_m, points.shape),
        points_second=own(truth, second, points) + rng.normal(0, noise_m, points.shape),
        whitening=np.tile(np.eye(3) / sigma_m, (count, 1, 1)),
    )


def information(*per_piece):
    """Pieces held each in its own place, independently of the others."""
    return block_diag(*per_piece)


def same_place(found, truth, atol):
    np.testing.assert_allclose(found.rotations, truth.rotations, atol=atol)
    np.testing.assert_allclose(found.shifts, truth.shifts, atol=atol)
    np.testing.assert_allclose(found.scales, truth.scales, atol=atol)


def test_a_placement_is_the_similarity_it_says():
    truth = astray(3)
    points = cloud(5)
    by_hand = truth.origins[2] + truth.shifts[2]
    by_hand = by_hand + truth.scales[2] * (truth.rotations[2] @ (points - truth.origins[2]).T).T
    np.testing.assert_allclose(truth.apply(2, points), by_hand, atol=1e-15)
    np.testing.assert_allclose(truth.undo(2, by_hand), points, atol=1e-15)
    np.testing.assert_allclose(truth.apply(0, points), points)


def test_the_derivative_agrees_with_a_small_step():
    truth, points = astray(2), cloud(7)
    step = np.random.default_rng(3).normal(0, 1e-7, 14)
    placed = truth.apply(1, points)
    moved = truth.moved(step).apply(1, points)
    predicted = np.einsum("nij,j->ni", truth.derivative(1, placed), step[7:])
    np.testing.assert_allclose(moved - placed, predicted, atol=1e-13)


def test_a_known_motion_is_found_from_ties():
    truth = astray(2)
    ties = [tie(truth, 0, 1)]
    fit = fit_pieces(still(2), information(HELD, 1e-6 * LOOSE), lambda _: ties)
    same_place(fit.placement, truth, 1e-9)


def test_a_closed_ring_of_pieces_is_found_at_once():
    truth = astray(4)
    ties = [tie(truth, n, (n + 1) % 4, seed=n) for n in range(4)]
    fit = fit_pieces(still(4), information(HELD, *[1e-6 * LOOSE] * 3), lambda _: ties)
    same_place(fit.placement, truth, 1e-9)


def test_a_piece_without_ties_keeps_still():
    truth = astray(3)
    ties = [tie(truth, 0, 1)]
    fit = fit_pieces(still(3), information(HELD, LOOSE, LOOSE), lambda _: ties)
    np.testing.assert_allclose(fit.placement.deviation()[2], 0, atol=1e-15)
    np.testing.assert_allclose(fit.covariance[14:, 14:], np.eye(7), atol=1e-9)


def test_pieces_that_are_held_to_each_other_move_together():
    """The prior may say that two pieces stand well to each other, though nobody knows where both stand."""
    known_difference, known_place = 1e12 * np.eye(7), 1.0 * np.eye(7)
    together = np.block(
        [
            [known_place + known_difference, -known_difference],
            [-known_difference, known_place + known_difference],
        ]
    )
    points = cloud(20)
    pull = Tie(
        first=0,
        second=1,
        points_first=points,
        points_second=points + SIDEWAYS,
        whitening=np.tile(np.eye(3) / (0.1 * MM), (20, 1, 1)),
    )
    onto_third = information(np.diag([1e12] * 7), together)
    ties = [pull]
    found = fit_pieces(still(3), onto_third, lambda _: ties).placement.deviation()
    np.testing.assert_allclose(found[1, 3], -2 * MM, atol=1e-5)
    np.testing.assert_allclose(found[2], found[1], atol=1e-7)


def test_two_equal_pieces_meet_in_the_middle():
    """One point, 2 mm apart, both held alike: each moves by 1 mm, as far as the tie is firm."""
    points = np.array([[0.0, 0.05, 0.0]])
    gap = Tie(
        first=0,
        second=1,
        points_first=points,
        points_second=points + SIDEWAYS,
        whitening=np.eye(3)[None] / (100 * MM),
    )
    sigma = 1 * MM
    held = np.diag([1e12] * 3 + [1 / sigma**2] * 3 + [1e12])
    soft = fit_pieces(still(2), information(held, held), lambda _: [gap]).placement
    pull = sigma**2 / (2 * sigma**2 + (100 * MM) ** 2)  # weighted mean in closed form
    np.testing.assert_allclose(soft.shifts[:, 0], [2 * MM * pull, -2 * MM * pull], rtol=1e-3)
    firm = Tie(
        first=0,
        second=1,
        points_first=points,
        points_second=gap.points_second,
        whitening=np.eye(3)[None] * 1e6,
    )
    shifts = fit_pieces(still(2), information(held, held), lambda _: [firm]).placement.shifts
    np.testing.assert_allclose(shifts[:, 0], [1 * MM, -1 * MM], atol=2e-6)


def test_a_direction_that_is_left_free_does_not_pull():
    points = cloud(40)
    free_z = Tie(
        first=0,
        second=1,
        points_first=points,
        points_second=points + np.array([0.3 * MM, -0.2 * MM, 5 * MM]),
        whitening=np.tile(np.diag([1e4, 1e4, 0.0]), (40, 1, 1)),
    )
    only_shift = np.diag([1e14] * 3 + [1.0] * 3 + [1e14])
    moved = fit_pieces(still(2), information(HELD, only_shift), lambda _: [free_z]).placement.shifts[1]
    np.testing.assert_allclose(moved, [-0.3 * MM, 0.2 * MM, 0], atol=1e-8)


def test_many_noisy_ties_do_not_shrink_the_model():
    """Shrunk, every difference would look better; but the scale is the priors' business alone."""
    truth = still(2)
    many = tie(truth, 0, 1, sigma_m=0.1 * MM, noise_m=0.07 * MM, count=3000)
    rough = np.diag([1e12] * 6 + [1 / 0.01**2])  # the scale of each piece is known to 1 %
    found = fit_pieces(still(2), information(rough, rough), lambda _: [many])
    mean_scale = np.sqrt(found.placement.scales.prod())
    assert mean_scale == pytest.approx(1, abs=1e-4)
    common = np.zeros(14)
    common[[6, 13]] = 0.5
    assert np.sqrt(common @ found.covariance @ common) == pytest.approx(0.01 / np.sqrt(2), rel=0.01)


def test_residuals_change_as_their_jacobian_says():
    truth = astray(2)
    one = tie(truth, 0, 1, noise_m=5 * MM)
    step = np.random.default_rng(6).normal(0, 1e-7, 14)
    change = one.residuals(truth.moved(step)) - one.residuals(truth.moved(-step))
    np.testing.assert_allclose(change / 2, one.jacobian(truth) @ step, rtol=1e-5, atol=1e-8)


def test_gross_errors_among_the_ties_lose_their_say():
    truth = astray(2)
    good = tie(truth, 0, 1, noise_m=0.05 * MM)
    wrong = good.points_second.copy()
    wrong[::10] += 20 * MM
    spoiled = Tie(
        first=0, second=1, points_first=good.points_first, points_second=wrong, whitening=good.whitening
    )
    clean, robust = (
        fit_pieces(still(2), information(HELD, 1e-6 * LOOSE), lambda _, t=t: [t], iterations=40).placement
        for t in (good, spoiled)
    )
    same_place(robust, clean, 1e-3)
    np.testing.assert_allclose(robust.shifts, clean.shifts, atol=0.05 * MM)


@pytest.mark.parametrize("noise_mm", [0.02, 0.1])
def test_the_covariance_predicts_the_scatter_of_repeated_joins(noise_mm):
    truth = astray(3, shift_mm=0.5, turn_deg=0.2, scale=1e-3)
    found, predicted = [], None
    for seed in range(40):
        ties = [
            tie(truth, a, b, np.sqrt(2) * noise_mm * MM, noise_mm * MM, 10 * seed + a, 20)
            for a, b in ((0, 1), (1, 2))
        ]
        fit = fit_pieces(still(3), information(HELD, 1e-6 * LOOSE, 1e-6 * LOOSE), lambda _, t=ties: t)
        found.append(fit.placement.deviation()[1:].ravel())
        predicted = np.sqrt(np.diag(fit.covariance)[7:])
    ratio = np.std(found, axis=0) / predicted
    assert 0.85 < np.sqrt(np.mean(ratio**2)) < 1.15
    assert ((ratio > 0.6) & (ratio < 1.5)).all()


def test_feet_on_a_surface_move_with_the_placement():
    """A parabolic trough z = 5 x^2 that slid 3 mm across and 1 mm up finds its twin by distances alone."""
    x, y = (g.ravel() for g in np.meshgrid(np.linspace(-0.05, 0.05, 11), np.linspace(0, 0.1, 5)))
    trough, slid = np.stack([x, y, 5 * x**2], axis=1), np.array([3 * MM, 0, 1 * MM])
    asked = []

    def feet(placement):
        asked.append(placement.shifts[1].copy())
        points = trough + slid
        over = placement.apply(1, points)[:, 0]
        on_trough = np.stack([over, y, 5 * over**2], axis=1)
        normal = np.stack([-10 * over, 0 * over, np.ones_like(over)], axis=1)
        whitening = np.zeros((len(points), 3, 3))
        whitening[:, 2] = normal / np.linalg.norm(normal, axis=1, keepdims=True) / (0.1 * MM)
        return [Tie(first=0, second=1, points_first=on_trough, points_second=points, whitening=whitening)]

    only_shift = np.diag([1e14] * 3 + [1.0] * 3 + [1e14])
    found = fit_pieces(still(2), information(HELD, only_shift), feet).placement.shifts[1]
    np.testing.assert_allclose(found, -slid, atol=1e-5)
    assert len(asked) >= 3
    assert not np.allclose(asked[0], asked[-1])
