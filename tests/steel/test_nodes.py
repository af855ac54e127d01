"""Node centres and eccentricities: right where they are, none where there is none, with honest sigmas."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.core import store
from pipeline.steel.member_records import StationShare
from pipeline.steel.nodes import Node, NodeOptions, measure_nodes
from tests.steel.members_by_hand import ball, members, rod
from tests.steel.seen_surfaces import station

DIRECTIONS = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [1, 1, 1.2], [-1, 1, 1.2], [1, -1, 1.2]])
EXACT = NodeOptions(axis_sigma_mm=0.0)


def grid(count, seed, eccentricity=(0, 0, 0), rods=7, bent=0.0, **more):
    """``count`` nodes of ``rods`` rods each, fitted with errors."""
    rng, all_rods, balls = np.random.default_rng(seed), [], []
    for k in range(count):
        place, names = np.array([10.0 * k, 0.0, 5.0]), []
        for n, direction in enumerate(DIRECTIONS[:rods]):
            along = direction / np.linalg.norm(direction)
            off = rng.normal(0, bent, 3)
            names.append(f"R{k}-{n}")
            all_rods.append(rod(names[-1], place + 0.15 * along + off, place + 2.8 * along + off, rng))
        balls.append(ball(f"N{k}", place + eccentricity, names, rng, **more))
    return members(all_rods, balls=balls)


def test_an_eccentricity_of_10_mm_is_found_within_half_a_millimetre():
    true = np.array([6.0, -7.0, np.sqrt(15.0)])
    nodes = measure_nodes(grid(50, 1, true / 1000), EXACT)
    errors = np.array([n.eccentricity_mm - true for n in nodes])
    sigmas = np.array([np.sqrt(np.diag(n.eccentricity_covariance)) for n in nodes])
    assert all(n.significant for n in nodes)
    assert np.abs([n.amount_mm - 10.0 for n in nodes]).max() < 0.5
    assert np.mean(np.abs(errors) <= 2 * sigmas) >= 0.9
    assert errors.std() / 1.5 < sigmas.mean() < 3 * errors.std()


def test_where_there_is_none_none_is_reported():
    nodes = measure_nodes(grid(400, 2), EXACT)
    assert sum(n.significant for n in nodes) <= 0.02 * len(nodes)
    # the statistic is what it claims to be: chi-square with 3 degrees of freedom
    assert 2.5 < np.mean([n.chi_square for n in nodes]) < 3.5


def test_rods_that_pass_each_other_make_no_false_eccentricity():
    nodes = measure_nodes(grid(300, 3, bent=0.001), EXACT)
    assert sum(n.significant for n in nodes) <= 0.02 * len(nodes)
    assert np.mean([n.axes_rms_mm for n in nodes]) > 0.5


def test_the_least_squares_centre_weights_each_rod_with_its_covariance():
    place = np.array([1.0, 2.0, 3.0])
    good = [rod(f"R{k}", place + 0.1 * d, place + 2 * d) for k, d in enumerate(np.eye(3))]
    bad = rod(
        "R3",
        np.add(place, [0.1, 0.105, 0.1]),
        np.add(place, [2, 2.005, 2]),
        offset_sigma=0.01,
        slope_sigma=0.01,
    )
    (node,) = measure_nodes(members([*good, bad], balls=[ball("N", place, ["R0", "R1", "R2", "R3"])]), EXACT)
    assert np.linalg.norm(node.rods_m - place) < 0.00005


def test_an_error_that_ball_and_rods_share_is_no_eccentricity():
    # all was seen from one station, whose place is off by 5 mm: everything moves together
    gains = np.zeros((1, 5, 7))
    shaky, place = station((0, 0, 0), 0.005), np.array([3.0, 0.0, 5.0])
    rods = []
    for k, direction in enumerate(DIRECTIONS):
        along = direction / np.linalg.norm(direction)
        one = rod(f"R{k}", place + 0.15 * along, place + 2.8 * along)
        own = gains.copy()
        own[0, :2, 3:6] = one.frame[:2]
        rods.append(replace(one, share=StationShare(stations=np.zeros(1, dtype=np.int64), gains=own)))
    moves = np.zeros((1, 4, 7))
    moves[0, :3, 3:6] = np.eye(3)
    share = StationShare(stations=np.zeros(1, dtype=np.int64), gains=moves)
    one = ball("N", place, [r.name for r in rods], share=share)
    (node,) = measure_nodes(members(rods, balls=[one], stations=(shaky,)), EXACT)
    assert np.sqrt(np.diag(node.rods_covariance)) == pytest.approx([0.005] * 3, rel=0.02)
    assert np.sqrt(np.diag(node.eccentricity_covariance)).max() < 0.3


def test_rods_in_one_line_leave_the_node_without_eccentricity():
    rods = [rod("R0", (0.1, 0, 0), (3, 0, 0)), rod("R1", (-0.1, 0, 0), (-3, 0, 0))]
    (node,) = measure_nodes(members(rods, balls=[ball("N", (0, 0, 0), ["R0", "R1"])]), EXACT)
    assert np.isnan(node.eccentricity_mm).all()
    assert not node.significant


def test_a_node_is_a_product_that_can_be_stored(tmp_path):
    (node,) = measure_nodes(grid(1, 4), NodeOptions())
    store.save(node, tmp_path / "node.npz", tmp_path)
    assert store.load(Node, tmp_path / "node.npz", tmp_path).perpendicular_rule is node.perpendicular_rule
