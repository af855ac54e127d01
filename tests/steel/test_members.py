"""Members of a scanned frame: all of them, nothing else, in the right place, whatever the tiles' borders."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.core import store
from pipeline.core.errors import StageError
from pipeline.core.events import silent
from pipeline.steel.columns import ColumnOptions, measure_columns
from pipeline.steel.member_records import MemberOptions, Members, NominalSizes
from pipeline.steel.members import find_members
from pipeline.steel.nodes import NodeOptions, measure_nodes
from pipeline.steel.tile_records import TileOptions
from pipeline.steel.tiles import build_tiles
from tests.steel.scanned_frame import Frame, pose, scan, space_frame

ECCENTRICITY = np.array([0.006, -0.007, 0.0039])
TILTS = ((0.02, 0.0), (0.0, 0.05), (-0.01, 0.02), (0.0, 0.0))
SIZES = NominalSizes(rods_mm=(60.0,), balls_mm=(200.0,), columns_mm=(300.0,))


@pytest.fixture(scope="module")
def frame():
    """One pyramid on four columns; a box, a target and the floor beside it."""
    built = space_frame(cells=(1, 1), eccentricity={"T00": ECCENTRICITY}, tilts=TILTS)
    built.boxes.append((np.array([3.6, 0.4, 0.0]), np.array([4.4, 1.2, 1.0])))
    built.spheres.append((np.array([-0.9, -0.9, 1.2]), 0.0725))
    return built


@pytest.fixture(scope="module")
def stations(frame, tmp_path_factory):
    """Four stations around it."""
    folder, places = tmp_path_factory.mktemp("stations"), ((1.3, -2.6), (5.0, 1.8), (1.0, 5.2), (-2.5, 0.8))
    given = []
    for number, place in enumerate(places):
        where = pose(f"S{number + 1}", (*place, 1.6), heading_deg=70.0 * number)
        np.save(folder / f"{where.name}.npy", scan(frame, where, number, step_deg=0.12))
        given.append((where.name, folder / f"{where.name}.npy", where))
    return given


def found_in(stations, folder, tile_m, sizes):
    tiles = build_tiles(stations, TileOptions(tile_m=tile_m, farthest_m=7.0), folder / "tiles", silent)
    return find_members(tiles, sizes, MemberOptions(), silent)


@pytest.fixture(scope="module")
def found(stations, tmp_path_factory):
    """Members without any size given."""
    return found_in(stations, tmp_path_factory.mktemp("found"), 4.0, NominalSizes())


def seen_at(members, middle):
    """The rods and columns that run through a place."""
    every = (*members.rods, *members.columns)
    return [r for r in every if r.apart(middle) < 0.02 and r.first_m < r.along(middle) < r.last_m]


def test_every_rod_and_column_is_found_once_and_nothing_else(frame, found):
    for start, end, *_ in frame.rods + frame.columns:
        assert len(seen_at(found, 0.5 * (start + end))) == 1
    assert (len(found.rods), len(found.columns), len(found.balls)) == (8, 4, 5)


def test_axes_radii_and_balls_are_right_within_their_sigmas(frame, found):
    normalised = []
    for start, end, radius, *_ in frame.rods + frame.columns:
        (rod,) = seen_at(found, 0.5 * (start + end))
        for place in (start, end):
            t = float(rod.along(place))
            off = rod.frame[:2] @ (rod.place + t * rod.direction - place)
            assert np.abs(off).max() < 0.0006
            moves = np.array([[1, 0, t, 0, 0], [0, 1, 0, t, 0]])
            normalised.extend(off / np.sqrt(np.diag(moves @ rod.covariance @ moves.T)))
        assert abs(rod.radius_m - radius) < 0.0005
    for _, centre, radius in frame.nodes.values():
        ball = min(found.balls, key=lambda b: np.linalg.norm(b.centre - centre))
        assert np.linalg.norm(ball.centre - centre) < 0.002
        assert abs(ball.radius_m - radius) < 0.001
        normalised.extend((ball.centre - centre) / np.sqrt(np.diag(ball.covariance)[:3]))
    assert np.mean(np.abs(normalised) <= 2) >= 0.88
    assert np.std(normalised) > 1 / 3


def test_balls_know_their_rods_and_the_column_below(found):
    top = max(found.balls, key=lambda b: b.centre[2])
    assert len(top.rods) == 4
    assert top.column == ""
    others = [b for b in found.balls if b is not top]
    assert {len(b.rods) for b in others} == {3}
    assert {b.column for b in others} == {c.name for c in found.columns}


def test_the_eccentric_node_is_reported_and_no_other(found):
    nodes = measure_nodes(found, NodeOptions())
    (eccentric,) = [n for n in nodes if n.significant]
    assert eccentric.amount_mm == pytest.approx(10.0, abs=0.8)
    np.testing.assert_allclose(eccentric.eccentricity_mm, 1000 * ECCENTRICITY, atol=0.9)


def test_tilts_are_right_within_a_millimetre(frame, found):
    for (bottom, top, _), tilt in zip(frame.columns, TILTS, strict=True):
        columns = measure_columns(found, [], ColumnOptions())
        one = min(columns, key=lambda c: np.hypot(*(c.bottom_m - bottom)[:2]))
        scale = (top[2] - bottom[2]) * 1000 / one.height_mm
        np.testing.assert_allclose(one.tilt_mm * scale, 1000 * np.array(tilt), atol=1.0)
        assert one.over == (np.hypot(*tilt) > 0.035)


def test_a_rod_across_tiles_is_one_rod_and_sizes_change_no_result(found, stations, tmp_path):
    cut = found_in(stations, tmp_path, 2.1, SIZES)
    assert (len(cut.rods), len(cut.columns), len(cut.balls)) == (8, 4, 5)
    for rod in found.rods:
        (same,) = seen_at(cut, rod.place)
        assert same.length_m == pytest.approx(rod.length_m, abs=0.15)
        sigma = np.sqrt(rod.covariance[0, 0])
        assert same.apart(rod.place) < 5 * sigma
        assert same.radius_m == pytest.approx(rod.radius_m, abs=5 * np.sqrt(rod.covariance[4, 4]))


def test_members_are_a_product_that_can_be_stored(found, tmp_path):
    store.save(found, tmp_path / "members.npz", tmp_path)
    again = store.load(Members, tmp_path / "members.npz", tmp_path)
    assert [r.name for r in again.rods] == [r.name for r in found.rods]
    np.testing.assert_array_equal(again.balls[0].share.gains, found.balls[0].share.gains)


def test_a_hall_without_members_says_what_was_looked_for(tmp_path):
    empty, where = Frame(), pose("S1", (0.0, 0.0, 1.6))
    np.save(tmp_path / "S1.npy", scan(empty, where, 1, step_deg=0.5))
    tiles = build_tiles(
        [("S1", tmp_path / "S1.npy", where)], TileOptions(farthest_m=4.0), tmp_path / "tiles", silent
    )
    with pytest.raises(StageError, match=r"no rod or column \(a cylinder of diameter 30 to 900 mm"):
        find_members(tiles, NominalSizes(), MemberOptions(), silent)
    with pytest.raises(StageError, match=r"48 to 72 mm or .* check structure\.rod_diameters_mm"):
        find_members(tiles, replace(SIZES, balls_mm=()), MemberOptions(), silent)
