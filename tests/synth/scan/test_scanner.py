"""The virtual scanner: exact without noise, noisy as stated, mixed at edges, blind behind things."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from synth.scan.frame import build_frame
from synth.scan.layout import build_layout
from synth.scan.mesh import mesh_of
from synth.scan.panorama import Grid, cast, cut
from synth.scan.primitives import World, build_world
from synth.scan.scanner import angles, directions_of, scan
from synth.scan.spec import Scanner, read_scan_spec

from .worlds import world_of

ROOT = Path(__file__).parents[3]
EXACT = Scanner(
    range_sigma_mm=0.0, angle_sigma_arcsec=0.0, divergence_mrad=0.0, step_deg=0.5, incidence_limit_deg=90.0
)


def scanned(world: World, scanner: Scanner, seed: int = 1):
    bands = list(scan(world, scanner, (seed, 0)))
    return {
        name: np.concatenate([getattr(band, name) for band in bands])
        for name in ("points", "intensity", "owner", "mixed")
    }


def small_world(station: int = 1) -> World:
    spec = read_scan_spec(ROOT / "specs/steel/small.toml")
    frame = build_frame(spec)
    layout = build_layout(spec, frame)
    pose = layout.stations[station]
    return build_world(spec, frame, layout, station).seen_from(pose.rotation, pose.centre)


def off_surfaces(world: World, points, owner):
    """Distance of every point from the surface of its owner that is nearest, by formulas of our own."""
    best = np.full(len(points), np.inf)

    def offer(owned, distance):
        mine = owner == owned
        best[mine] = np.minimum(best[mine], np.abs(distance(points[mine])))

    for row, owned in zip(world.sphere, world.sphere_owner, strict=True):
        offer(owned, lambda p, r=row: np.linalg.norm(p - r[:3], axis=1) - r[3])
    for row, owned in zip(world.cylinder, world.cylinder_owner, strict=True):
        axis = (row[3:6] - row[:3]) / np.linalg.norm(row[3:6] - row[:3])
        offer(owned, lambda p, r=row, a=axis: np.linalg.norm(np.cross(p - r[:3], a), axis=1) - r[6])
    for row, owned in zip(world.rectangle, world.rectangle_owner, strict=True):
        normal = np.cross(row[3:6], row[6:])
        offer(owned, lambda p, r=row, n=normal: (p - r[:3]) @ n / np.linalg.norm(n))
    for row, owned in zip(world.disc, world.disc_owner, strict=True):
        offer(owned, lambda p, r=row: (p - r[:3]) @ r[3:6])
    return best


def test_without_noise_every_point_lies_on_the_surface_it_names():
    world = small_world()
    cloud = scanned(world, EXACT)
    assert len(cloud["points"]) > 80_000
    assert off_surfaces(world, cloud["points"], cloud["owner"]).max() < 1e-6
    assert not cloud["mixed"].any()


def test_a_sphere_hides_the_wall_behind_it_and_nothing_else():
    wall = ("rectangle", [6.0, -6.0, -6.0], [0.0, 12.0, 0.0], [0.0, 0.0, 12.0])
    open_, hidden = (
        scanned(world_of(wall), EXACT),
        scanned(world_of(wall, ("sphere", [3.0, 0, 0], 0.5)), EXACT),
    )
    shadow = np.linalg.norm(np.cross(open_["points"], [1.0, 0.0, 0.0]), axis=1) / open_["points"][:, 0]
    inside = shadow < np.tan(np.arcsin(0.5 / 3.0))
    assert np.count_nonzero(hidden["owner"] == 1) == np.count_nonzero(inside)
    left = hidden["points"][hidden["owner"] == 0]
    assert left == pytest.approx(open_["points"][~inside], abs=1e-12)


def test_every_ray_finds_what_a_search_over_all_surfaces_finds():
    """The windows leave nothing out: cast with windows of everything."""
    world, (azimuth, elevation) = small_world(2), angles(Scanner(step_deg=1.3, elevation_deg=(-70.0, 90.0)))
    grid = Grid(azimuth=azimuth, elevation=elevation)
    directions = directions_of(azimuth[None, :], elevation[:, None])
    pieces = cut(world, 1e6)
    narrow = cast(world, pieces, grid, directions, 0.0, 0.0)
    everywhere = cast(world, pieces, grid, directions, 10.0, 0.0)
    assert np.array_equal(narrow.owner, everywhere.owner)
    met = narrow.owner >= 0
    assert narrow.range_m[met] == pytest.approx(everywhere.range_m[met], abs=1e-9)
    assert len(np.unique(narrow.owner)) > 60


def test_blender_meets_the_same_things_at_the_same_ranges(tmp_path):
    """A second opinion: Blender's tree over polygons, 4 m to 12 m away and cut inside by at most 0.4 mm."""
    world, (azimuth, elevation) = small_world(3), angles(Scanner(step_deg=1.7, elevation_deg=(-60.0, 89.0)))
    directions = directions_of(azimuth[None, :], elevation[:, None])
    ours = cast(world, cut(world, 1e6), Grid(azimuth=azimuth, elevation=elevation), directions, 0.0, 0.0)
    mesh = mesh_of(world, 96)
    asked = tmp_path / "world.npz"
    flat = directions.reshape(-1, 3)
    np.savez(asked, vertices=mesh.vertices, quads=mesh.quads, owner=mesh.owner, directions=flat)
    subprocess.run([sys.executable, "-m", "synth.scan.blender_rays", asked], cwd=ROOT, check=True)
    with np.load(asked.with_suffix(".met.npz")) as met:
        owner, range_m = met["owner"], met["range_m"]
    same = owner == ours.owner.ravel()
    assert same.mean() > 0.998  # outlines differ
    both = same & (owner >= 0) & (ours.cosine.ravel() > 0.3)
    off_m = range_m[both] - ours.range_m.ravel()[both]
    assert np.abs(off_m).max() < 1e-3
    assert np.median(np.abs(off_m)) < 1e-5


