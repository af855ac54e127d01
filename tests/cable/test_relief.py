"""What stands proud of a known cylinder is found with its height, and does not pull the cylinder below."""

import numpy as np
import pytest
from scipy import ndimage

from pipeline.cable.relief import ReliefOptions, find_relief

RADIUS_MM, LENGTH_M, CELL_MM = 55.0, 0.30, 0.65
COLUMNS = round(2 * np.pi * RADIUS_MM / CELL_MM)
AZIMUTH = -np.pi + (np.arange(COLUMNS) + 0.5) * 2 * np.pi / COLUMNS
Y_M = np.arange(-0.01, LENGTH_M + 0.01, CELL_MM / 1000)
NOISE_MM, WINDOW_MM = 0.03, 5 * CELL_MM
A, Y_MM = np.meshgrid(AZIMUTH, 1000 * Y_M)


def noise(seed=0, sigma_mm=NOISE_MM):
    """Alike over some three millimetres, as windows that overlap make it."""
    rough = np.random.default_rng(seed).normal(0, 1, A.shape)
    smooth = ndimage.gaussian_filter(rough, 0.9 / CELL_MM, mode=("nearest", "wrap"))
    return sigma_mm * smooth / smooth.std()


def arc_mm(azimuth_deg):
    return RADIUS_MM * np.angle(np.exp(1j * (A - np.radians(azimuth_deg))))


def dome(height_mm, y_mm, azimuth_deg, across_mm=36.0):
    """Rises as the square of a cosine to its height."""
    away = np.hypot(Y_MM - y_mm, arc_mm(azimuth_deg)) / across_mm
    return height_mm * np.cos(np.pi * np.clip(away, 0, 0.5)) ** 2


def helix(height_mm, azimuth_deg, pitch_m, foot_mm=10.0):
    """A rib, a parabola across; ``azimuth_deg`` at y = 0, ``foot_mm`` is its arc around the cable."""
    turned = np.degrees(2 * np.pi * Y_MM / (1000 * pitch_m)) if np.isfinite(pitch_m) else 0 * Y_MM
    arc = RADIUS_MM * np.angle(np.exp(1j * (A - np.radians(azimuth_deg + turned))))
    return height_mm * np.clip(1 - (2 * arc / foot_mm) ** 2, 0, None)


def relief(rise_mm=0.0, seed=0, known=True, start_mm=0.0, **options):
    """The relief of the plain cylinder with ``rise_mm`` on it, seen through the window it is matched with,
    which is laid about the relief ``start_mm``."""
    seen = start_mm + ndimage.uniform_filter(rise_mm - start_mm + 0 * A, 5, mode=("nearest", "wrap"))
    radius = np.where(known, RADIUS_MM + seen + noise(seed), np.nan)
    return find_relief(AZIMUTH, Y_M, radius, LENGTH_M, WINDOW_MM, ReliefOptions(**options))


def holes(share, seed=5):
    """Patches that were not measured, so many in all."""
    field = ndimage.gaussian_filter(np.random.default_rng(seed).normal(0, 1, A.shape), 3)
    return field > np.quantile(field, share)


def test_a_plain_cylinder_is_its_own_base_and_bears_nothing():
    found = relief()
    off_mm = found.base_diameter_mm - 110.0
    inner = slice(20, -20)  # the splines hang at their ends
    assert np.abs(off_mm[inner]).max() < 0.01
    assert np.abs(off_mm / found.base_noise_mm).max() < 4
    assert 0.5 < np.sqrt(np.mean((off_mm / found.base_noise_mm) ** 2)) < 1.5
    assert 0.0003 < np.median(found.base_noise_mm) < 0.005
    assert found.features == ()
    assert np.nanstd(found.height_mm) == pytest.approx(NOISE_MM, rel=0.03)
    assert found.level_mm == pytest.approx(0.2, abs=0.05)


