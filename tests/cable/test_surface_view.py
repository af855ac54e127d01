"""A cell of the surface is looked up where the frame really saw it, whichever way its rows were read."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.cable.surface_view import SurfaceView, SweepGrid
from pipeline.core.axis import AxisCurve
from tests.cable import scene

FRAME = 4
STRAIGHT = AxisCurve(origin_y_m=0.0, coefficients=np.zeros((2, 1)))


def grid():
    azimuth = np.radians(np.linspace(-50, 50, 21))
    return SweepGrid(axis=STRAIGHT, azimuth=azimuth, y_m=scene.STEP_M * FRAME + np.linspace(-0.04, 0.04, 9))


def turned(poses, quarter_turns):
    """The same camera, rolled about its line of sight."""
    cosine, sine = np.round(np.cos(quarter_turns * np.pi / 2)), np.round(np.sin(quarter_turns * np.pi / 2))
    roll = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]])
    return replace(poses, rotations=roll @ poses.rotations, translations=poses.translations @ roll.T)


@pytest.mark.parametrize("quarter_turns", [0, 1, 2, 3])
@pytest.mark.parametrize("readout_m", [0.0, 0.004, -0.002])
def test_a_row_is_read_where_the_robot_then_is(readout_m, quarter_turns):
    """Rows around the cable or along it; by the scene's own projection, from the centre of that moment."""
    poses = turned(scene.poses(0.0, sway_deg=0.3, sway_mm=0.5), quarter_turns)
    lens = scene.lens(scene.BARREL)
    places, view = grid(), scene.Scene(poses=poses, lens=lens)
    found = SurfaceView(lens, replace(poses, readout_m=readout_m), FRAME, places)
    radius_m = np.full((len(places.y_m), len(places.azimuth)), scene.RADIUS_M, dtype=np.float32)
    pixels = np.stack(found.pixels(radius_m), axis=-1).reshape(-1, 2) + 0.5
    points = view.points(*(g.ravel() for g in np.meshgrid(places.azimuth, places.y_m)))
    moment = pixels[:, 1] / scene.HEIGHT_PX - 0.5
    seen = points - readout_m * moment[:, None] * [0.0, 1.0, 0.0]
    np.testing.assert_allclose(view.project(FRAME, seen), pixels, atol=0.01)
    if readout_m:
        assert np.linalg.norm(view.project(FRAME, points) - pixels, axis=1).max() > 0.5
