"""Diameters are those of the cable, with a standard deviation that tells how far they may be trusted."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import block_diag

from pipeline.cable.measure import MeasureOptions, measure_ring
from pipeline.cable.ring import Alignment
from pipeline.core.errors import StageError
from tests.cable import pieces, scene
from tests.cable.test_ring import build

STATIONS = (("A", 0.02), ("B", 0.06), ("C", 0.10))
LENS_KNOWN = 1e-9


def measure(
    blocks,
    crops,
    mosaic=None,
    stations=STATIONS,
    noise_mm=0.03,
    focal=LENS_KNOWN,
    travel_share=0.0,
    emit=scene.silent,
    **options,
):
    mosaic = mosaic or pieces.placed((pieces.STILL,) * len(blocks))
    return measure_ring(
        blocks,
        crops,
        mosaic,
        build(blocks, crops, mosaic, cell_mm=4.0, texel_mm=8.0),
        (noise_mm,) * len(blocks),
        (focal,) * len(blocks),
        travel_share,
        stations,
        pieces.TRAVEL_M,
        MeasureOptions(**{"profile_mm": 40.0, **options}),
        emit,
    )


@pytest.fixture(scope="module")
def plain():
    return measure(*pieces.ring(noise_mm=0.03))


def test_a_circle_has_its_diameter_at_every_station(plain):
    assert [s.name for s in plain.sections] == ["A", "B", "C"]
    assert [s.position_m for s in plain.sections] == [0.02, 0.06, 0.10]
    for section in plain.sections:
        assert section.diameter_mm == pytest.approx(110.0, abs=0.004)
        assert 109.98 < section.min_mm <= section.diameter_mm <= section.max_mm < 110.02
        assert section.coverage_deg == 360
        np.testing.assert_allclose(section.centre_mm, 0, atol=0.01)
        assert section.points_mm.shape[1] == 2
        np.testing.assert_allclose(np.hypot(*section.points_mm.T), 55, atol=0.05)
    assert plain.unmeasured == ()


def test_the_blocks_are_measured_where_the_mosaic_put_them():
    blocks, crops = pieces.ring(pieces.ASTRAY)
    right = measure(blocks, crops, pieces.placed(pieces.ASTRAY))
    wrong = measure(blocks, crops)
    assert right.sections[1].diameter_mm == pytest.approx(110.0, abs=0.01)
    assert abs(wrong.sections[1].diameter_mm - 110.0) > 0.03


@pytest.mark.parametrize("turn_deg", [0, 30, 77])
def test_an_oval_has_its_two_axes_and_their_mean(turn_deg):
    """r = 55 + 0.3 cos 2a: axes of 110.6 and 109.4 mm."""

    def oval(azimuth, y_m):
        return scene.RADIUS_M + 0.0003 * np.cos(2 * (azimuth - np.radians(turn_deg))) + 0 * y_m

    section = measure(*pieces.ring(true_radius=oval)).sections[1]
    assert section.diameter_mm == pytest.approx(110.0, abs=0.01)
    assert section.max_mm == pytest.approx(110.6, abs=0.03)
    assert section.min_mm == pytest.approx(109.4, abs=0.03)


def test_stations_along_a_taper_differ_as_the_cable_does():
    """Two millimetres of diameter a metre: 0.08 mm from A to B."""
    found = measure(*pieces.ring(true_radius=lambda a, y: 0.0549 + 0.001 * y + 0 * a), profile_mm=5.0)
    for section in found.sections:
        assert section.diameter_mm == pytest.approx(109.8 + 2 * section.position_m, abs=0.01)
    truth = 109.8 + 2 * found.profile_y_m
    np.testing.assert_allclose(found.profile_diameter_mm, truth, atol=0.02)
    np.testing.assert_allclose(found.profile_y_m, np.arange(0, 0.1201, 0.005))


def test_closed_holes_are_not_measured():
    """A hole was closed 3 mm too high: that is nobody's measurement."""
    blocks, crops = pieces.ring()
    surface = blocks[0].surface
    hole = np.zeros_like(surface.measured)
    hole[85:115, 40:100] = True
    radius = np.where(hole, surface.radius_m + 0.003, surface.radius_m).astype(np.float32)
    spoiled = replace(blocks[0], surface=replace(surface, radius_m=radius, measured=~hole))
    section = measure((spoiled, *blocks[1:]), crops).sections[1]
    assert section.diameter_mm == pytest.approx(110.0, abs=0.01)