def test_range_noise_is_as_stated():
    wall = ("rectangle", [10.0, -3.0, -3.0], [0.0, 6.0, 0.0], [0.0, 0.0, 6.0])
    noisy = Scanner(range_sigma_mm=3.0, angle_sigma_arcsec=0.0, divergence_mrad=0.0, step_deg=0.1)
    points = scanned(world_of(wall), noisy)["points"]
    off_mm = 1000.0 * (points[:, 0] - 10.0) * np.linalg.norm(points, axis=1) / points[:, 0]
    assert len(points) > 50_000
    assert 2.97 < off_mm.std() < 3.03
    assert abs(off_mm.mean()) < 0.05


def test_angle_noise_moves_points_across_the_ray():
    """On a plane met at 45 degrees an angle error of a gives a range error of range * a."""
    normal = np.array([1.0, -1.0, 0.0]) / np.sqrt(2.0)
    plane = ("rectangle", [9.0, -1.0, -1.0], [2.0, 2.0, 0.0], [0.0, 0.0, 2.0])
    scanner = Scanner(
        range_sigma_mm=0.0,
        angle_sigma_arcsec=20.0,
        divergence_mrad=0.0,
        step_deg=0.02,
        elevation_deg=(-2.0, 2.0),
    )
    points = scanned(world_of(plane), scanner)["points"]
    near = np.abs(np.degrees(np.arctan2(points[:, 1], points[:, 0]))) < 1.0
    off_mm = 1000.0 * (points[near] @ normal - 10.0 / np.sqrt(2.0))
    expected_mm = 1000.0 * 10.0 * np.radians(20.0 / 3600.0) / np.sqrt(2.0)
    assert np.count_nonzero(near) > 5_000
    assert 0.95 * expected_mm < off_mm.std() < 1.05 * expected_mm


def test_mixed_pixels_lie_between_the_two_surfaces_and_only_at_the_outline():
    world = world_of(
        ("sphere", [5.0, 0.0, 0.0], 0.5), ("rectangle", [8.0, -9.0, -9.0], [0.0, 18.0, 0.0], [0.0, 0.0, 18.0])
    )
    scanner = Scanner(range_sigma_mm=0.0, angle_sigma_arcsec=0.0, divergence_mrad=4.0, step_deg=0.1)
    cloud = scanned(world, scanner)
    ranges = np.linalg.norm(cloud["points"], axis=1)
    between = (ranges > 5.05) & (cloud["points"][:, 0] < 7.9)
    assert np.count_nonzero(between) > 100
    assert cloud["mixed"][between].all()
    beside = np.degrees(np.arccos(cloud["points"][between, 0] / ranges[between]))
    outline_deg = np.degrees(np.arcsin(0.1))
    assert np.abs(beside - outline_deg).max() < np.degrees(0.002) + 1e-6
    # the ring of beams that cross the outline; twelve sub-rays span 0.83 of the beam on the average
    ring = 2.0 * np.pi * outline_deg * 2.0 * np.degrees(0.002) / 0.1**2
    assert 0.78 * ring < np.count_nonzero(between) < 0.88 * ring


def test_nothing_comes_back_from_too_far_too_near_or_too_flat():
    floor = ("rectangle", [-50.0, -50.0, -1.5], [100.0, 0.0, 0.0], [0.0, 100.0, 0.0])
    scanner = replace(EXACT, max_range_m=20.0, min_range_m=2.0, incidence_limit_deg=80.0)
    points = scanned(world_of(floor), scanner)["points"]
    ranges = np.linalg.norm(points, axis=1)
    assert ranges.min() >= 2.0
    assert 1.5 / np.cos(np.radians(79.0)) < ranges.max() <= 1.5 / np.cos(np.radians(80.0)) + 1e-6


def test_the_same_seed_gives_the_same_cloud_and_another_does_not():
    world, scanner = small_world(), Scanner(step_deg=1.0)
    first, again, other = (scanned(world, scanner, seed)["points"] for seed in (4, 4, 5))
    assert np.array_equal(first, again)
    assert first.shape != other.shape or not np.allclose(first, other, atol=1e-4)


def test_stations_differ_in_heading_and_are_level_to_the_stated_sigma():
    spec = read_scan_spec(ROOT / "specs/steel/hall_12_targets.toml")
    layout = build_layout(spec, build_frame(spec))
    ups = np.array([pose.rotation[2, :2] for pose in layout.stations])
    arcsec = np.degrees(ups) * 3600.0
    assert 1.5 < arcsec.std() < 5.0  # stated 3, of 24 numbers
    headings = np.degrees([np.arctan2(pose.rotation[1, 0], pose.rotation[0, 0]) for pose in layout.stations])
    assert np.ptp(headings) > 180.0
