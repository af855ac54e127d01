"""Sag of the bottom chord against the plane or line of its supports."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.core.errors import StageError
from pipeline.steel.columns import ColumnOptions, measure_columns
from pipeline.steel.deflection import DeflectionOptions, measure_deflection
from pipeline.steel.member_records import Joint
from pipeline.steel.nodes import NodeOptions, measure_nodes
from tests.steel.members_by_hand import ball, members, rod

SPAN, BAYS = 12.0, 4


def hall(sag_mm=20.0, rng=None, slope=0.0, supports=((0, 0), (4, 0), (0, 4), (4, 4)), sigma=0.0002):
    """A grid whose middle hangs by ``sag_mm``; top chord 1.5 m above; ``slope``: the roof's fall along x."""
    step, balls, columns = SPAN / BAYS, [], []
    for i in range(BAYS + 1):
        for j in range(BAYS + 1):
            sag = sag_mm / 1000 * np.sin(np.pi * i / BAYS) * np.sin(np.pi * j / BAYS)
            place = np.array([i * step, j * step, 6.0 + slope * i * step - sag])
            name = f"B{i}{j}"
            below = ""
            if (i, j) in supports:
                below = f"C{i}{j}"
                columns.append(rod(below, [*place[:2], 0.0], place - [0, 0, 0.1], radius=0.15))
            balls.append(ball(name, place, (), rng, sigma=sigma, column=below))
            if i < BAYS and j < BAYS:
                top = np.array([(i + 0.5) * step, (j + 0.5) * step, 7.5 + slope * i * step])
                balls.append(ball(f"T{i}{j}", top, (), rng, sigma=sigma))
    return members(columns=columns, balls=balls)


def measured(one, span=SPAN, **more):
    nodes = measure_nodes(one, NodeOptions())
    return measure_deflection(
        nodes, measure_columns(one, [], ColumnOptions()), one, span, DeflectionOptions(**more)
    )


@pytest.mark.parametrize("slope", [0.0, 0.03])
def test_the_middle_hangs_by_its_sag_whatever_the_roofs_fall(slope):
    found = measured(hall(20.0, slope=slope))
    assert found.worst == "B22"
    assert found.worst_mm == pytest.approx(20.0, abs=1e-6)
    assert found.ratio == pytest.approx(600.0)
    assert found.limit_mm == pytest.approx(48.0)
    assert not found.over
    assert {s.node for s in found.nodes} == {f"B{i}{j}" for i in range(5) for j in range(5)}
    assert found.supports == ("B00", "B04", "B40", "B44")


def test_a_deflection_beyond_the_limit_is_told():
    found = measured(hall(60.0))
    assert found.over
    assert found.over_probability > 0.99


def test_two_supports_give_a_line():
    found = measured(hall(20.0, slope=0.02, supports=((0, 2), (4, 2))))
    sags = {s.node: s.sag_mm for s in found.nodes}
    assert sags["B22"] == pytest.approx(20.0, abs=1e-6)
    assert sags["B02"] == pytest.approx(0.0, abs=1e-6)


def test_sigma_is_honest_supports_included():
    rng, normalised, supports = np.random.default_rng(4), [], []
    for _ in range(60):
        found = measured(hall(20.0, rng))
        truth = {
            f"B{i}{j}": 20.0 * np.sin(np.pi * i / 4) * np.sin(np.pi * j / 4)
            for i in range(5)
            for j in range(5)
        }
        for s in found.nodes:
            (supports if s.support else normalised).append((s.sag_mm - truth[s.node]) / s.sigma_mm)
    assert 0.9 < np.std(normalised) < 1.1
    assert 0.85 < np.std(supports) < 1.15


def test_without_a_given_span_it_is_the_supports():
    assert measured(hall(20.0), span=None).span_m == pytest.approx(12.0)


def test_one_support_is_not_enough():
    with pytest.raises(StageError, match="1 nodes stand on columns"):
        measured(hall(20.0, supports=((0, 0),)))


def test_supports_whose_balls_hide_on_their_columns_still_count():
    one = hall(20.0)
    hidden = [b for b in one.balls if b.column]
    rods, joints = [], []
    for k, b in enumerate(hidden):
        inward = np.sign(np.array([SPAN / 2, SPAN / 2]) - b.centre[:2])
        for n, direction in enumerate(([inward[0], 0, 0], [0, inward[1], 0], [*inward, 1.0])):
            along = np.array(direction) / np.linalg.norm(direction)
            rods.append(rod(f"R{k}{n}", b.centre + 0.1 * along, b.centre + 2.0 * along))
        names = tuple(f"R{k}{n}" for n in range(3))
        joints.append(Joint(name=f"J{k}", place=b.centre + 0.02, rods=names, column=b.column))
    seen = replace(
        one, rods=tuple(rods), joints=tuple(joints), balls=tuple(b for b in one.balls if not b.column)
    )
    found = measured(seen)
    assert found.supports == ("J0", "J1", "J2", "J3")
    assert found.worst_mm == pytest.approx(20.0, abs=1e-6)
    assert all(np.isnan(n.ball_m).all() for n in measure_nodes(seen, NodeOptions()) if n.name[0] == "J")
