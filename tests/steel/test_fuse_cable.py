"""A cable's photo model and a scan of it: what fixes the turn and the slide, and what does not."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from pipeline.core.errors import StageError
from pipeline.core.events import silent
from pipeline.core.rotations import rotation_from_vector
from pipeline.steel.fuse import fuse
from pipeline.steel.fuse_records import FuseOptions, PhotoCloud, ScanCloud, Start

OPTIONS = FuseOptions(scale_sigma_share=0.01, photo_points=5000)
RADIUS, LENGTH = 0.055, 0.46


class Cable:
    """Paint and dents at (azimuth, y), both smooth pictures of 360 x 460 cells."""

    def __init__(self, seed, dents_m):
        rng = np.random.default_rng(seed)
        paint, dents = (gaussian_filter(rng.normal(size=(360, 460)), s, mode="wrap") for s in (2, 5))
        self.paint, self.dents = 120 + 25 * paint / paint.std(), dents_m * dents / dents.std()

    def points(self, rng, count, first=0.0, last=LENGTH):
        azimuth, y = rng.uniform(0, 2 * np.pi, count), rng.uniform(first, last, count)
        cell = (np.degrees(azimuth).astype(int) % 360, np.minimum((y * 1000).astype(int), 459))
        outward = np.stack([np.cos(azimuth), np.zeros(count), -np.sin(azimuth)], axis=1)
        radius = RADIUS + self.dents[cell]
        return np.column_stack([radius * outward[:, 0], y, radius * outward[:, 2]]), outward, self.paint[cell]


def clouds(seed, dents_m, noise_m, painted):
    """Photo cloud, scan, and scale, rotation, translation of the truth."""
    rng, cable = np.random.default_rng(seed + 100), Cable(seed, dents_m)
    points, outward, paint = cable.points(rng, 120_000)
    photo = PhotoCloud(
        points=points + 5e-5 * rng.normal(size=(len(points), 1)) * outward,
        normals=outward,
        colours=np.repeat(np.clip(paint, 0, 255).astype(np.uint8)[:, None], 3, axis=1),
        sigmas=np.zeros(0),
    )
    turn, scale = rotation_from_vector(rng.normal(0, 1.5, 3)), 1 + rng.uniform(-0.005, 0.005)
    move = rng.uniform(-4, 4, 3)
    points, outward, paint = cable.points(rng, 150_000, first=0.05)
    points = points + noise_m * rng.normal(size=(len(points), 1)) * outward
    scan = ScanCloud(
        points=scale * points @ turn.T + move,
        stations=np.zeros(len(points), dtype=np.int64),
        scanners=np.zeros((0, 3)),
        intensities=0.01 * paint + 0.1 * rng.normal(size=len(points)) if painted else np.zeros(0),
    )
    return photo, scan, (scale, turn, move)


def error(fusion, truth):
    """Root mean square over the cable's surface, metres."""
    scale, turn, move = truth
    places = Cable(0, 0.0).points(np.random.default_rng(9), 500)[0]
    return np.sqrt(
        np.mean(np.sum((fusion.placement.apply(places) - (scale * places @ turn.T + move)) ** 2, axis=1))
    ), (np.sqrt(np.mean(fusion.sigmas_at_mm(scale * places @ turn.T + move) ** 2)) / 1000)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_paint_holds_turn_and_slide_either_way_round(seed):
    photo, scan, truth = clouds(seed, 0.0, 0.0005, painted=True)
    fusion = fuse(photo, scan, (), OPTIONS, silent)
    assert fusion.start is Start.UNROLLED
    off, sigma = error(fusion, truth)
    assert off < 3e-4
    assert off / 3 < sigma < 2e-3
    assert {"brightness"} <= {d.held_by for d in fusion.directions} <= {"brightness", "points"}
    assert fusion.placement.scale == pytest.approx(truth[0], rel=1e-3)


def test_dents_hold_it_without_any_brightness():
    photo, scan, truth = clouds(4, 0.0004, 0.0001, painted=False)
    fusion = fuse(photo, scan, (), OPTIONS, silent)
    off, sigma = error(fusion, truth)
    assert off < 2e-4
    assert off / 3 < sigma
    assert all(d.determined for d in fusion.directions)


def test_a_smooth_cable_leaves_turn_and_slide_open_and_says_so():
    photo, scan, truth = clouds(5, 0.0, 0.0005, painted=False)
    fusion = fuse(photo, scan, (), OPTIONS, silent)
    open_ones = {d.words for d in fusion.directions if not d.determined}
    assert open_ones == {"a turn about the cable's axis", "a shift along the cable's axis"}
    assert "undetermined" in fusion.notes[0]
    off, sigma = error(fusion, truth)
    assert off < 2 * sigma
    assert sum(d.determined and d.sigma_mm < 0.2 for d in fusion.directions) == 5


def test_another_cable_is_refused():
    photo, scan, _ = clouds(6, 0.0, 0.0005, painted=True)
    wide = ScanCloud(
        points=1.3 * scan.points, stations=scan.stations, scanners=scan.scanners, intensities=scan.intensities
    )
    with pytest.raises(StageError, match="check that both show the same cable"):
        fuse(photo, wide, (), OPTIONS, silent)
