"""Registered points on disk: all there, in the site frame, each with its station, thinned without bias."""

import numpy as np
import pytest

from pipeline.core import store
from pipeline.core.errors import StageError
from pipeline.core.events import silent
from pipeline.steel.tile_reader import TileReader
from pipeline.steel.tile_records import TileOptions, Tiles
from pipeline.steel.tiles import build_tiles
from tests.steel.scanned_frame import pose


def clouds(folder, *points):
    """Stations S1, S2, ... with these clouds, standing in different places and turned."""
    stations = []
    for number, cloud in enumerate(points):
        path = folder / f"S{number + 1}.npy"
        np.save(path, np.asarray(cloud, dtype=np.float32))
        where = pose(f"S{number + 1}", (3.0 * number, -2.0, 1.5), heading_deg=40.0 * number)
        stations.append((where.name, path, where))
    return stations


def scattered(seed, count=3000):
    return np.random.default_rng(seed).uniform(-9, 9, (count, 3))


def test_every_point_is_found_again_in_the_site_frame_with_its_station(tmp_path):
    given = clouds(tmp_path, scattered(1), scattered(2))
    tiles = build_tiles(given, TileOptions(nearest_m=0.0), tmp_path / "tiles", silent)
    assert tiles.counts.sum() == tiles.read_points == 6000
    found = TileReader(tiles).box(np.full(3, -50.0), np.full(3, 50.0))
    for number, (_, path, where) in enumerate(given):
        expected = np.load(path).astype(float) @ where.rotation.T + where.translation
        got = found.places[found.stations == number]
        order = [np.lexsort(np.round(p, 4).T) for p in (expected, got)]
        np.testing.assert_allclose(got[order[1]], expected[order[0]], atol=2e-6)


def test_a_box_and_a_capsule_hold_what_lies_in_them_across_the_borders_of_tiles(tmp_path):
    given = clouds(tmp_path, scattered(1, 120_000))
    tiles = build_tiles(given, TileOptions(tile_m=2.0), tmp_path / "tiles", silent)
    reader = TileReader(tiles, most_points=5000)
    every = reader.box(np.full(3, -50.0), np.full(3, 50.0)).places
    low, high = np.array([-3.1, -4.0, 0.2]), np.array([1.7, 2.2, 3.9])
    inside = every[((every >= low) & (every < high)).all(axis=1)]
    assert len(reader.box(low, high)) == len(inside) > 500
    start, end = np.array([-3.0, -4.0, 1.0]), np.array([2.0, 1.0, 4.0])
    axis = (end - start) / np.linalg.norm(end - start)
    along = np.clip((every - start) @ axis, 0, np.linalg.norm(end - start))
    near = np.linalg.norm(every - start - along[:, None] * axis, axis=1) < 0.4
    assert len(reader.capsule(start, end, 0.4)) == near.sum() > 50


def test_thinning_neither_moves_a_surface_nor_makes_its_noise_larger(tmp_path):
    rng = np.random.default_rng(3)
    directions = np.column_stack([np.ones(400_000), *rng.uniform(-0.05, 0.05, (2, 400_000))])
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    ranges = 5.0 + rng.normal(0, 0.002, len(directions))
    given = clouds(tmp_path, directions * ranges[:, None])
    tiles = build_tiles(given, TileOptions(spacing_m=0.01), tmp_path / "tiles", silent)
    found = TileReader(tiles).box(np.full(3, -50.0), np.full(3, 50.0))
    kept = np.linalg.norm(found.places - given[0][2].translation, axis=1)
    # half a metre square, one point in a centimetre square
    assert 2000 < len(kept) < 4500
    assert abs(kept.mean() - 5.0) < 4 * 0.002 / np.sqrt(len(kept))
    assert 0.0018 < kept.std() < 0.0022


def test_a_tile_with_too_many_points_is_thinned_to_the_limit(tmp_path):
    given = clouds(tmp_path, np.random.default_rng(1).uniform(1, 2, (300_000, 3)))
    options = TileOptions(spacing_m=0.0005, most_points=100_000)
    tiles = build_tiles(given, options, tmp_path / "tiles", silent)
    assert tiles.counts.max() == 100_000
    assert len(TileReader(tiles).tile(tuple(tiles.cells[np.argmax(tiles.counts)].tolist()))) == 100_000


def test_tiles_are_a_product_that_can_be_stored(tmp_path):
    tiles = build_tiles(clouds(tmp_path, scattered(1)), TileOptions(), tmp_path / "tiles", silent)
    store.save(tiles, tmp_path / "tiles.npz", tmp_path)
    again = store.load(Tiles, tmp_path / "tiles.npz", tmp_path)
    assert again.folder == tiles.folder
    np.testing.assert_array_equal(again.cells, tiles.cells)
    np.testing.assert_array_equal(again.stations[0].rotation, tiles.stations[0].rotation)


def test_an_interrupt_leaves_no_tiles_behind(tmp_path):
    def stop(event):
        if event.block == "S2":
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        build_tiles(clouds(tmp_path, scattered(1), scattered(2)), TileOptions(), tmp_path / "tiles", stop)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["S1.npy", "S2.npy"]


def test_clouds_without_a_point_in_reach_are_refused(tmp_path):
    with pytest.raises(StageError, match="none of the 3 points of 1 stations"):
        build_tiles(clouds(tmp_path, np.full((3, 3), 4000.0)), TileOptions(), tmp_path / "tiles", silent)
    with pytest.raises(StageError, match="no registered station"):
        build_tiles([], TileOptions(), tmp_path / "tiles", silent)
