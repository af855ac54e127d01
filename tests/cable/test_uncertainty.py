"""Sigma says how far a diameter may be trusted: every part of it by hand, the whole by experiment."""

import numpy as np
import pytest
from scipy.linalg import block_diag

from pipeline.cable.joint_sections import SHAPES, RingSigmas
from pipeline.cable.uncertainty import mean_over
from tests.cable import pieces

QUARTERS = np.radians([0.0, 90.0, 180.0, 270.0])


def test_more_noise_means_more_sigma_and_ten_times_the_points_less():
    blocks, crops = pieces.ring()
    bin_mm = np.deg2rad(1.0) * 55
    quiet, loud = (
        pieces.measure(blocks, crops, noise_mm=n, window_mm=3 * bin_mm).sections[1] for n in (0.03, 0.3)
    )
    assert loud.sigma_image_mm == pytest.approx(10 * quiet.sigma_image_mm)
    # 480 bins of which three are alike, each the mean of 0.03 mm over 3.5 windows: overlaps aside
    bin_mm_2 = 0.03**2 * 0.288 * (1 - 0.288 / 3)
    assert quiet.sigma_image_mm == pytest.approx(2 * np.sqrt(bin_mm_2 * 3 / 480), rel=0.25)


def test_wide_windows_make_neighbours_alike_so_that_they_say_less():
    blocks, crops = pieces.ring()
    narrow, wide = (
        pieces.measure(blocks, crops, noise_mm=0.1, window_mm=w).sections[1].sigma_image_mm
        for w in (3.0, 27.0)
    )
    # nine times fewer around the cable; along it a slice of 10 mm holds 3.3 of the narrow, none of the wide
    assert wide == pytest.approx(3 * narrow * np.sqrt((1 - 10 / 81) / (0.3 * 0.9)), rel=1e-6)


@pytest.mark.parametrize(("length", "window"), [(40, 10), (10, 10), (10, 40)])
def test_the_mean_over_a_length_is_surer_by_the_windows_that_fit_in(length, window):
    """Noise that is alike over a window, made by averaging white noise over it: experiment and formula."""
    white = np.random.default_rng(3).normal(0, 1, 400_000)
    alike = np.convolve(white, np.ones(window) / np.sqrt(window), mode="valid")
    means = np.convolve(alike, np.ones(length) / length, mode="valid")[:: length + window]
    assert float(mean_over(length, np.array([float(window)]))[0]) == pytest.approx(means.var(), rel=0.08)


def test_the_scale_of_the_travel_is_the_scale_of_the_diameter():
    """Design, fact 5: sigma_D / D is at least sigma_L / L."""
    blocks, crops = pieces.ring()
    section = pieces.measure(blocks, crops, travel_share=0.001).sections[1]
    assert section.sigma_scale_mm == pytest.approx(0.110, rel=0.01)
    joined = pieces.placed(covariance=np.kron(np.ones((4, 4)), np.diag([0.0] * 6 + [0.001**2])))
    common = pieces.measure(blocks, crops, joined).sections[1]
    assert common.sigma_scale_mm == pytest.approx(0.110, rel=0.01)


def test_a_shift_of_the_ring_as_a_whole_costs_nothing():
    """All blocks moved alike change no diameter, however little is known of where they are."""
    together = np.kron(np.ones((4, 4)), np.diag([0.0] * 3 + [0.01**2] * 3 + [0.0]))
    section = pieces.measure(*pieces.ring(), pieces.placed(covariance=together)).sections[1]
    assert section.sigma_scale_mm < 1e-3


def test_the_lens_is_the_larger_a_part_the_less_is_known_of_it():
    """Design, fact 1: 1 % of focal length is about 0.6 mm on a circle through one arc of 120 degrees."""
    blocks, crops = pieces.ring()
    arc = pieces.measure(blocks[:1], crops[:1], focal_share=0.01).sections[1]
    assert 0.3 < arc.sigma_lens_mm < 1.2
    ring = pieces.measure(blocks, crops, focal_share=0.01).sections[1]
    assert 0.02 < ring.sigma_lens_mm < arc.sigma_lens_mm / 5
    assert pieces.measure(blocks, crops, focal_share=0.0).sections[1].sigma_lens_mm == 0