def test_cropped_cells_are_not_measured():
    blocks, crops = pieces.ring()
    radius = blocks[0].surface.radius_m.copy()
    keep = crops[0].keep.copy()
    radius[:, :30] += 0.003
    keep[:, :30] = False
    blocks = (replace(blocks[0], surface=replace(blocks[0].surface, radius_m=radius), keep=keep), *blocks[1:])
    crops = (replace(crops[0], keep=keep), *crops[1:])
    assert measure(blocks, crops).sections[1].diameter_mm == pytest.approx(110.0, abs=0.01)


@pytest.mark.parametrize(("count", "coverage_deg"), [(4, 360), (3, 300), (2, 210), (1, 120)])
@pytest.mark.parametrize("bin_deg", [1.0, 3.0])
def test_the_angle_that_was_seen_is_told(count, coverage_deg, bin_deg):
    """Neighbours overlap by 30 degrees of their 120."""
    blocks, crops = pieces.ring()
    found = measure(blocks[:count], crops[:count], bin_deg=bin_deg)
    assert found.sections[1].coverage_deg == pytest.approx(coverage_deg, abs=6 if count < 4 else 0)
    assert found.sections[1].diameter_mm == pytest.approx(110.0, abs=0.02)


def test_a_station_that_was_hardly_seen_is_named_and_not_measured():
    stations = (*STATIONS, ("beyond", 0.2), ("before", -0.1))
    found = measure(*pieces.ring(), stations=stations)
    assert [s.name for s in found.sections] == ["A", "B", "C"]
    assert found.unmeasured == ("beyond", "before")


def test_no_station_at_all_is_refused():
    with pytest.raises(StageError) as told:
        measure(*pieces.ring(), stations=(("Z", 0.5),))
    assert str(told.value) == (
        "measure: no station was seen well enough to be measured; place stations where the cameras passed."
    )


def test_too_small_an_arc_is_no_circle():
    blocks, crops = pieces.ring()
    with pytest.raises(StageError, match="no station was seen well enough"):
        measure(blocks[:1], crops[:1], least_coverage_deg=150.0)


def test_a_straight_cable_is_straight_and_a_bowed_one_is_not(plain):
    """Centres on a parabola of 0.5 mm sagitta over 0.12 m: 0.33 mm off the best line, 2.8 mm a metre."""
    assert plain.straightness_mm_per_m < 0.1
    np.testing.assert_allclose(plain.profile_centre_mm, 0, atol=0.01)

    def bowed(azimuth, y_m):
        bow = 0.0005 * (1 - ((y_m - 0.06) / 0.06) ** 2)
        return scene.RADIUS_M + bow * np.cos(azimuth)

    found = measure(*pieces.ring(true_radius=bowed), profile_mm=5.0)
    assert found.straightness_mm_per_m == pytest.approx(0.5 * 2 / 3 / 0.12, rel=0.15)
    ends = (found.profile_centre_mm[0, 0] + found.profile_centre_mm[-1, 0]) / 2
    assert found.profile_centre_mm[12, 0] - ends == pytest.approx(0.5, abs=0.03)


def test_more_noise_means_more_sigma_and_ten_times_the_points_less():
    blocks, crops = pieces.ring()
    quiet, loud = (measure(blocks, crops, noise_mm=n).sections[1] for n in (0.03, 0.3))
    assert loud.sigma_image_mm == pytest.approx(10 * quiet.sigma_image_mm)
    # 480 bins of which three are alike, each worth 0.03 mm of radius: 2 * 0.03 sqrt(3 / 480), overlaps aside
    assert quiet.sigma_image_mm == pytest.approx(2 * 0.03 * np.sqrt(3 / 480), rel=0.25)


