"""What fits have in common counts once: stations' errors, and the plumb line that these stations tell."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.steel.columns import ColumnOptions, measure_columns
from pipeline.steel.deflection import DeflectionOptions, measure_deflection
from pipeline.steel.joint import Part, joint_covariance
from pipeline.steel.member_records import StationShare
from pipeline.steel.nodes import NodeOptions, measure_nodes
from pipeline.steel.records import Plumb, StationPose
from tests.steel.members_by_hand import ball, members, rod
from tests.steel.seen_surfaces import station

ARCSEC = np.pi / 180 / 3600
LEVEL, HEIGHT, COUNT = 3 * ARCSEC, 14.0, 4


def levelled():
    """Stations that know of each other only that all of them are levelled, the base first, and their plumb.

    A station's z is off plumb by its own error e_k, a rotation about x and y.  Taken as parallel to the base,
    its rotation is wrong by e_k - e_0, and their common plumb line by the mean of e_k less e_0.
    """
    turns = np.zeros((COUNT, 6, 2 * COUNT))
    plumb = np.zeros((2, 2 * COUNT))
    for axis in range(2):
        for k in range(COUNT):
            turns[k, axis, 2 * k + axis] += 1
            turns[k, axis, axis] -= 1
        plumb[axis] = turns[:, axis].mean(axis=0)
    # a rotation about y leans z towards x, one about x towards -y
    slopes = np.stack([plumb[1], -plumb[0]])
    poses = tuple(
        StationPose(
            name=f"S{k}",
            rotation=np.eye(3),
            translation=np.zeros(3),
            covariance=LEVEL**2 * turns[k] @ turns[k].T,
            among=LEVEL**2 * np.einsum("ij,kmj->kim", turns[k], turns),
        )
        for k in range(COUNT)
    )
    return poses, Plumb(
        direction=np.array([0.0, 0.0, 1.0]),
        across=np.eye(3)[:2],
        covariance=LEVEL**2 * slopes @ slopes.T,
        stations=tuple(pose.name for pose in poses),
        with_stations=LEVEL**2 * np.einsum("kij,mj->kim", turns, slopes),
    )


def leaning_with(number):
    """A column that one station saw: its slopes follow that station's rotation."""
    upright = rod("C01", (0, 0, 0), (0, 0, HEIGHT), radius=0.15)
    gains = np.zeros((1, 5, 7))
    gains[0, 2, :3] = np.cross([0, 0, 1], upright.frame[0])
    gains[0, 3, :3] = np.cross([0, 0, 1], upright.frame[1])
    share = StationShare(stations=np.array([number]), gains=gains)
    return replace(upright, share=share, noise_covariance=np.zeros((5, 5)))


def sigma_mm(number, plumb, poses):
    one = members(columns=[leaning_with(number)], stations=poses)
    (found,) = measure_columns(one, [], ColumnOptions(), plumb)
    return np.sqrt(np.diag(found.tilt_covariance))


def test_a_lean_is_as_good_as_its_stations_level_less_what_all_agree_on():
    poses, plumb = levelled()
    one_level_mm = 1000 * HEIGHT * LEVEL
    for number in (0, 2):
        # against the mean of four compensators, its own among them: 1 - 1/4 of the variance
        assert sigma_mm(number, plumb, poses) == pytest.approx([one_level_mm * np.sqrt(0.75)] * 2, rel=1e-6)
    # against the base's z: exact as seen by the base itself, two compensators' errors as seen by another
    assert sigma_mm(0, None, poses) == pytest.approx([0, 0], abs=1e-9)
    assert sigma_mm(2, None, poses) == pytest.approx([one_level_mm * np.sqrt(2)] * 2, rel=1e-6)


def test_columns_are_judged_against_the_plumb_line_not_the_sites_z():
    _, plumb = levelled()
    off = np.array([0.001, -0.002, 1.0])
    leaning = replace(plumb, direction=off / np.linalg.norm(off))
    top = np.array([0.020, 0.010, HEIGHT])
    one = members(columns=[rod("C01", (0, 0, 0), top, radius=0.15)], stations=levelled()[0])
    (found,) = measure_columns(one, [], ColumnOptions(), leaning)
    assert found.tilt_mm == pytest.approx([20.0 - 14.0, 10.0 + 28.0], abs=1e-6)
    assert found.over
    (plain,) = measure_columns(one, [], ColumnOptions())
    assert plain.tilt_mm == pytest.approx([20.0, 10.0], abs=1e-6)


def followed(names, places, moved):
    """Balls that all follow the first station's translation."""
    gains = np.zeros((1, 4, 7))
    gains[0, :3, 3:6] = np.eye(3)
    share = StationShare(stations=np.zeros(1, dtype=np.int64), gains=gains)
    columns = [
        rod(f"C{n}", [*p[:2], 0.0], np.subtract(p, [0, 0, 0.1])) for n, p in zip(names, places, strict=True)
    ]
    balls = [
        ball(n, p, (), sigma=1e-6, share=share, column=f"C{n}" if n != moved else "")
        for n, p in zip(names, places, strict=True)
    ]
    return columns[:-1], balls


def test_an_error_that_the_whole_grid_shares_is_no_deflection():
    places = [np.array(p, dtype=float) for p in ((0, 0, 6), (8, 0, 6), (0, 8, 6), (8, 8, 6), (4, 4, 5.98))]
    columns, balls = followed("ABCDE", places, "E")
    one = members(columns=columns, balls=balls, stations=(station((0, 0, 1), sigma_m=0.003),))
    nodes = measure_nodes(one, NodeOptions())
    found = measure_deflection(
        nodes, measure_columns(one, [], ColumnOptions()), one, 8.0, DeflectionOptions()
    )
    assert found.worst_mm == pytest.approx(20.0, abs=1e-6)
    assert found.worst_sigma_mm < 0.01


def test_beside_a_line_of_supports_the_plumb_lines_sigma_is_in_the_sag():
    poses, plumb = levelled()
    places = [np.array(p, dtype=float) for p in ((0, 0, 6), (8, 0, 6), (4, 5, 6))]
    columns, balls = followed("ABE", places, "E")
    one = members(columns=columns, balls=balls, stations=poses)
    nodes, judged = measure_nodes(one, NodeOptions()), measure_columns(one, [], ColumnOptions())
    for up, least, most in ((None, 0.0, 0.05), (plumb, 0.9, 1.1)):
        found = measure_deflection(nodes, judged, one, 8.0, DeflectionOptions(), up)
        beside = next(s for s in found.nodes if s.node == "E")
        # 5 m beside the line, plumb by the base against the mean of four: sqrt(3/4) sigma
        per_plumb_mm = 1000 * 5 * LEVEL * np.sqrt(0.75)
        assert least <= beside.sigma_mm / per_plumb_mm <= most


def test_two_fits_of_one_station_do_not_average_its_error():
    share = StationShare(stations=np.zeros(1, dtype=np.int64), gains=np.eye(3, 7, k=3)[None])
    parts = [Part(gain=0.5 * np.eye(3), noise=4e-6 * np.eye(3), share=share)] * 2
    shaky = members(stations=(station((0, 0, 0), sigma_m=0.003),))
    assert joint_covariance(parts, shaky) == pytest.approx((2e-6 + 9e-6) * np.eye(3), abs=1e-15)
