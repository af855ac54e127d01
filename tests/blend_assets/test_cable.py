"""The cable's node tree against synth's surface: two writings of one definition, held against each other."""

import math

import bpy
import numpy as np
import pytest

from blend_assets.cable import UV, cable_object, cable_tree
from blend_assets.cable_inputs import CABLE
from blend_assets.previews import set_input
from synth.spec import Cable, Defect, DefectKind, Fillet, Station
from synth.surface import axis_m, radius_m

TOLERANCE_M = 1e-5
TRAVEL_M, MARGIN_M = 0.3, 0.1

STATIONS = {
    ("Stations", "Stations"): 3,
    ("Stations", "A position"): 0.05,
    ("Stations", "A diameter (mm)"): 112.0,
    ("Stations", "B position"): 0.11,
    ("Stations", "B diameter (mm)"): 109.5,
    ("Stations", "C position"): 0.25,
    ("Stations", "C diameter (mm)"): 111.0,
}
SPEC_STATIONS = (
    Station(name="A", position_m=0.05, diameter_mm=112.0),
    Station(name="B", position_m=0.11, diameter_mm=109.5),
    Station(name="C", position_m=0.25, diameter_mm=111.0),
)

CASES = {
    "plain": ({("", "Diameter (mm)"): 70.0}, Cable(diameter_mm=70.0)),
    "profile and ovality": (
        {**STATIONS, ("", "Ovality (mm)"): 0.8, ("", "Ovality angle"): math.radians(25)},
        Cable(station=SPEC_STATIONS, ovality_mm=0.8, ovality_angle_deg=25),
    ),
    "ribs on a profile": (
        {**STATIONS, ("Fillet", "Fillet"): True, ("Fillet", "Height (mm)"): 2.5},
        Cable(station=SPEC_STATIONS, fillet=Fillet(height_mm=2.5)),
    ),
    "steep ribs": (
        {
            ("Fillet", "Fillet"): True,
            ("Fillet", "Width (mm)"): 12.0,
            ("Fillet", "Pitch"): 0.35,
            ("Fillet", "Angle"): math.radians(-70),
            ("", "Diameter (mm)"): 160.0,
            ("Mesh", "Columns"): 720,
            ("Mesh", "Row spacing (mm)"): 0.75,
        },
        Cable(diameter_mm=160.0, fillet=Fillet(width_mm=12.0, pitch_m=0.35, angle_deg=-70)),
    ),
    "defects": (
        {
            ("Defect 1", "Defect 1"): True,
            ("Defect 1", "Height (mm)"): 1.5,
            ("Defect 1", "Position"): 0.1,
            # across azimuth 0, where the mesh is closed
            ("Defect 1", "Azimuth"): math.radians(3),
            ("Defect 2", "Defect 2"): True,
            ("Defect 2", "Height (mm)"): -1.0,
            ("Defect 2", "Position"): 0.2,
            ("Defect 2", "Azimuth"): math.radians(200),
            ("Defect 2", "Width (mm)"): 60.0,
            ("Mesh", "Row spacing (mm)"): 1.0,
        },
        Cable(
            defect=(
                Defect(kind=DefectKind.BULGE, height_mm=1.5, position_m=0.1, azimuth_deg=3),
                Defect(kind=DefectKind.DENT, height_mm=1.0, position_m=0.2, azimuth_deg=200, width_mm=60.0),
            )
        ),
    ),
    "bowed": (
        {("Bow", "Bow (mm)"): 3.0, ("Bow", "Bow azimuth"): math.radians(60)},
        Cable(bow_mm=3.0, bow_azimuth_deg=60),
    ),
}


@pytest.fixture(scope="module")
def asset():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    made = cable_object(cable_tree(), bpy.data.materials.new("Sheath"))
    bpy.context.scene.collection.objects.link(made)
    return made


