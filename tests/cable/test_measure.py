"""Diameters are those of the cable, with a standard deviation that tells how far they may be trusted."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.core.errors import StageError
from tests.cable import pieces, scene


@pytest.fixture(scope="module")
def plain():
    return pieces.measure(*pieces.ring(noise_mm=0.03))


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
    right = pieces.measure(blocks, crops, pieces.placed(pieces.ASTRAY))
    wrong = pieces.measure(blocks, crops)
    assert right.sections[1].diameter_mm == pytest.approx(110.0, abs=0.01)
    assert abs(wrong.sections[1].diameter_mm - 110.0) > 0.03


@pytest.mark.parametrize("turn_deg", [0, 30, 77])
def test_an_oval_has_its_two_axes_and_their_mean(turn_deg):
    """r = 55 + 0.3 cos 2a: axes of 110.6 and 109.4 mm."""

    def oval(azimuth, y_m):
        return scene.RADIUS_M + 0.0003 * np.cos(2 * (azimuth - np.radians(turn_deg))) + 0 * y_m

    section = pieces.measure(*pieces.ring(true_radius=oval)).sections[1]
    assert section.diameter_mm == pytest.approx(110.0, abs=0.01)
    assert section.max_mm == pytest.approx(110.6, abs=0.03)
    assert section.min_mm == pytest.approx(109.4, abs=0.03)


def test_a_rib_does_not_pull_the_base():
    """Two millimetres over 10 mm of the girth would widen the mean by some 0.1 mm."""

    def ribbed(azimuth, y_m):
        arc_mm = 1000 * scene.RADIUS_M * np.angle(np.exp(1j * (azimuth - 0.3)))
        return scene.RADIUS_M + 0.002 * np.cos(np.pi * np.clip(arc_mm / 10, -0.5, 0.5)) + 0 * y_m

    blocks, crops = pieces.ring(true_radius=ribbed, noise_mm=0.03)
    found = pieces.measure(blocks, crops, ring=pieces.join(blocks, crops))
    for section in found.sections:
        assert section.base_diameter_mm == pytest.approx(110.0, abs=0.02)
        assert 0 < section.base_sigma_mm < 0.02
    assert [f.kind for f in found.relief.features] == ["ridge"]


def test_the_base_is_as_sure_as_travel_and_lens(plain):
    blocks, crops = pieces.ring(noise_mm=0.03)
    unsure = pieces.measure(blocks, crops, travel_share=0.001).sections[1]
    assert unsure.base_sigma_mm == pytest.approx(0.11, rel=0.05)
    assert plain.sections[1].base_sigma_mm < 0.02
    assert plain.sections[1].base_diameter_mm == pytest.approx(110.0, abs=0.01)


def test_stations_along_a_taper_differ_as_the_cable_does():
    """Two millimetres of diameter a metre: 0.08 mm from A to B."""
    found = pieces.measure(*pieces.ring(true_radius=lambda a, y: 0.0549 + 0.001 * y + 0 * a), profile_mm=5.0)
    for section in found.sections:
        assert section.diameter_mm == pytest.approx(109.8 + 2 * section.position_m, abs=0.01)
    truth = 109.8 + 2 * found.profile_y_m
    np.testing.assert_allclose(found.profile_diameter_mm, truth, atol=0.02)
    np.testing.assert_allclose(found.profile_y_m, np.arange(0, 0.1201, 0.005))


def test_a_station_that_was_hardly_seen_is_named_and_not_measured():
    stations = (*pieces.STATIONS, ("beyond", 0.2), ("before", -0.1))
    found = pieces.measure(*pieces.ring(), stations=stations)
    assert [s.name for s in found.sections] == ["A", "B", "C"]
    assert found.unmeasured == ("beyond", "before")


def test_no_station_at_all_is_refused():
    with pytest.raises(StageError) as told:
        pieces.measure(*pieces.ring(), stations=(("Z", 0.5),))
    assert str(told.value) == (
        "measure: no station was seen well enough to be measured; "
        "place stations where the cameras passed, and check angle_deg of every block."
    )


def hidden(half_mm, blocks_seen=1):
    """The ring; about B, so far to either side, only the first blocks see the cable, 120 degrees each."""
    blocks, crops = pieces.ring(noise_mm=0.03)
    away_mm = 1000 * np.abs(blocks[0].surface.y_m - 0.06)
    seen = np.repeat(away_mm[:, None] > half_mm, len(blocks[0].surface.azimuth), axis=1)
    return blocks, tuple(c if n < blocks_seen else replace(c, keep=seen) for n, c in enumerate(crops))


def around_deg(section):
    """Azimuths of a section's points about its middle."""
    x, z = section.points_mm.T
    return np.degrees(np.arctan2(-z, x))


