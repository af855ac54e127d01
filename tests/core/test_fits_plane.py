"""Line, circle and ellipse fits: exact on clean points, unbiased on noisy arcs, honest sigmas."""

import numpy as np
import pytest

from pipeline.core.errors import StageError
from pipeline.core.fits import CirclePrior, FitOptions, Loss, fit_circle, fit_ellipse, fit_line
from pipeline.core.fits.circle import algebraic_circle

LEAST_SQUARES = FitOptions(loss=Loss.LEAST_SQUARES)


def arc(rng, *, centre=(3.0, -2.0), radius=55.0, span_deg=116.0, count=400, noise=0.1):
    t = np.radians(np.linspace(-span_deg / 2, span_deg / 2, count))
    rho = radius + noise * rng.normal(size=count)
    return np.column_stack([centre[0] + rho * np.cos(t), centre[1] + rho * np.sin(t)])


def test_line_through_clean_points_is_exact():
    t = np.linspace(-2, 5, 20)
    line = fit_line(np.column_stack([1 + 0.8 * t, 2 + 0.6 * t]))
    np.testing.assert_allclose(np.abs(line.normal), [0.6, 0.8], atol=1e-12)
    np.testing.assert_allclose(
        line.distances([[1.0, 2.0], [0.4, 2.8]]) * np.sign(line.normal[1]), [0, 1], atol=1e-9
    )


def test_line_ignores_a_quarter_of_gross_errors():
    rng = np.random.default_rng(0)
    t = np.linspace(0, 100, 200)
    points = np.column_stack([t, 0.02 * t + 0.1 * rng.normal(size=200)])
    points[rng.choice(200, 50, replace=False), 1] += rng.uniform(3, 40, 50)
    line = fit_line(points)
    assert abs(line.distances([[0.0, 0.0]])[0]) < 0.1
    assert -line.normal[0] / line.normal[1] == pytest.approx(0.02, abs=0.001)
    assert 40 <= np.sum(line.robust_weights == 0) <= 60


def test_line_sigma_is_the_textbook_one():
    rng = np.random.default_rng(1)
    t = np.linspace(-1, 1, 401)
    line = fit_line(np.column_stack([t, 0.01 * rng.normal(size=401)]), options=LEAST_SQUARES)
    assert np.sqrt(line.covariance[0, 0]) == pytest.approx(0.01 / np.sqrt(np.sum(t**2)), rel=0.1)
    assert np.sqrt(line.covariance[1, 1]) == pytest.approx(0.01 / np.sqrt(401), rel=0.1)


def test_circle_through_clean_arc_is_exact():
    circle = fit_circle(arc(np.random.default_rng(0), noise=0.0, span_deg=60))
    np.testing.assert_allclose([*circle.centre, circle.radius], [3, -2, 55], atol=1e-8)


def test_geometric_circle_is_unbiased_where_an_algebraic_one_is_too_small():
    """Design fact 8.  Kasa's circle (plain algebraic) shrinks with the noise; ours stays within scatter."""
    rng = np.random.default_rng(4)
    ours, kasa, claimed = [], [], []
    for _ in range(200):
        points = arc(rng, noise=1.0, count=120)
        circle = fit_circle(points, options=LEAST_SQUARES)
        ours.append(circle.radius - 55)
        claimed.append(circle.radius_sigma)
        design = np.column_stack([points, np.ones(len(points))])
        x, y, d = np.linalg.lstsq(design, np.sum(points**2, axis=1), rcond=None)[0]
        kasa.append(np.sqrt(d + x * x / 4 + y * y / 4) - 55)
    scatter = np.std(ours)
    assert abs(np.mean(ours)) < 3 * scatter / np.sqrt(200)
    assert np.mean(kasa) < -5 * scatter / np.sqrt(200)
    assert np.mean(claimed) == pytest.approx(scatter, rel=0.15)


def test_circle_sigma_holds_for_the_robust_loss_too():
    rng = np.random.default_rng(5)
    fits = [fit_circle(arc(rng, count=150)) for _ in range(150)]
    scatter = np.std([fit.radius for fit in fits])
    assert np.mean([fit.radius_sigma for fit in fits]) == pytest.approx(scatter, rel=0.15)
    assert np.mean([fit.noise_sigma for fit in fits]) == pytest.approx(0.1, rel=0.1)


def test_circle_ignores_a_quarter_of_one_sided_gross_errors():
    rng = np.random.default_rng(6)
    points = arc(rng)
    bad = rng.choice(400, 100, replace=False)
    points[bad] += rng.uniform(1, 15, (100, 1)) * (points[bad] - [3, -2]) / 55
    assert abs(fit_circle(points).radius - 55) < 0.15
    assert fit_circle(points, options=LEAST_SQUARES).radius - 55 > 0.3