def test_the_scale_of_the_travel_is_the_scale_of_the_diameter():
    """Design, fact 5: sigma_D / D is at least sigma_L / L."""
    blocks, crops = pieces.ring()
    section = measure(blocks, crops, travel_share=0.001).sections[1]
    assert section.sigma_scale_mm == pytest.approx(0.110, rel=0.01)
    joined = pieces.placed(covariance=np.kron(np.ones((4, 4)), np.diag([0.0] * 6 + [0.001**2])))
    common = measure(blocks, crops, joined).sections[1]
    assert common.sigma_scale_mm == pytest.approx(0.110, rel=0.01)


def test_a_shift_of_the_ring_as_a_whole_costs_nothing():
    """All blocks moved alike change no diameter, however little is known of where they are."""
    together = np.kron(np.ones((4, 4)), np.diag([0.0] * 3 + [0.01**2] * 3 + [0.0]))
    section = measure(*pieces.ring(), pieces.placed(covariance=together)).sections[1]
    assert section.sigma_scale_mm < 1e-3


def test_the_lens_is_the_larger_a_part_the_less_is_known_of_it():
    """Design, fact 1: 1 % of focal length is about 0.6 mm on a circle through one arc of 120 degrees."""
    blocks, crops = pieces.ring()
    arc = measure(blocks[:1], crops[:1], focal=0.01).sections[1]
    assert 0.3 < arc.sigma_lens_mm < 1.2
    ring = measure(blocks, crops, focal=0.01).sections[1]
    assert 0.02 < ring.sigma_lens_mm < arc.sigma_lens_mm / 5
    assert measure(blocks, crops, focal=0.0).sections[1].sigma_lens_mm > 0  # the option's for a trusted lens


def test_the_parts_add_up(plain):
    for s in plain.sections:
        assert s.sigma_mm == pytest.approx(
            np.sqrt(s.sigma_image_mm**2 + s.sigma_scale_mm**2 + s.sigma_lens_mm**2)
        )


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
        found = measure(*pieces.ring(tuple(motions)), mosaic).sections
        errors += [(s.diameter_mm - 110) / s.sigma_mm for s in found]
        assert 0.1 < found[1].sigma_mm < 0.3
    assert 0.6 < np.sqrt(np.mean(np.square(errors))) < 1.5
    assert np.mean(np.abs(errors) < 2) > 0.85


def test_sections_are_cut_about_the_aligned_axis():
    """A ring that lies 5 degrees askew would show ellipses if it were cut along its own y."""
    askew = pieces.Motion((5.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    blocks, crops = pieces.ring((askew,) * 4)
    section = measure(blocks, crops).sections[1]
    assert section.max_mm - section.min_mm < 0.03
    assert section.diameter_mm == pytest.approx(110, abs=0.02)


def test_the_alignment_itself_is_taken_from_the_ring():
    blocks, crops = pieces.ring()
    mosaic = pieces.placed()
    ring = build(blocks, crops, mosaic, cell_mm=2.0, texel_mm=4.0)
    shifted = replace(ring, alignment=Alignment(rotation=np.eye(3), translation=np.array([0.002, 0, -0.001])))
    found = measure_ring(
        blocks,
        crops,
        mosaic,
        shifted,
        (0.03,) * 4,
        (LENS_KNOWN,) * 4,
        0.0,
        STATIONS,
        0.12,
        MeasureOptions(),
        scene.silent,
    )
    np.testing.assert_allclose(found.sections[1].centre_mm, [2, -1], atol=0.01)
    assert found.sections[1].diameter_mm == pytest.approx(110, abs=0.01)


def test_progress_counts_the_stations():
    events = []
    measure(*pieces.ring(), emit=events.append)
    assert [(e.stage, e.done, e.total) for e in events] == [("measure", k, 4) for k in range(3)]
