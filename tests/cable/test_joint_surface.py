"""The surface prior ties the strips of a section to each other and never decides a diameter by itself."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.cable.joint import JointOptions, adjust_ring
from pipeline.cable.joint_surface import tie_point_diameters
from tests.cable import ring_scene, scene

PLACES_M = (0.03, 0.09, 0.15)
STATIONS = tuple(zip("ABC", PLACES_M, strict=True))
PRIOR = JointOptions(surface_sigma_mm=0.2)


def thicker_behind(azimuth, y_m):
    """One millimetre more in diameter from 0.06 to 0.12 m on."""
    return 5e-4 * np.clip((y_m - 0.06) / 0.06, 0, 1) + 0 * azimuth


def fillet(azimuth, y_m):
    """A helix 2 mm high, a turn in 0.25 m."""
    return 2e-3 * (np.abs(np.angle(np.exp(1j * (azimuth - 2 * np.pi * y_m / 0.25)))) < 0.15)


def surveyed(height_m, *, pushed_m=0.0, noise_px=0.05, lens=None, options=PRIOR, emit=scene.silent):
    views = tuple(replace(v, height_m=height_m) for v in ring_scene.views())
    blocks = ring_scene.blocks(views, noise_px, 6, count=250, lens=lens)
    if pushed_m:
        blocks = tuple(replace(b, orientation=_pushed(b.orientation, pushed_m)) for b in blocks)
    marks = ring_scene.marks(views, noise_px, 7, count=40)
    return adjust_ring(blocks, marks, ring_scene.robot(), options, emit, STATIONS)


def _pushed(orientation, by_m):
    """Tie points started by as much too far out, as a wrong nominal diameter starts them."""
    out = orientation.points * [1, 0, 1]
    out = out / np.linalg.norm(out, axis=1, keepdims=True)
    return replace(orientation, points=orientation.points + by_m * out)


def true_mm(height_m):
    base = 2000 * scene.RADIUS_M
    return base + (2000 * height_m(0.0, np.array(PLACES_M)) if height_m is thicker_behind else 0.0)


@pytest.fixture(scope="module")
def stepped():
    """Its measurements are exact, so what is off is the prior's doing."""
    return surveyed(thicker_behind, noise_px=0.0)


@pytest.fixture(scope="module")
def even():
    events = []
    return surveyed(None, emit=events.append), events


def test_it_is_off_unless_asked_for():
    assert JointOptions().surface_sigma_mm == 0
    assert not JointOptions().surface_used


def test_a_cable_that_grows_by_a_millimetre_keeps_its_diameters(stepped):
    """The radius is free at every place: what the prior changes stays within sigma."""
    effect = stepped.surface_effect
    assert effect.names == ("A", "B", "C")
    change = effect.with_mm - effect.without_mm
    assert np.abs(change).max() > 1e-6
    assert (np.abs(change) < 0.3 * effect.without_sigma_mm).all()
    errors = effect.with_mm - true_mm(thicker_behind)
    assert (np.abs(errors) < effect.with_sigma_mm).all()
    assert np.ptp(effect.with_mm) == pytest.approx(1.0, abs=0.02)


def test_a_wrong_nominal_diameter_does_not_pull(even):
    """No option names a size; tie points that start 2.5 mm too far out end where the others do."""
    plain, pushed = even[0].surface_effect, surveyed(None, pushed_m=2.5e-3).surface_effect
    np.testing.assert_allclose(pushed.with_mm, plain.with_mm, atol=0.003)
    assert (np.abs(pushed.with_mm - 2000 * scene.RADIUS_M) < 3 * pushed.with_sigma_mm).all()


def test_a_fillet_of_two_millimetres_does_not_pull():
    effect = surveyed(fillet).surface_effect
    assert (np.abs(effect.with_mm - effect.without_mm) < effect.without_sigma_mm).all()
    assert (np.abs(effect.with_mm - true_mm(fillet)) < 3 * effect.with_sigma_mm).all()


def test_without_asking_for_more_the_result_is_the_one_without_the_prior(stepped):
    alone = surveyed(thicker_behind, noise_px=0.0, options=JointOptions())
    assert alone.surface_effect is None
    for block, same in zip(stepped.blocks, alone.blocks, strict=True):
        np.testing.assert_array_equal(block.poses.centres, same.poses.centres)
        np.testing.assert_array_equal(block.points, same.points)
    np.testing.assert_array_equal(stepped.diameter_sigma_mm, alone.diameter_sigma_mm)
    assert not stepped.surface_effect.used


def test_the_prior_sharpens_lenses_and_its_part_is_in_sigma():
    true = ring_scene.views()[0].lens
    stated = replace(true, focal_sigma_px=0.03 * true.focal_px)
    options = replace(PRIOR, surface_sigma_mm=0.02, surface_used=True)
    tied = surveyed(None, lens=stated, options=options)
    alone = surveyed(None, lens=stated, options=JointOptions())
    effect = tied.surface_effect
    assert effect.used
    np.testing.assert_array_equal(
        effect.with_sigma_mm, np.interp(PLACES_M, tied.section_y_m, tied.diameter_sigma_mm)
    )
    assert (effect.with_sigma_mm < 0.99 * effect.without_sigma_mm).all()
    for block, loose in zip(tied.blocks, alone.blocks, strict=True):
        assert block.lens.focal_sigma_px < 0.9 * loose.lens.focal_sigma_px
        assert abs(block.lens.focal_px - true.focal_px) < 4 * block.lens.focal_sigma_px


def test_diameters_from_tie_points_are_those_of_the_base_and_unknown_where_little_was_seen():
    rng = np.random.default_rng(0)
    azimuth, y = rng.uniform(-np.pi, np.pi, 3000), rng.uniform(0, 0.2, 3000)
    points = (scene.RADIUS_M + fillet(azimuth, y))[:, None] * scene.out_of_cable(azimuth)
    points[:, 1] = y
    whole = tie_point_diameters(points, np.array([0.05, 0.15, 0.5]))
    np.testing.assert_allclose(whole[:2], 2000 * scene.RADIUS_M, atol=1e-3)
    assert np.isnan(whole[2])
    strip = points[np.abs(azimuth) < np.radians(55)]
    assert np.isnan(tie_point_diameters(strip, np.array([0.05]))).all()


def test_progress_counts_the_further_adjustment(even):
    _, events = even
    assert all(e.total == 90 and 0 <= e.done < 90 for e in events)
    assert max(e.done for e in events) >= 60
