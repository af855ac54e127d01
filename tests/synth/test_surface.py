"""The surface obeys its spec: plateaus at stations, smooth between, exact ovality, fillets in their place."""

from dataclasses import replace

import numpy as np
import pytest

from synth.mesh import cable_mesh
from synth.spec import Cable, Defect, DefectKind, Fillet, Robot, Station
from synth.surface import axis_m, fillet_height_m, mean_diameter_mm, mean_radius_m, radius_m

STEPPED = Cable(
    station=(
        Station(name="A", position_m=0.1, diameter_mm=111.4),
        Station(name="B", position_m=0.2, diameter_mm=110.8),
    )
)
STEEP = Cable(
    station=(
        Station(name="A", position_m=0.01, diameter_mm=110.0),
        Station(name="B", position_m=0.02, diameter_mm=114.0),
    )
)
DENTED = Cable(
    diameter_mm=110.0,
    ovality_mm=0.8,
    defect=(
        Defect(kind=DefectKind.BULGE, height_mm=1.5, position_m=0.010, azimuth_deg=350.0, length_mm=16.0),
        Defect(kind=DefectKind.DENT, height_mm=1.0, position_m=0.022, azimuth_deg=170.0, width_mm=30.0),
    ),
)


def test_the_profile_meets_its_stations_and_stays_constant_beyond_them():
    y = np.array([-0.3, 0.1, 0.15, 0.2, 0.9])
    assert mean_radius_m(STEPPED, y) * 2000.0 == pytest.approx([111.4, 111.4, 111.1, 110.8, 110.8], abs=1e-9)


def test_the_profile_has_no_jump_in_slope_or_curvature_at_a_station():
    step = 1e-4
    y = np.array([0.1, 0.2])
    left, here, right = (mean_radius_m(STEPPED, y + d) for d in (-step, 0.0, step))
    assert (np.abs(right - left) / (2 * step)).max() < 1e-6
    assert (
        np.abs(right - 2 * here + left) / step**2
    ).max() < 0.02  # 1/m; between the stations it reaches 0.17


def test_ovality_is_the_largest_minus_the_smallest_diameter_and_leaves_the_mean():
    cable = Cable(diameter_mm=110.0, ovality_mm=0.8, ovality_angle_deg=30.0)
    azimuth = np.radians(np.arange(0, 360, 0.5))
    diameters_mm = 1000.0 * (radius_m(cable, azimuth, 0.0) + radius_m(cable, azimuth + np.pi, 0.0))
    assert diameters_mm.max() - diameters_mm.min() == pytest.approx(0.8, abs=1e-6)
    assert np.degrees(azimuth[diameters_mm.argmax()]) % 180.0 == pytest.approx(30.0, abs=0.5)
    assert mean_diameter_mm(cable, 0.2) == pytest.approx(110.0, abs=1e-9)


def test_two_fillets_climb_half_a_turn_apart():
    fillet = Fillet(height_mm=2.0, width_mm=8.0, pitch_m=0.6, angle_deg=30.0)
    cable = Cable(diameter_mm=110.0, fillet=fillet)

    def height_mm(azimuth_deg, y_m):
        return 1000.0 * float(fillet_height_m(cable, np.radians(azimuth_deg), np.array(y_m)))

    assert height_mm(30.0, 0.0) == pytest.approx(2.0)
    assert height_mm(210.0, 0.0) == pytest.approx(2.0)
    assert height_mm(120.0, 0.15) == pytest.approx(2.0)  # a quarter pitch on, a quarter turn on
    assert height_mm(120.0, 0.0) == pytest.approx(0.0, abs=1e-12)
    assert height_mm(30.0 + np.degrees(2.0 / 55.0), 0.0) == pytest.approx(1.0)  # a quarter width aside


def test_fillets_add_their_cross_section_to_the_mean_diameter():
    cable = Cable(diameter_mm=110.0, fillet=Fillet(height_mm=2.0, width_mm=8.0))
    # two ribs of mean height h / 2 over the width w each: 2 * (2 w / girth) * h / 2
    assert mean_diameter_mm(cable, 0.1) == pytest.approx(110.0 + 2.0 * 2.0 * 8.0 / (np.pi * 110.0), abs=1e-3)


