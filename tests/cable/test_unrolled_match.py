"""Neighbours are matched where their unrolled pictures show the same marks, and nowhere else."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.cable.texture import UnrolledPicture
from pipeline.cable.unrolled_match import UnrolledMatchOptions, match_unrolled
from tests.cable import scene

TEXEL_MM = 0.5
TEXEL_RAD = TEXEL_MM / 1000 / scene.RADIUS_M
TEXTURE = scene.Texture(seed=0)


def picture(first_deg, last_deg, turn=0.0, rise=0.0, stretch=0.0, texture=TEXTURE, noise=0.0, seed=0):
    """The stretch between two azimuths, its own coordinates off by ``turn`` and ``rise`` texels."""
    azimuth = np.arange(np.radians(first_deg), np.radians(last_deg), TEXEL_RAD)
    y_m = np.arange(0, 0.12, TEXEL_MM / 1000)
    a, y = np.meshgrid(azimuth + turn * TEXEL_RAD, y_m * (1 + stretch) + rise * TEXEL_MM / 1000)
    gray = texture(a, y) + np.random.default_rng(seed).normal(0, noise, a.shape)
    return UnrolledPicture(
        azimuth=azimuth,
        y_m=y_m,
        colour=np.repeat(np.clip(np.rint(gray), 0, 255).astype(np.uint8)[..., None], 3, axis=2),
        known=np.ones(gray.shape, dtype=bool),
        texel_mm=TEXEL_MM,
    )


def match(first, second, **options):
    return match_unrolled(first, second, scene.RADIUS_M, UnrolledMatchOptions(**options))


def shifts(found):
    """Second minus first in texels, (k, 2) around and along."""
    return (found.second - found.first) / [TEXEL_RAD, TEXEL_MM / 1000]


@pytest.mark.parametrize(("turn", "rise"), [(0, 0), (2.3, -1.7), (-0.5, 0.25), (5.0, 4.0)])
def test_a_known_shift_is_found_to_a_tenth_of_a_texel(turn, rise):
    found = match(picture(-60, 60), picture(30, 150, turn, rise))
    assert len(found.first) > 50
    # the second's coordinates run behind by what was added: the same mark has smaller ones
    np.testing.assert_allclose(np.median(shifts(found), axis=0), [-turn, -rise], atol=0.04)
    away = np.linalg.norm(shifts(found) + np.array([turn, rise]), axis=1)
    assert np.percentile(away, 75) < 0.1
    assert np.percentile(away, 95) < 0.4


def test_matches_lie_where_both_pictures_look():
    found = match(picture(-60, 60), picture(30, 150))
    for side in (found.first, found.second):
        assert np.radians(30) < side[:, 0].min()
        assert side[:, 0].max() < np.radians(60)
        assert side[:, 1].min() > 0
        assert side[:, 1].max() < 0.12
    assert np.ptp(found.first[:, 1]) > 0.08  # spread along the cable


def test_a_stretched_neighbour_is_matched_all_along():
    """A scale off by 1 % shifts the ends against each other by 2.4 texels."""
    found = match(picture(-60, 60), picture(30, 150, stretch=0.01))
    assert len(found.first) > 50
    away_mm = 1000 * np.abs(found.second[:, 1] * 1.01 - found.first[:, 1])
    assert np.percentile(away_mm, 95) < 0.05
    assert np.ptp(found.first[:, 1]) > 0.08


def test_noise_costs_precision_and_not_truth():
    found = match(picture(-60, 60, noise=6, seed=1), picture(30, 150, 1.4, 0.6, noise=6, seed=2))
    away = shifts(found) + np.array([1.4, 0.6])
    assert np.abs(np.median(away, axis=0)).max() < 0.05
    assert 0.005 < np.median(np.abs(away)) < 0.2


def test_the_neighbour_across_the_seam_is_the_same_neighbour():
    """Azimuths of one block count on from 300 degrees, of the other from -60: a whole turn lies between."""
    near = match(picture(-60, 60, 1.0), picture(-150, -30))
    across = match(picture(-60, 60, 1.0), picture(210, 330))
    assert len(across.first) == len(near.first) > 50
    np.testing.assert_allclose(across.first, near.first, atol=1e-6)
    np.testing.assert_allclose(across.second - [2 * np.pi, 0], near.second, atol=1e-4)
    opposite = match(picture(210, 330), picture(-60, 60, 1.0))
    turned = np.median(opposite.second[:, 0] - opposite.first[:, 0])
    assert turned == pytest.approx(-2 * np.pi - TEXEL_RAD, abs=0.1 * TEXEL_RAD)


def test_brightness_does_not_matter():
    first, second = picture(-60, 60), picture(30, 150, 1.0)
    dull = replace(second, colour=(0.5 * second.colour + 20).astype(np.uint8))
    found = match(first, dull)
    assert len(found.first) > 50
    np.testing.assert_allclose(np.median(shifts(found), axis=0), [-1, 0], atol=0.05)


@pytest.mark.parametrize("seed", range(4, 10))
def test_pictures_of_different_surfaces_have_nothing_in_common(seed):
    """Of some hundred corners a dozen always correlate at about the same shift: that is chance."""
    found = match(picture(-60, 60), picture(30, 150, texture=scene.Texture(seed=seed)))
    assert found.first.shape == found.second.shape == (0, 2)


def test_pictures_that_do_not_overlap_have_nothing_in_common():
    assert len(match(picture(-40, 40), picture(50, 130)).first) == 0


@pytest.mark.parametrize("gray", [0, 128])
def test_an_even_surface_has_no_marks(gray):
    even = replace(picture(-60, 60), colour=np.full_like(picture(-60, 60).colour, gray))
    assert len(match(even, picture(30, 150)).first) == 0
    assert len(match(picture(30, 150), even).first) == 0


def test_a_shift_beyond_the_search_is_not_found_as_another():
    found = match(picture(-60, 60), picture(30, 150, rise=20.0), search_mm=4.0)  # 10 mm
    assert len(found.first) < 8


def test_what_is_not_known_is_not_matched():
    first, second = picture(-60, 60), picture(30, 150)
    known = second.known.copy()
    known[: len(known) // 2] = False
    found = match(first, replace(second, known=known))
    assert len(found.first) > 20
    assert found.second[:, 1].min() > 0.06


def test_one_half_that_slipped_is_outvoted():
    """A third of the overlap shows the texture 2 mm further on: the smooth majority counts."""
    second = picture(30, 150)
    slipped = picture(30, 150, rise=4.0)
    part = len(second.y_m) // 3
    colour = second.colour.copy()
    colour[:part] = slipped.colour[:part]
    found = match(picture(-60, 60), replace(second, colour=colour))
    assert len(found.first) > 30
    np.testing.assert_allclose(np.median(shifts(found), axis=0), [0, 0], atol=0.05)
    assert np.linalg.norm(shifts(found), axis=1).max() < 1.0