@pytest.fixture
def cable(asset):
    for panel in CABLE:
        if panel.switch:
            set_input(asset, panel.name, panel.name, False)
        for row in panel.inputs:
            set_input(asset, panel.name, row.name, row.default)
    set_input(asset, "", "Travel", TRAVEL_M)
    set_input(asset, "", "Margin", MARGIN_M)
    return asset


def evaluated(cable):
    return cable.evaluated_get(bpy.context.evaluated_depsgraph_get()).data


def points(mesh):
    """(n, 3) vertices."""
    found = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", found)
    return found.reshape(-1, 3).astype(float)


def corners(mesh):
    """(faces, 4) vertex numbers."""
    found = np.empty(len(mesh.loops), np.int32)
    mesh.loops.foreach_get("vertex_index", found)
    return found.reshape(-1, 4)


def off_surface_m(spec, at):
    """How far outside of synth's surface points lie, along the radius."""
    axis_x, axis_z = axis_m(spec, TRAVEL_M, at[:, 1])
    x, z = at[:, 0] - axis_x, at[:, 2] - axis_z
    return np.hypot(x, z) - radius_m(spec, np.arctan2(-z, x), at[:, 1])


@pytest.mark.parametrize("case", CASES)
def test_the_mesh_lies_on_synths_surface(cable, case):
    inputs, spec = CASES[case]
    for (panel, name), value in inputs.items():
        set_input(cable, panel, name, value)
    mesh = evaluated(cable)
    at = points(mesh)
    middles = at[corners(mesh)].mean(axis=1)
    assert np.abs(off_surface_m(spec, at)).max() < 1e-6  # single precision
    assert np.abs(off_surface_m(spec, middles)).max() < TOLERANCE_M
    assert at[:, 1].min() == pytest.approx(-MARGIN_M, abs=1e-6)
    assert at[:, 1].max() == pytest.approx(TRAVEL_M + MARGIN_M, abs=1e-6)


def test_another_surface_would_be_noticed(cable):
    set_input(cable, "", "Diameter (mm)", 110.04)
    assert off_surface_m(Cable(), points(evaluated(cable))).mean() == pytest.approx(2e-5, rel=0.05)


def test_the_tube_is_closed_around_and_open_at_its_ends(cable):
    quads = corners(evaluated(cable))
    edges = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1)
    _, faces = np.unique(edges, axis=0, return_counts=True)
    assert np.count_nonzero(faces == 1) == 2 * 360
    assert faces.max() == 2


def test_faces_look_outward(cable):
    mesh = evaluated(cable)
    a, b, _, d = np.moveaxis(points(mesh)[corners(mesh)], 1, 0)
    outward = a * [1, 0, 1]
    assert (np.cross(b - a, d - a) * outward).sum(axis=1).min() > 0


@pytest.mark.parametrize("ribs", [False, True])
def test_the_uv_map_is_girth_and_length(cable, ribs):
    set_input(cable, "Fillet", "Fillet", ribs)
    mesh = evaluated(cable)
    uv = np.empty(2 * len(mesh.loops), np.float32)
    mesh.uv_layers[UV].uv.foreach_get("vector", uv)
    uv, at = uv.reshape(-1, 2), points(mesh)[corners(mesh).ravel()]
    assert np.allclose(uv[:, 1], (at[:, 1] + MARGIN_M) / (TRAVEL_M + 2 * MARGIN_M), atol=1e-5)
    turns = np.arctan2(-at[:, 2], at[:, 0]) / math.tau
    assert np.abs((uv[:, 0] - turns + 0.5) % 1.0 - 0.5).max() < 1e-4
    assert np.ptp(uv.reshape(-1, 4, 2)[..., 0], axis=1).max() < 0.02  # no face spans the girth


def test_a_material_dropped_on_the_cable_is_worn(cable):
    cable.data.materials[0] = bpy.data.materials.new("Another")
    mesh = evaluated(cable)
    assert mesh.materials[0].name == "Another"
    assert {face.material_index for face in mesh.polygons[:100]} == {0}
