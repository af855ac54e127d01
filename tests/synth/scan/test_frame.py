"""The space frame as built: counts, ends of rods, eccentricities, sag, tilts."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.core.errors import StageError
from synth.scan.frame import build_frame
from synth.scan.spec import Eccentric, ScanSpec, Structure

SPEC = ScanSpec(
    name="frame",
    structure=Structure(
        bays=(3, 2),
        sag_mm=20.0,
        tilt_mm=(10.0, 50.0),
        eccentric=(Eccentric(node="B2-2", offset_mm=(8.0, 6.0, 0.0)),),
        eccentric_share=0.25,
    ),
)


def test_three_by_two_pyramids_have_12_and_6_nodes_and_48_rods():
    frame = build_frame(SPEC)
    names = [node.name for node in frame.nodes]
    assert (len([n for n in names if n[0] == "B"]), len([n for n in names if n[0] == "T"])) == (12, 6)
    # bottom: 3 * 3 + 4 * 2, top: 2 * 2 + 3 * 1, diagonals: 6 * 4
    assert len(frame.rods) == 17 + 7 + 24
    assert len({rod.name for rod in frame.rods}) == 48


def test_rods_end_on_the_balls_and_their_axes_meet_where_the_node_says():
    frame = build_frame(SPEC)
    nodes = {node.name: node for node in frame.nodes}
    for rod in frame.rods:
        axis = (rod.end - rod.start) / np.linalg.norm(rod.end - rod.start)
        for end, name in zip((rod.start, rod.end), rod.nodes, strict=True):
            node = nodes[name]
            assert np.linalg.norm(end - node.ball) == pytest.approx(0.1, abs=1e-12)
            assert np.linalg.norm(np.cross(node.rods - rod.start, axis)) < 1e-12


def test_the_stated_ball_and_a_quarter_of_the_others_are_off_by_10_mm():
    frame = build_frame(SPEC)
    off_mm = {node.name: 1000.0 * (node.ball - node.rods) for node in frame.nodes}
    assert off_mm["B2-2"] == pytest.approx([8.0, 6.0, 0.0])
    sizes = np.array([np.linalg.norm(value) for value in off_mm.values()])
    assert np.count_nonzero(sizes > 0.0) == 1 + round(0.25 * 17)
    assert sizes[sizes > 0.0] == pytest.approx(np.full(5, 10.0))


def test_the_sag_is_a_half_sine_both_ways():
    frame = build_frame(SPEC)
    nodes = {node.name: node for node in frame.nodes}
    middle = nodes["T2-1"]  # x at half, y at a quarter
    assert 1000.0 * middle.sag_m == pytest.approx(20.0 * np.sin(np.pi / 4.0))
    assert middle.rods[2] == pytest.approx(5.0 + 2.1 - middle.sag_m)
    assert [nodes[name].sag_m for name in ("B1-1", "B2-1", "B4-2")] == [0.0, 0.0, 0.0]


def test_columns_stand_under_the_corners_and_lean_as_drawn():
    columns = build_frame(SPEC).columns
    assert [column.name for column in columns] == ["1-A", "4-A", "4-C", "1-C"]
    for column in columns:
        lean_mm = 1000.0 * np.linalg.norm((column.top - column.bottom)[:2])
        assert 10.0 <= lean_mm <= 50.0
        assert column.bottom[2] == pytest.approx(0.25)
        axis = (column.head - column.foot) / np.linalg.norm(column.head - column.foot)
        assert np.linalg.norm(np.cross(column.top - column.foot, axis)) < 1e-12


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_as_many_columns_as_asked_are_over_the_limit(seed):
    structure = Structure(bays=(12, 9), column_step=2, tilt_mm=(10.0, 70.0), tilt_over=16, height_m=14.5)
    columns = build_frame(ScanSpec(name="x", seed=seed, structure=structure)).columns
    lean_mm = np.array([1000.0 * np.linalg.norm((c.top - c.bottom)[:2]) for c in columns])
    assert len(columns) == 21
    assert np.count_nonzero(lean_mm > 37.0) == 16
    assert np.count_nonzero(lean_mm < 33.0) == 5
    assert 10.0 <= lean_mm.min() < lean_mm.max() <= 70.0


def test_a_node_or_column_that_is_not_there_is_refused():
    wrong = replace(SPEC.structure, eccentric=(Eccentric(node="T4-1", offset_mm=(1.0, 0.0, 0.0)),))
    with pytest.raises(StageError, match=r"structure\.eccentric names T4-1"):
        build_frame(replace(SPEC, structure=wrong))
    with pytest.raises(StageError, match=r"structure\.column_at names \(5, 1\)"):
        build_frame(replace(SPEC, structure=replace(SPEC.structure, column_at=((5, 1),))))