@pytest.mark.parametrize(
    "cable",
    [STEPPED, STEEP, Cable(ovality_mm=2.0), Cable(fillet=Fillet(height_mm=3.0, width_mm=5.0)), DENTED],
    ids=["stepped", "steep", "oval", "fillet", "dented"],
)
def test_the_mesh_stays_within_two_micrometres_of_the_surface(cable):
    mesh = cable_mesh(replace(cable, margin_m=0.01), Robot(travel_m=0.03))
    corners = mesh.vertices[mesh.quads]
    inner = [corners.mean(axis=1), corners[:, [0, 2]].mean(axis=1), corners[:, [1, 3]].mean(axis=1)]
    inner += [corners[:, [i, (i + 1) % 4]].mean(axis=1) for i in range(4)]
    points = np.concatenate(inner)
    true_m = radius_m(cable, np.arctan2(-points[:, 2], points[:, 0]), points[:, 1])
    error_m = np.abs(np.hypot(points[:, 0], points[:, 2]) - true_m)
    assert 1e-8 < error_m.max() < 2.0e-6


def test_the_mesh_faces_outward_and_its_texture_runs_with_azimuth_and_position():
    mesh = cable_mesh(Cable(margin_m=0.01, fillet=Fillet()), Robot(travel_m=0.02))
    a, b, c, d = np.swapaxes(mesh.vertices[mesh.quads], 0, 1)
    normal, centre = np.cross(c - a, d - b), (a + b + c + d) / 4.0
    assert np.all(normal[:, 0] * centre[:, 0] + normal[:, 2] * centre[:, 2] > 0.0)
    azimuth = np.arctan2(-centre[:, 2], centre[:, 0])
    turns = mesh.uv.mean(axis=1)[:, 0] - azimuth / (2.0 * np.pi)
    assert np.abs(turns - np.rint(turns)).max() < 1e-4
    assert mesh.uv.mean(axis=1)[:, 1] == pytest.approx((centre[:, 1] + 0.01) / 0.04, abs=1e-6)


def test_a_bulge_rises_and_a_dent_sinks_by_its_height_and_ends_at_its_ellipse():
    cable = replace(DENTED, ovality_mm=0.0)

    def height_mm(azimuth_deg, y_m):
        return float(1000.0 * radius_m(cable, np.radians(azimuth_deg), y_m)) - 55.0

    assert height_mm(350.0, 0.010) == pytest.approx(1.5)
    assert height_mm(-10.0, 0.014) == pytest.approx(1.5 * 0.75**3)  # half-way to the end: s^2 = 1 / 4
    beside_deg = np.degrees(10.0 / 55.0)  # 10 mm of arc: half-way to the side
    assert height_mm(350.0 + beside_deg, 0.010) == pytest.approx(1.5 * 0.75**3)
    assert height_mm(350.0, 0.0181) == height_mm(350.0 - 2.01 * beside_deg, 0.010) == 0.0
    assert height_mm(170.0, 0.022) == pytest.approx(-1.0)


def test_a_defect_joins_the_sheath_without_a_kink_in_slope_or_curvature():
    step = 1e-5
    edge = 0.010 + 0.008
    left, here, right = (
        radius_m(replace(DENTED, ovality_mm=0.0), np.radians(350.0), edge + d) for d in (-step, 0.0, step)
    )
    assert abs(right - left) / (2 * step) < 1e-5
    assert abs(right - 2 * here + left) / step**2 < 1.5  # 1/m; at the crest it is 6 h / (l / 2)^2 = 141


def test_a_defect_adds_its_volume_to_the_mean_diameter():
    # across the middle of the bulge: twice h, times the mean 16 / 35 of (1 - s^2)^3, over the girth
    expected_mm = 110.0 + 2.0 * 1.5 * 16.0 / 35.0 * 40.0 / (np.pi * 110.0)
    assert mean_diameter_mm(replace(DENTED, defect=DENTED.defect[:1]), 0.010) == pytest.approx(
        expected_mm, abs=1e-4
    )


def test_the_axis_bows_as_a_parabola_that_meets_the_straight_one_at_both_ends_of_the_travel():
    cable = Cable(bow_mm=3.0, bow_azimuth_deg=30.0)
    x, z = axis_m(cable, 0.4, np.array([0.0, 0.1, 0.2, 0.4, 0.6]))
    rise_mm = np.array([0.0, 2.25, 3.0, 0.0, -9.0])
    assert 1000.0 * x == pytest.approx(rise_mm * np.cos(np.radians(30.0)))
    assert 1000.0 * z == pytest.approx(-rise_mm * 0.5)


def test_the_mesh_follows_the_bowed_axis():
    cable = Cable(diameter_mm=110.0, margin_m=0.01, bow_mm=3.0, bow_azimuth_deg=90.0)
    mesh = cable_mesh(cable, Robot(travel_m=0.04))
    middle = mesh.vertices[np.abs(mesh.vertices[:, 1] - 0.02) < 1e-9]
    assert len(middle) > 100
    assert np.hypot(middle[:, 0], middle[:, 2] + 0.003) == pytest.approx(np.full(len(middle), 0.055))
