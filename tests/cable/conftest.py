"""Pictures and records that several tests look at; made once."""

import pytest

from pipeline.cable.dense import DenseOptions, sweep_block
from tests.cable import scene


@pytest.fixture(scope="session")
def straight_view():
    """A swaying robot with a lens that bends nothing: its frames are undistorted as they are."""
    return scene.Scene(poses=scene.poses(sway_deg=0.15, sway_mm=0.4))


@pytest.fixture(scope="session")
def straight_frames(straight_view, tmp_path_factory):
    return straight_view.write(tmp_path_factory.mktemp("straight"))


@pytest.fixture(scope="session")
def barrel_view():
    """The same robot with a barrel lens."""
    return scene.Scene(poses=scene.poses(sway_deg=0.15, sway_mm=0.4), lens=scene.lens(scene.BARREL))


@pytest.fixture(scope="session")
def barrel_frames(barrel_view, tmp_path_factory):
    return barrel_view.write(tmp_path_factory.mktemp("barrel"))


@pytest.fixture(scope="session")
def barrel_orientation(barrel_view):
    """The barrel frames' true orientation."""
    return scene.true_orientation(barrel_view)


@pytest.fixture(scope="session")
def barrel_map(barrel_frames, barrel_orientation, tmp_path_factory):
    """The dense surface from true orientations."""
    scratch = tmp_path_factory.mktemp("scratch")
    return sweep_block(barrel_frames, barrel_orientation, 0.0, DenseOptions(), scene.silent, scratch)


@pytest.fixture
def written(tmp_path):
    """A function that writes a survey text beside its files and gives the path."""
    (tmp_path / "block1.mp4").write_bytes(b"video")
    (tmp_path / "block1_pos.csv").write_text("")

    def write(text):
        path = tmp_path / "survey.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write
