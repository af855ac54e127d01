"""Photo clouds brought into the scans' frame: seven parameters, their sigmas, and what is refused."""

import numpy as np
import pytest
from plyfile import PlyData

from pipeline.core import store
from pipeline.core.errors import Cancelled, StageError
from pipeline.core.events import silent
from pipeline.core.rotations import vector_from_rotation
from pipeline.steel.fuse import fuse
from pipeline.steel.fuse_records import FuseOptions, Fusion, GivenPair, Start
from pipeline.steel.merged_cloud import write_merged
from tests.steel.fused_scene import (
    BALLS,
    MOVE,
    SCALE,
    TURN,
    features,
    into_photo,
    photo_cloud,
    scan_cloud,
)

QUICK = FuseOptions(photo_points=5000)
SCALE_ASKED = 1e-3
"""Of the issue: scale within 0.1 %."""
PHOTO_NOISE = 0.003
"""Of one photo point, metres: thousands together are worth more than one, however much they bend."""


@pytest.fixture(scope="module")
def scan():
    return scan_cloud(1)


@pytest.fixture(scope="module")
def photo():
    return photo_cloud(2)


@pytest.fixture(scope="module")
def fusion(photo, scan):
    return fuse(photo, scan, features(), QUICK, silent)


def errors(fusion, places):
    """Places (n, 3) of the site after the fusion, less the truth, metres."""
    return fusion.placement.apply(into_photo(places)) - places


def assert_within_sigmas(fusion):
    """All seven parameters within three of their sigmas, which are small enough to be worth having."""
    sigmas = np.sqrt(np.diag(fusion.covariance))
    assert sigmas[6] < SCALE_ASKED
    assert abs(np.log(fusion.placement.scale / SCALE)) < 3 * sigmas[6]
    turn = vector_from_rotation(fusion.placement.rotation @ TURN.T)
    assert (np.abs(turn) < 3 * sigmas[:3]).all()
    at_balls = fusion.sigmas_at_mm(BALLS[:, :3])
    assert (at_balls < 1000 * PHOTO_NOISE).all()
    assert (1000 * np.linalg.norm(errors(fusion, BALLS[:, :3]), axis=1) < 3 * at_balls).all()


def test_scale_place_and_turn_are_found_without_names(fusion):
    assert fusion.start is Start.FEATURES
    assert_within_sigmas(fusion)
    assert len(fusion.pairs) >= 5
    assert np.abs([p.residual_mm for p in fusion.pairs]).max() < 25
    assert all(d.determined for d in fusion.directions)


def test_cloud_to_cloud_is_the_noise_of_both(fusion):
    # 3 mm of the photos, the scan's 2 mm averaged away: median of a normal distribution at 0.674 sigma
    assert 0.674 * 2.8 < fusion.median_mm < 0.674 * 3.8
    assert 0.4 < fusion.overlap < 1


def test_given_pairs_come_before_all_search(photo, scan):
    pairs = tuple(
        GivenPair(name=f"P{k}", photo=into_photo(BALLS[k, :3] + 0.01), site=BALLS[k, :3]) for k in (0, 1, 2)
    )
    fusion = fuse(photo, scan, (), QUICK, silent, pairs=pairs)
    assert fusion.start is Start.PAIRS
    assert_within_sigmas(fusion)
    assert [p.name for p in fusion.pairs] == ["P0", "P1", "P2"]
    # the pairs were pointed out 10 mm beside; the rest is where the fusion put the place
    np.testing.assert_allclose(
        fusion.pairs[0].residual_mm, 10, atol=3 * fusion.sigmas_at_mm(BALLS[:1, :3])[0]
    )