def test_errors_are_as_large_as_sigma_says():
    """Blocks that stand off by chance, as their covariance says: the diameters scatter as foretold."""
    sigmas = np.array([2e-4, 2e-4, 2e-4, 2e-4, 2e-4, 2e-4, 4e-4])
    mosaic = pieces.placed(covariance=block_diag(*[np.diag(sigmas**2)] * 4))
    rng = np.random.default_rng(12)
    errors = []
    for _ in range(10):
        drawn = rng.normal(0, sigmas, (4, 7))
        motions = [pieces.Motion(tuple(np.degrees(d[:3])), tuple(1000 * d[3:6]), np.exp(d[6])) for d in drawn]
        # cut in chance places, and believed to stand right
        found = pieces.measure(*pieces.ring(tuple(motions)), mosaic).sections
        errors += [(s.diameter_mm - 110) / s.sigma_mm for s in found]
        assert 0.1 < found[1].sigma_mm < 0.3
    assert 0.6 < np.sqrt(np.mean(np.square(errors))) < 1.5
    assert np.mean(np.abs(errors) < 2) > 0.85


def test_a_ring_that_was_adjusted_together_brings_its_own_sigmas():
    """Between the places where the adjustment told them, they are interpolated; the travel comes on top."""
    blocks, crops = pieces.ring()
    grow = np.zeros(4 * SHAPES)
    grow[::SHAPES] = 1  # all strips alike stand out by so much: twice that is the diameter's
    together = RingSigmas(
        y_m=np.array([0.0, 0.12]),
        azimuth=QUARTERS,
        strips_mm2=0.025**2 * np.array([np.outer(grow, grow)] * 2),
        lens_mm2=np.outer(grow, grow) * np.array([0.005**2, 0.02**2])[:, None, None],
    )
    wide = pieces.placed(covariance=np.eye(28))  # not asked any more
    section = pieces.measure(blocks, crops, wide, together=together, travel_share=0.001).sections[1]
    lens_2 = (0.01**2 + 0.04**2) / 2
    assert section.sigma_lens_mm == pytest.approx(np.sqrt(lens_2), rel=0.001)
    assert section.sigma_scale_mm == pytest.approx(np.sqrt(0.05**2 - lens_2 + 0.110**2), rel=0.001)


def test_a_gap_in_the_ring_lets_a_strip_that_stands_off_change_the_diameter():
    """Strips that each stand off by 0.1 mm: opposite ones hold each other, one alone does not."""
    out = np.zeros(SHAPES)
    out[1] = 0.1
    blocks, crops = pieces.ring()
    sigmas = []
    for count in (4, 3):
        one = np.kron(np.eye(count), np.outer(out, out))
        together = RingSigmas(
            y_m=np.array([0.0, 0.12]),
            azimuth=QUARTERS[:count],
            strips_mm2=np.array([one, one]),
            lens_mm2=np.zeros((2, *one.shape)),
        )
        found = pieces.measure(blocks[:count], crops[:count], together=together).sections[1]
        sigmas.append(found.sigma_scale_mm)
        # by experiment: each strip moved by itself, and cut again
        moved = []
        for number in range(count):
            motions = [pieces.STILL] * 4
            turn = QUARTERS[number]
            motions[number] = pieces.Motion(shift_mm=(0.1 * np.cos(turn), 0.0, -0.1 * np.sin(turn)))
            off, cropped = pieces.ring(tuple(motions))
            stays = pieces.measure(off[:count], cropped[:count]).sections[1]
            moved.append(stays.diameter_mm - 110)
        assert found.sigma_scale_mm == pytest.approx(np.sqrt(np.sum(np.square(moved))), rel=0.1)
    assert sigmas[1] > 1.2 * sigmas[0]
