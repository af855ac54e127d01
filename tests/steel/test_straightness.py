"""How straight rods are is found from how their axes pass each other, whatever was assumed."""

import numpy as np
import pytest

from pipeline.steel.nodes import NodeOptions, measure_nodes
from pipeline.steel.straightness import axis_sigma
from tests.steel.members_by_hand import ball, members, rod

DIRECTIONS = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [1, 1, 1.2], [-1, 1, 1.2], [1, -1, 1.2]])


def structure(seed, nodes=60, bent_m=0.0, stray=0.0):
    """Nodes of seven rods, each set off across by ``bent_m``; a part ``stray`` of them by 20 mm."""
    rng, rods, balls = np.random.default_rng(seed), [], []
    for k in range(nodes):
        place, names = np.array([10.0 * k, 0.0, 5.0]), []
        for n, direction in enumerate(DIRECTIONS):
            along = direction / np.linalg.norm(direction)
            off = rng.normal(0, 0.02 if rng.random() < stray else bent_m, 3)
            names.append(f"R{k}-{n}")
            rods.append(rod(names[-1], place + 0.15 * along + off, place + 2.8 * along + off, rng))
        balls.append(ball(f"N{k}", place, names, rng))
    return members(rods, balls=balls)


def found_mm(one, assumed_mm=0.1):
    rods = {r.name: r for r in one.rods}
    nodes = [([rods[name] for name in b.rods], b.centre) for b in one.balls]
    return 1000 * axis_sigma(nodes, one, assumed_mm / 1000)


@pytest.mark.parametrize("assumed_mm", [0.03, 0.1, 0.5])
@pytest.mark.parametrize("bent_mm", [0.1, 0.4, 2.0])
def test_bent_rods_tell_how_bent_they_are(bent_mm, assumed_mm):
    assert found_mm(structure(1, bent_m=bent_mm / 1000), assumed_mm) == pytest.approx(bent_mm, rel=0.12)


def test_straight_rods_are_found_straighter_than_assumed():
    # what is known of them (0.05 mm and 0.05 mm/m) limits what can be told
    assert 0.005 < found_mm(structure(2)) < 0.045


def test_a_few_rods_that_belong_elsewhere_bend_none_of_the_others():
    assert found_mm(structure(3, bent_m=0.0003, stray=0.03)) == pytest.approx(0.3, rel=0.5)


def test_two_nodes_are_not_believed_to_be_perfect():
    many, few = found_mm(structure(4)), found_mm(structure(4, nodes=2))
    assert many < few < 0.1


def test_without_any_node_it_is_as_assumed():
    assert found_mm(members()) == pytest.approx(0.1, rel=1e-2)
    assert found_mm(structure(5), assumed_mm=0.0) == 0.0


@pytest.mark.parametrize("bent_mm", [0.0, 0.3])
def test_the_nodes_places_are_as_uncertain_as_they_are_wrong(bent_mm):
    nodes = measure_nodes(structure(6, nodes=200, bent_m=bent_mm / 1000), NodeOptions())
    errors = np.array([n.rods_m - [10.0 * k, 0.0, 5.0] for k, n in enumerate(nodes)])
    sigmas = np.array([np.sqrt(np.diag(n.rods_covariance)) for n in nodes])
    assert 0.85 < np.sqrt(np.mean(sigmas**2) / np.mean(errors**2)) < 1.4
    assert 0.93 < np.mean(np.abs(errors) < 2 * sigmas) < 0.99