def test_where_little_is_seen_the_slice_is_longer_and_the_coverage_told_is_that_of_the_wanted_one():
    """Half of 10 mm shows the first block alone, half of 20 mm the whole girth."""
    plain, station, _ = pieces.measure(*hidden(7.0)).sections
    assert plain.coverage_deg == 360
    assert station.coverage_deg == pytest.approx(120, abs=3)
    assert np.ptp(around_deg(station)) > 340
    assert station.diameter_mm == pytest.approx(110.0, abs=0.01)


def test_a_slice_is_no_longer_than_it_must_be():
    """Two blocks show 210 degrees, which is enough; 20 mm would show all."""
    section = pieces.measure(*hidden(7.0, blocks_seen=2), wanted_coverage_deg=180.0).sections[1]
    assert section.coverage_deg == pytest.approx(210, abs=3)
    assert np.ptp(around_deg(section)) == pytest.approx(210, abs=3)


@pytest.mark.parametrize(("longest_mm", "whole"), [(39.0, False), (40.0, True)])
def test_no_slice_is_longer_than_the_longest(longest_mm, whole):
    """The others begin 12 mm away: 10 and 20 mm show one block, 40 mm all of them."""
    section = pieces.measure(*hidden(12.0), longest_slice_mm=longest_mm).sections[1]
    assert section.coverage_deg == pytest.approx(120, abs=3)
    assert (np.ptp(around_deg(section)) > 340) == whole


def test_a_station_hidden_in_its_own_slice_is_measured_by_what_is_seen_beside_it():
    blocks, crops = hidden(7.0, blocks_seen=0)
    station = pieces.measure(blocks, crops).sections[1]
    assert (station.name, station.coverage_deg) == ("B", 0.0)
    assert station.diameter_mm == pytest.approx(110.0, abs=0.01)
    assert pieces.measure(blocks, crops, longest_slice_mm=19.0).unmeasured == ("B",)


def test_too_small_an_arc_is_no_circle():
    blocks, crops = pieces.ring()
    with pytest.raises(StageError, match="no station was seen well enough"):
        pieces.measure(blocks[:1], crops[:1], least_coverage_deg=150.0)


def test_a_straight_cable_is_straight_and_a_bowed_one_is_not(plain):
    """Centres on a parabola of 0.5 mm sagitta over 0.12 m: 0.33 mm off the best line, 2.8 mm a metre."""
    assert plain.straightness_mm_per_m < 0.1
    np.testing.assert_allclose(plain.profile_centre_mm, 0, atol=0.01)

    def bowed(azimuth, y_m):
        bow = 0.0005 * (1 - ((y_m - 0.06) / 0.06) ** 2)
        return scene.RADIUS_M + bow * np.cos(azimuth)

    found = pieces.measure(*pieces.ring(true_radius=bowed), profile_mm=5.0)
    assert found.straightness_mm_per_m == pytest.approx(0.5 * 2 / 3 / 0.12, rel=0.15)
    ends = (found.profile_centre_mm[0, 0] + found.profile_centre_mm[-1, 0]) / 2
    assert found.profile_centre_mm[12, 0] - ends == pytest.approx(0.5, abs=0.03)


def test_the_parts_add_up(plain):
    for s in plain.sections:
        assert s.sigma_mm == pytest.approx(
            np.sqrt(s.sigma_image_mm**2 + s.sigma_scale_mm**2 + s.sigma_lens_mm**2)
        )


def test_progress_counts_the_profile_and_the_stations_and_never_goes_back():
    events = []
    pieces.measure(*pieces.ring(), emit=events.append)
    shares = [e.done / e.total for e in events]
    assert {e.stage for e in events} == {"measure"}
    assert shares == sorted(shares)
    assert shares[0] == 0
    assert np.diff(shares).max() < 0.25
    assert 0.8 < shares[-1] < 1