def test_circle_through_two_arcs_with_weights_follows_the_weight():
    rng = np.random.default_rng(7)
    left, right = arc(rng, span_deg=80), arc(rng, span_deg=80)
    right[:, 0] = 6 - right[:, 0]
    closed = fit_circle(np.concatenate([left, right]))
    assert closed.radius == pytest.approx(55, abs=4 * closed.radius_sigma)
    assert closed.radius_sigma < 0.2 * fit_circle(left).radius_sigma
    right[:, 0] -= 1.0  # the arcs now contradict each other
    weights = np.repeat([1.0, 0.0], 400)
    alone = fit_circle(np.concatenate([left, right]), weights)
    assert alone.radius == pytest.approx(fit_circle(left).radius, abs=1e-6)


def test_circle_prior_steadies_a_short_arc():
    points = arc(np.random.default_rng(8), span_deg=20, count=100)
    free = fit_circle(points)
    held = fit_circle(points, prior=CirclePrior(centre=(3.0, -2.0), centre_sigma=0.05))
    assert free.radius_sigma > 0.5
    assert held.radius_sigma < 0.06
    assert abs(held.radius - 55) < 0.15
    exact = fit_circle(points, prior=CirclePrior(radius=55.0, radius_sigma=1e-6))
    assert exact.radius == pytest.approx(55.0, abs=1e-5)


def test_points_that_make_no_circle_are_refused():
    with pytest.raises(StageError, match="at least 3"):
        fit_circle([[0.0, 0.0], [1.0, 0.0]])
    with pytest.raises(StageError, match="line"):
        fit_circle(np.column_stack([np.arange(9.0), np.arange(9.0)]))
    with pytest.raises(StageError, match="finite"):
        fit_circle([[0.0, np.nan], [1.0, 0.0], [0.0, 1.0]])
    with pytest.raises(StageError, match="weights"):
        fit_circle(np.eye(3)[:, :2], [1.0, -1.0, 1.0])


def test_pratt_start_is_exact_on_clean_points():
    points = arc(np.random.default_rng(0), noise=0.0)
    np.testing.assert_allclose(algebraic_circle(points, np.ones(400)), [3, -2, 55], atol=1e-7)


def ellipse_points(*, semi=(56.0, 54.0), angle_deg=30.0, noise=0.0, count=360, span_deg=360.0, seed=0):
    t = np.radians(np.linspace(-span_deg / 2, span_deg / 2, count, endpoint=False))
    turn = np.radians(angle_deg)
    x, y = semi[0] * np.cos(t), semi[1] * np.sin(t)
    points = np.column_stack(
        [x * np.cos(turn) - y * np.sin(turn) + 1, x * np.sin(turn) + y * np.cos(turn) + 2]
    )
    return points + noise * np.random.default_rng(seed).normal(size=points.shape)


@pytest.mark.parametrize("semi", [(55.3, 55.1), (56.0, 54.0), (70.0, 45.0)])
def test_ellipse_through_clean_points_is_exact(semi):
    ellipse = fit_ellipse(ellipse_points(semi=semi))
    np.testing.assert_allclose(ellipse.centre, [1, 2], atol=1e-6)
    assert ellipse.largest_diameter == pytest.approx(2 * semi[0], abs=1e-6)
    assert ellipse.smallest_diameter == pytest.approx(2 * semi[1], abs=1e-6)
    assert ellipse.mean_diameter == pytest.approx(sum(semi), abs=1e-6)
    assert ellipse.angle_deg == pytest.approx(30, abs=1e-4)


def test_ellipse_of_a_circle_is_a_circle_with_honest_sigma():
    fits = [
        fit_ellipse(ellipse_points(semi=(55, 55), noise=0.1, seed=seed), options=LEAST_SQUARES)
        for seed in range(60)
    ]
    means = [fit.mean_diameter - 110 for fit in fits]
    assert abs(np.mean(means)) < 3 * np.std(means) / np.sqrt(60)
    assert np.mean([fit.mean_diameter_sigma for fit in fits]) == pytest.approx(np.std(means), rel=0.3)
    ovality = np.array([fit.largest_diameter - fit.smallest_diameter for fit in fits])
    assert np.sqrt(np.mean(ovality**2) / 2) == pytest.approx(fits[0].ovality_sigma, rel=0.3)


def test_ellipse_prior_holds_the_shape_where_only_an_arc_is_seen():
    points = ellipse_points(semi=(55.5, 55.0), noise=0.1, span_deg=100)
    free, held = fit_ellipse(points), fit_ellipse(points, ovality_sigma=0.5)
    assert held.mean_diameter_sigma < 0.5 * free.mean_diameter_sigma
    assert abs(held.mean_diameter - 110.5) < 3 * held.mean_diameter_sigma
    assert held.largest_diameter - held.smallest_diameter < 1.5


def test_figure_far_from_a_circle_is_refused():
    with pytest.raises(StageError, match="nearly circular"):
        fit_ellipse(ellipse_points(semi=(80.0, 45.0)))
