"""The figure of docs/accuracy.md rests on this: a strip cannot see its focal length, the ring can."""

from dataclasses import replace

import numpy as np
import pytest

from tools.observability.__main__ import calm_survey, main
from tools.observability.adjustment import adjust
from tools.observability.figure import Results, draw
from tools.observability.simulation import RADIUS_M, Noise, simulate

POINTS, MARKS = 150, 60


@pytest.fixture(scope="module")
def strip():
    return simulate(calm_survey(), 1, POINTS, MARKS)


@pytest.fixture(scope="module")
def ring():
    return simulate(calm_survey(), 4, POINTS, MARKS)


def held(simulation, percents=(-3.0, 0.0, 3.0)):
    return [adjust(simulation, percent, held=True) for percent in percents]


def objection(found):
    """Cost of the wrong focal lengths above that of the true one."""
    return min(found[0].cost, found[2].cost) - found[1].cost


def test_points_lie_on_the_cable_and_only_neighbours_share_marks(ring):
    np.testing.assert_allclose(np.hypot(ring.starts[:, 0], ring.starts[:, 2]), RADIUS_M)
    seen = ring.observations
    by_point = [set(seen.camera[seen.point == p]) for p in range(len(ring.starts))]
    alone, shared = by_point[: 4 * POINTS], by_point[4 * POINTS :]
    assert {len(cameras) for cameras in alone} == {1}
    pairs = [{n, (n + 1) % 4} for n in range(4)]
    assert all(
        cameras <= pair for n, pair in enumerate(pairs) for cameras in shared[n * MARKS : (n + 1) * MARKS]
    )
    assert sum(len(cameras) == 2 for cameras in shared) > 0.9 * len(shared)


def test_without_noise_and_sway_nothing_is_left_and_nothing_is_wrong():
    survey = calm_survey()
    still = replace(survey.robot, sway_deg=1e-9, sway_mm=1e-9, speed_wander_mm=1e-9)
    exact = Noise(tracking_px=1e-9, matching_px=6e-9)
    seen = simulate(replace(survey, robot=still), 4, POINTS, MARKS, exact)
    found = adjust(seen, 0.0, held=True)
    assert found.reprojection_px < 1e-3
    assert abs(found.diameter_mm) < 0.005


def test_a_strip_looks_the_same_with_any_focal_length_while_its_diameter_goes(strip):
    found = held(strip)
    assert np.ptp([f.reprojection_px for f in found]) < 0.005 * found[1].reprojection_px
    assert abs(objection(found)) < 4**2  # a hint at most: 3 % off is within four sigmas
    assert found[0].diameter_mm - found[2].diameter_mm > 3.0


def test_the_ring_objects_and_its_diameter_holds(ring):
    found = held(ring)
    assert objection(found) > 20**2
    assert np.ptp([f.diameter_mm for f in found]) < 1.0


def test_the_ring_finds_a_focal_length_from_5_percent_off_and_the_strip_does_not(strip, ring):
    alone, together = (adjust(simulation, 5.0, held=False) for simulation in (strip, ring))
    assert 1e-5 < abs(together.focal_percent) < 0.3
    assert abs(together.diameter_mm) < 0.06
    assert abs(alone.focal_percent) > 0.5
    assert abs(alone.diameter_mm) > 0.4
    assert alone.reprojection_px == pytest.approx(np.sqrt(2) * Noise().tracking_px, rel=0.1)


def test_the_figure_is_the_same_every_time(strip, ring, tmp_path):
    found = {"one strip": held(strip, (-1.0, 1.0)), "ring of four": held(ring, (-1.0, 1.0))}
    for name in ("first.svg", "second.svg"):
        draw(Results(held=found, free=found), tmp_path / name)
    text = (tmp_path / "first.svg").read_text()
    assert "<svg" in text
    assert text == (tmp_path / "second.svg").read_text()


def test_help_tells_what_it_does(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    assert "docs/accuracy.md" in capsys.readouterr().out