def test_sigmas_hold_where_the_photo_model_is_bent():
    """Bends of 3 mm over metres: sigma from the number of points would be twenty times too small."""
    places = np.array([[0, 0, 0], [3, 0, 0], [0, 3, 0], [3, 3, 0], [1.2, 1.2, 3.5]], dtype=float)
    ratios, scales, scan = [], [], scan_cloud(1, count=90_000)
    for seed in range(6):
        bent = photo_cloud(seed + 10, count=20_000, bent=0.003)
        fusion = fuse(bent, scan, features(seed), FuseOptions(photo_points=3000, iterations=15), silent)
        off = 1000 * np.sqrt(np.sum(errors(fusion, places) ** 2, axis=1))
        ratios.extend(off / fusion.sigmas_at_mm(places))
        scales.append((fusion.placement.scale / SCALE - 1) / np.sqrt(fusion.covariance[6, 6]))
    for normalised in (np.array(ratios), np.abs(scales)):
        assert np.mean(normalised < 2) >= 0.9 - 1 / len(normalised)
        assert np.sqrt(np.mean(normalised**2)) > 1 / 3


def test_the_merged_cloud_says_where_each_point_came_from(fusion, photo, scan, tmp_path):
    path = tmp_path / "merged.ply"
    write_merged(path, photo, scan, fusion, ("S01", "S02"))
    rows = PlyData.read(str(path))["vertex"].data
    assert len(rows) == len(photo) + len(scan)
    assert np.count_nonzero(rows["origin"] == -1) == len(photo)
    np.testing.assert_array_equal(rows["origin"][: len(scan)], scan.stations)
    last = np.array([rows[-1][axis] for axis in "xyz"])
    np.testing.assert_allclose(last, fusion.placement.apply(photo.points[-1]), atol=1e-5)
    assert "; 1 is station S02" in path.read_bytes()[:900].decode(errors="replace")


def test_a_fusion_is_stored_and_is_the_same_every_time(fusion, photo, scan, tmp_path):
    store.save(fusion, tmp_path / "f.npz", tmp_path)
    again = store.load(Fusion, tmp_path / "f.npz", tmp_path)
    np.testing.assert_array_equal(again.covariance, fusion.covariance)
    assert again.directions[0].words == fusion.directions[0].words
    repeated = fuse(photo, scan, features(), QUICK, silent)
    np.testing.assert_array_equal(repeated.placement.translation, fusion.placement.translation)


def test_a_structure_that_looks_alike_from_two_sides_is_refused():
    """Without the ball beside it the frame may be turned by a quarter about its middle, floor and all."""
    balls, middle = BALLS[:5], np.array([1.2, 1.2])

    def without_floor(cloud):
        site = cloud.points if hasattr(cloud, "stations") else SCALE * cloud.points @ TURN.T + MOVE
        return (site[:, 2] > 0.5) & (np.linalg.norm(site[:, :2] - middle, axis=1) < 3)

    photo, scan = photo_cloud(3, balls=balls), scan_cloud(4, balls=balls)
    # every side must be seen alike: the scan's own points for both
    kept = without_floor(photo)
    photo = type(photo)(
        points=photo.points[kept],
        normals=photo.normals[kept],
        colours=photo.colours[kept],
        sigmas=photo.sigmas[kept],
        spheres=photo.spheres,
    )
    with pytest.raises(StageError, match="looks alike in two places"):
        fuse(photo, scan.where(without_floor(scan)), features(balls=balls), QUICK, silent)


def test_pairs_on_a_line_are_refused(photo, scan):
    pairs = tuple(
        GivenPair(name=f"P{k}", photo=into_photo(np.array([k, 0.0, 0])), site=np.array([k, 0.0, 0]))
        for k in range(4)
    )
    with pytest.raises(StageError, match="lie on a line"):
        fuse(photo, scan, (), QUICK, silent, pairs=pairs)


def test_too_little_overlap_is_refused(photo, scan):
    corner = scan.where(np.linalg.norm(scan.points - BALLS[0, :3], axis=1) < 0.35)
    with pytest.raises(StageError, match=r"only \d+ % of the photo cloud|only \d+ scanned points"):
        fuse(photo, corner, features(), QUICK, silent)


def test_scans_without_spheres_are_refused(photo, scan):
    with pytest.raises(StageError, match="hold 0 spheres"):
        fuse(photo, scan, (), QUICK, silent)


def test_fusing_can_be_stopped(photo, scan):
    def stop(event):
        if event.done > 30:
            raise Cancelled

    with pytest.raises(Cancelled):
        fuse(photo, scan, features(), QUICK, stop)