def test_an_oval_off_the_axis_that_tapers_is_no_relief():
    """Centre 3 mm off: seen from the axis the radius swings by 3 mm, the mean by -0.04 mm."""
    centre_mm = np.array([3.0 * np.sin(np.pi * Y_MM / 300), 0.004 * Y_MM])
    radius = RADIUS_MM + 0.001 * Y_MM
    for _ in range(20):  # the radius about the axis of points on the oval about its centre
        total = RADIUS_MM + 0.001 * Y_MM if _ == 0 else radius
        x, z = total * np.cos(A) - centre_mm[0], -total * np.sin(A) - centre_mm[1]
        oval = RADIUS_MM + 0.001 * Y_MM + 0.2 * np.cos(2 * (np.arctan2(-z, x) - 0.4))
        radius = total + oval - np.hypot(x, z)
    found = relief(radius - RADIUS_MM)
    np.testing.assert_allclose(found.base_diameter_mm, 110.0 + 2 * Y_M, atol=0.015)
    assert found.features == ()


@pytest.fixture(scope="module")
def spots():
    """Three bulges of 1.5 mm and three dents of 1 mm on an oval, a tenth of the map unmeasured."""
    true = [(sign * h, y, a) for a, y, sign, h in (
        (20, 60, 1, 1.5), (140, 230, 1, 1.5), (-100, 150, 1, 1.5),
        (179, 80, -1, 1.0), (-50, 250, -1, 1.0), (80, 140, -1, 1.0),
    )]  # fmt: skip
    rise = sum(dome(*spot) for spot in true) + 0.2 * np.cos(2 * (A - 0.4))
    return true, relief(rise, seed=3, known=holes(0.1))


def test_bulges_and_dents_have_their_heights_and_places(spots):
    true, found = spots
    assert len(found.features) == len(true)
    for height, y_mm, azimuth_deg in true:
        mine = min(found.features, key=lambda f: abs(1000 * f.position_m - y_mm))
        assert mine.kind == ("bulge" if height > 0 else "dent")
        assert mine.height_mm == pytest.approx(abs(height), abs=0.06)
        assert mine.position_m == pytest.approx(y_mm / 1000, abs=0.001)
        assert abs((mine.azimuth_deg - azimuth_deg + 180) % 360 - 180) < 1.0
        assert -180 <= mine.azimuth_deg <= 180
        assert 24 < mine.length_mm < 38
        assert 24 < mine.width_mm < 38
        assert np.isnan(mine.pitch_m)


def test_the_largest_come_first(spots):
    heights = [f.height_mm for f in spots[1].features]
    assert heights == sorted(heights, reverse=True)


def test_sigma_of_a_bulge_means_what_it_says(spots):
    true, found = spots
    nearest = [min(true, key=lambda t, f=f: abs(1000 * f.position_m - t[1])) for f in found.features]
    errors = np.array([f.height_mm - abs(t[0]) for f, t in zip(found.features, nearest, strict=True)])
    sigma = np.array([f.sigma_mm for f in found.features])
    assert (np.abs(errors) < 2.5 * sigma).all()
    assert np.sqrt(np.mean(errors**2)) > np.median(sigma) / 4


def test_bulges_do_not_pull_the_base(spots):
    np.testing.assert_allclose(spots[1].base_diameter_mm, 110.0, atol=0.02)


@pytest.mark.parametrize("pitch_m", [0.6, -0.35])
def test_a_double_helix_is_two_ridges(pitch_m):
    ribs = helix(2.0, 30, pitch_m) + helix(2.0, 210, pitch_m)
    found = relief(ribs, seed=1, start_mm=ribs / 2)
    assert [f.kind for f in found.features] == ["ridge", "ridge"]
    np.testing.assert_allclose(found.base_diameter_mm, 110.0, atol=0.02)
    slant = np.cos(np.arctan(2 * np.pi * RADIUS_MM / 1000 / pitch_m))
    wanted_deg = (30 + 360 * LENGTH_M / 2 / pitch_m) % 180
    for ridge in found.features:
        assert ridge.height_mm == pytest.approx(2.0, abs=0.05)
        assert 0.01 < ridge.sigma_mm < 0.5
        assert ridge.pitch_m == pytest.approx(pitch_m, rel=0.005)
        assert ridge.position_m == LENGTH_M / 2
        assert (ridge.azimuth_deg - wanted_deg + 90) % 180 - 90 == pytest.approx(0, abs=0.6)
        assert 10 * slant * np.sqrt(0.95) - 0.5 < ridge.width_mm < 10 * slant + WINDOW_MM
        assert ridge.length_mm == pytest.approx(1000 * np.ptp(Y_M), abs=5)
    apart = (found.features[0].azimuth_deg - found.features[1].azimuth_deg) % 360
    assert apart == pytest.approx(180, abs=1)


