"""A run folder and its truth written by hand: nothing is reconstructed here.

A cable of 111 mm, oval and a little wavy, seen by four cameras; errors are put in as a test asks.
"""

import json
from math import cos, radians, sin

import cv2  # noqa: F401 - before pycolmap
import numpy as np
import pycolmap

PAPER = {"A": (112.383, 111.4), "B": (112.125, 110.8), "C": (111.748, 110.7), "D": (111.731, 111.1)}
FRAMES = 12
TRAVEL_M = 0.46
THETA_DEG = np.arange(0.0, 360.0, 2.0)
POSITION_M = np.linspace(0.0, TRAVEL_M, 47)
LENS = {
    "focal_px": 720.0,
    "principal_point_px": [480.0, 300.0],
    "division_lambda": -0.02,
    "lambda_radius": "half-diagonal",
    "width_px": 960,
    "height_px": 600,
}


def turn(axis, angle_deg):
    a = radians(angle_deg)
    x, y = [k for k in range(3) if k != axis] if axis != 1 else (2, 0)
    R = np.eye(3)
    R[x, x] = R[y, y] = cos(a)
    R[x, y], R[y, x] = -sin(a), sin(a)
    return R


def true_pose(block, frame):
    """(R, centre) of a camera that looks at the axis; its x axis along the travel."""
    a = radians(90.0 * block)
    forward, right = np.array([-cos(a), 0, sin(a)]), np.array([0.0, 1.0, 0.0])
    R = np.stack([right, np.cross(forward, right), forward])
    return R, np.array([0.3 * cos(a), TRAVEL_M * frame / (FRAMES - 1), -0.3 * sin(a)])


def true_radius(theta_deg, position_m):
    theta, position = np.meshgrid(np.radians(theta_deg), position_m)
    return 55.5 + 0.2 * np.cos(2 * theta) + 0.3 * np.sin(8 * position)


def matrix(R, centre):
    return np.column_stack([R, -R @ centre])


def write_sparse(folder, block, change, frames=range(FRAMES), name="{:06d}.png"):
    """A COLMAP model of one block, each true pose changed by a function (R, centre) -> (R, centre)."""
    model = pycolmap.Reconstruction()
    camera = pycolmap.Camera(
        model="SIMPLE_PINHOLE", width=960, height=600, params=[720, 480, 300], camera_id=1
    )
    model.add_camera_with_trivial_rig(camera)
    for number, frame in enumerate(frames, start=1):
        pose = pycolmap.Rigid3d(matrix(*change(*true_pose(block, frame))))
        image = pycolmap.Image(name=name.format(frame), camera_id=1, image_id=number)
        model.add_image_with_trivial_frame(image, pose)
    folder.mkdir(parents=True)
    model.write(str(folder))


def same(R, centre):
    return R, centre


def write_case(
    folder, change=same, blocks=(0, 1, 2, 3), radius_mm=None, lens=(), stations=None, frames=range(FRAMES)
):
    """Write a run and its truth, with errors as asked; gives the run folder and truth.json."""
    run = folder / f"run{len(list(folder.iterdir()))}"
    lenses = {f"Block{b + 1}": LENS for b in blocks}
    for b in blocks:
        write_sparse(run / "blocks" / f"Block{b + 1}" / "sparse", b, change, frames)
    theta, position = np.arange(0.5, 360, 2.5), np.linspace(0.005, 0.455, 61)
    radius = true_radius(theta, position) if radius_mm is None else radius_mm(theta, position)
    np.savez(run / "radius_map.npz", theta_deg=theta, position_m=position, radius_mm=radius)
    (run / "report.json").write_text(json.dumps(_report(lenses, dict(lens), stations)))
    (folder / "truth.json").write_text(json.dumps(_truth(lenses, blocks)))
    return run, folder / "truth.json"


def _report(lenses, errors, stations):
    of_run = {key: value for key, value in LENS.items() if not key.endswith("_px")}
    measured = [
        {
            "name": name,
            "position_m": 0.1 * k,
            "diameter_mm": model,
            "sigma_mm": 0.5,
            "coverage_deg": 350.0,
        }
        for k, (name, (model, _)) in enumerate(PAPER.items(), start=1)
    ]
    return {
        "format": 1,
        "name": "test",
        "stations": stations or measured,
        "blocks": [{"name": name, **of_run, "focal_px": 720.0, **errors} for name in lenses],
        "axis": {"straightness_mm_per_m": 0.12},
    }


def _truth(lenses, blocks):
    return {
        "format": 1,
        "stations": [
            {"name": name, "position_m": 0.1 * k, "diameter_mm": true}
            for k, (name, (_, true)) in enumerate(PAPER.items(), start=1)
        ],
        "radius_mm": {
            "theta_deg": THETA_DEG.tolist(),
            "position_m": POSITION_M.tolist(),
            "values": true_radius(THETA_DEG, POSITION_M).tolist(),
        },
        "poses": {
            f"Block{b + 1}": [
                {"frame": k, "cam_from_world": matrix(*true_pose(b, k)).tolist()} for k in range(FRAMES)
            ]
            for b in blocks
        },
        "lenses": lenses,
        "travel_m": TRAVEL_M,
        "spec": {},
    }


def told(path, **keys):
    """Add keys to a report or a truth."""
    spoil(path, lambda values: values.update(keys))


def spoil(path, change):
    values = json.loads(path.read_text())
    change(values)
    path.write_text(json.dumps(values))
