"""Marks that a person names join the blocks instead of those found automatically (``--pairs``)."""

import json

import numpy as np
import pytest

from tests.bad_input.conftest import assert_refused
from tests.command import pipeline

HEAD = "block_a,x_a,y_a,z_a,block_b,x_b,y_b,z_b"
NEIGHBOURS = (
    ("Block1", "Block2", 45),
    ("Block2", "Block3", 135),
    ("Block3", "Block4", 225),
    ("Block4", "Block1", 315),
)


def write_pairs(path, unit_m=1.0):
    """One mark half way between each two neighbours, at y = 0.13 m on a cable of 111 mm."""
    lines = [HEAD]
    for first, second, azimuth_deg in NEIGHBOURS:
        a = np.radians(azimuth_deg)
        place = np.array([0.0555 * np.cos(a), 0.13, -0.0555 * np.sin(a)]) / unit_m
        words = ",".join(f"{value:.6f}" for value in place)
        lines.append(f"{first},{words},{second},{words}")
    path.write_text("\n".join(lines) + "\n")
    return path


def test_they_are_held_together_and_the_cable_keeps_its_diameters(rendered, copied, tmp_path):
    words = ("--truth", rendered / "truth.json", "--pairs", write_pairs(tmp_path / "pairs.csv"))
    done = pipeline("run", rendered / "survey.toml", "--out", copied, *words, "--events", "none")
    assert done.code == 0, done.stderr
    report = json.loads((copied / "report.json").read_text())
    assert 1e-4 < report["truth"]["mean_absolute_error_mm"] < 0.15
    joints = report["mosaic"]["joints"]
    found = {frozenset((joint["first"], joint["second"])) for joint in joints}
    assert found == {frozenset(names) for *names, _ in NEIGHBOURS}
    assert {joint["pairs"] for joint in joints} == {1}
    assert max(joint["residual_mm"] for joint in joints) == pytest.approx(0, abs=0.01)


def test_millimetres_for_metres_are_refused(rendered, copied, tmp_path):
    pairs = write_pairs(tmp_path / "pairs.csv", unit_m=0.001)
    words = ("--out", copied, "--pairs", pairs, "--events", "none")
    done = pipeline("run", rendered / "survey.toml", *words)
    assert_refused(done)
    assert str(pairs) in done.stderr
    assert "of Block1" in done.stderr
    assert "off its surface" in done.stderr
    assert "blocks/Block1/mesh.ply and give it in metres" in done.stderr