@pytest.mark.parametrize("follows", [0.0, 0.5, 1.0])
def test_a_crest_is_as_high_as_its_sigma_says_however_far_the_windows_followed_it(follows):
    rib = helix(2.0, 30, 0.6)
    (ridge,) = relief(rib, seed=1, start_mm=follows * rib).features
    assert abs(ridge.height_mm - 2.0) < 2 * ridge.sigma_mm
    assert ridge.sigma_mm < 0.08


def test_a_ridge_whose_flanks_are_lost_keeps_its_crest():
    rise = helix(2.0, 30, 0.6)
    known = ~((rise > 0) & (rise < 1.7)) & holes(0.05)
    found = relief(rise, known=known)
    assert len(found.features) == 1
    assert found.features[0].height_mm == pytest.approx(2.0, abs=0.06)
    assert found.features[0].pitch_m == pytest.approx(0.6, rel=0.005)


def test_a_ridge_straight_along_has_no_pitch():
    found = relief(helix(1.0, 178, np.inf))
    assert [f.kind for f in found.features] == ["ridge"]
    assert np.isnan(found.features[0].pitch_m)
    assert abs(found.features[0].azimuth_deg - 178) < 0.6


def test_a_bulge_beside_a_ridge_is_a_bulge():
    found = relief(helix(2.0, 30, 0.6) + dome(1.5, 150, -60))
    assert [f.kind for f in found.features] == ["ridge", "bulge"]
    assert found.features[1].height_mm == pytest.approx(1.5, abs=0.06)


@pytest.mark.parametrize(
    "rise",
    [
        1.0 * ((np.abs(arc_mm(70)) < 2 * np.pi * RADIUS_MM / 8) & (np.abs(Y_MM - 150) < 50)),
        sum(2.0 * (np.abs(arc_mm(a)) < 2 * np.pi * RADIUS_MM / 32) for a in (10, 100, 190, 280)),
    ],
    ids=["one plateau", "four bands"],
)
def test_a_quarter_of_the_girth_may_stand_proud(rise):
    found = relief(rise + 0.1 * np.cos(2 * (A - 0.4)))
    np.testing.assert_allclose(found.base_diameter_mm, 110.0, atol=0.03)


def test_what_is_lower_than_asked_for_is_left_alone():
    low = dome(0.35, 150, 0)
    assert len(relief(low).features) == 1
    assert relief(low, least_height_mm=0.5).features == ()


def test_a_noisy_map_bears_no_features_either():
    radius = RADIUS_MM + noise(7, sigma_mm=0.15) * np.where(Y_MM < 40, 2, 1)
    found = find_relief(AZIMUTH, Y_M, radius, LENGTH_M, WINDOW_MM, ReliefOptions())
    assert found.features == ()


@pytest.mark.parametrize(("widest_mm", "found"), [(WINDOW_MM + 0.1, 1), (WINDOW_MM - 0.1, 0)])
def test_in_a_map_of_wide_windows_no_features_are_looked_for(widest_mm, found):
    """They flatten relief, and their noise looks like it; the base stands all the same."""
    seen = relief(dome(1.5, 150, 0), widest_window_mm=widest_mm)
    assert len(seen.features) == found
    assert np.isfinite(seen.level_mm) == bool(found)
    np.testing.assert_allclose(seen.base_diameter_mm, 110.0, atol=0.02)


def test_broad_windows_are_too_wide_unless_told_otherwise():
    """Narrow ones are some 3 to 6 mm wide, broad ones from 20 mm."""
    assert 6 < ReliefOptions().widest_window_mm < 20


@pytest.mark.parametrize("share", [0.03, 0.0])
def test_where_next_to_nothing_was_seen_nothing_is_told(share):
    found = relief(known=holes(1 - share))
    assert np.isnan(found.base_diameter_mm).all()
    assert np.isnan(found.height_mm).all()
    assert found.features == ()


def test_the_same_map_gives_the_same_relief():
    first, second = (relief(dome(1.5, 150, 0)) for _ in range(2))
    assert repr(first.features) == repr(second.features)
    np.testing.assert_array_equal(first.base_diameter_mm, second.base_diameter_mm)
