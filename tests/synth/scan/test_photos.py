"""The flight above the frame: poses, and a photo that shows the targets where the truth says."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from synth.scan.flight import lens_of, shots
from synth.scan.spec import Photos, read_scan_spec

ROOT = Path(__file__).parents[3]
SPEC = read_scan_spec(ROOT / "specs/steel/small.toml")
STILL = Photos(count=(3, 2), jitter_m=0.0, sway_deg=0.0, converge=1.0)


def test_without_sway_every_photo_looks_at_the_middle_of_the_bottom_chord():
    middle = np.array([3.0, 3.0, 4.5])
    for shot in shots(SPEC, STILL):
        in_camera = shot.rotation @ (middle - shot.centre)
        assert in_camera[:2] == pytest.approx([0.0, 0.0], abs=1e-12)
        assert in_camera[2] > 0.0
        assert shot.rotation @ shot.rotation.T == pytest.approx(np.eye(3), abs=1e-12)
        assert np.linalg.det(shot.rotation) == pytest.approx(1.0)
        assert shot.centre[2] == pytest.approx(4.5 + 2.1 + 5.0)


def test_the_flight_goes_there_and_back_with_the_camera_turned_about():
    flight = shots(SPEC, replace(STILL, converge=0.0))
    x, y, _ = np.array([shot.centre for shot in flight]).T
    assert x == pytest.approx([0.3, 3.0, 5.7, 5.7, 3.0, 0.3])
    assert y == pytest.approx([0.3] * 3 + [5.7] * 3)
    assert [round(shot.rotation[0, 0]) for shot in flight] == [1, 1, 1, -1, -1, -1]
    assert all(shot.rotation[2] == pytest.approx([0.0, 0.0, -1.0]) for shot in flight)


def test_jitter_and_sway_have_the_stated_size():
    photos = Photos(count=(20, 10), jitter_m=0.2, sway_deg=3.0, converge=0.0)
    plan = shots(SPEC, replace(photos, jitter_m=0.0, sway_deg=0.0))
    flown = shots(SPEC, photos)
    off_m = np.array([a.centre - b.centre for a, b in zip(flown, plan, strict=True)])
    assert 0.18 < off_m.std() < 0.22
    turns = [
        np.arccos((np.trace(a.rotation @ b.rotation.T) - 1) / 2) for a, b in zip(flown, plan, strict=True)
    ]
    assert 2.7 < np.degrees(np.sqrt(np.mean(np.square(turns)) / 3.0)) < 3.3


def test_a_photo_shows_the_white_targets_where_the_truth_projects_them(tmp_path):
    """By the command, in the site frame, which is turned against the hall's; photo number 1 of 1."""
    text = (ROOT / "specs/steel/small.toml").read_text().replace('level = "clouds"', 'level = "targets"')
    text += "\n[photos]\ncount = [1, 1]\nwidth_px = 320\nheight_px = 320\nfocal_px = 270.0\nsamples = 2\n"
    spec = tmp_path / "spec.toml"
    spec.write_text(text)
    command = [sys.executable, "-m", "synth", "scan", spec, tmp_path / "out", "--quiet"]
    subprocess.run(command, cwd=ROOT, check=True)  # bpy wants a process of its own
    truth = json.loads((tmp_path / "out/truth.json").read_text())
    (photo,), lens = truth["photos"], truth["photo_lens"]
    picture = cv2.imread(str(tmp_path / "out/photos" / photo["name"]), cv2.IMREAD_GRAYSCALE)
    assert picture.shape == (320, 320)
    found = []
    for target in truth["targets"]:
        x, y, z = np.array(photo["rotation"]) @ target["position_m"] + photo["translation"]
        u, v = lens["focal_px"] * np.array([x, y]) / z + lens["principal_point_px"]
        if 12 < u < 308 and 12 < v < 308:
            column, row = int(u), int(v)
            around = picture[row - 12 : row + 13, column - 12 : column + 13].astype(float)
            found.append(picture[row - 1 : row + 2, column - 1 : column + 2].mean() - np.median(around))
    assert len(found) >= 5
    assert np.mean(np.array(found) > 40.0) > 0.7  # the rest hide under the steel


def test_the_lens_is_a_centred_pinhole():
    lens = lens_of(Photos())
    assert (lens.focal_px, lens.principal_point_px, lens.division_lambda) == (800.0, (480.0, 300.0), 0.0)
