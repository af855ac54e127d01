"""Sections are cut from what was measured and kept, square to the axis, and tell the angle that was seen."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.cable.ring import Alignment
from tests.cable import pieces


def striped(**changes):
    """One block with a stripe of 24 degrees, in the middle of its 120, that reads 3 mm too much."""
    (block, *_), (crop, *_) = pieces.ring()
    middle = block.surface.radius_m.shape[1] // 2
    stripe = np.zeros_like(block.keep)
    stripe[:, middle - 14 : middle + 15] = True
    radius = np.where(stripe, block.surface.radius_m + 0.003, block.surface.radius_m).astype(np.float32)
    measured, keep = (np.where(stripe, not changes.get(n, False), True) for n in ("closed", "cropped"))
    surface = replace(block.surface, radius_m=radius, measured=measured)
    return (replace(block, surface=surface, keep=keep),), (replace(crop, keep=keep),)


@pytest.mark.parametrize("why", ["closed", "cropped"])
def test_closed_holes_and_cropped_cells_are_not_measured(why):
    ring = pieces.join(*pieces.ring(), cell_mm=4.0, texel_mm=8.0)
    section = pieces.measure(*striped(**{why: True}), ring=ring).sections[1]
    assert section.coverage_deg == pytest.approx(120 - 24, abs=3)
    assert np.hypot(*section.points_mm.T).max() < 55.1
    assert section.diameter_mm == pytest.approx(110.0, abs=0.02)
    spoiled = pieces.measure(*striped(), ring=ring).sections[1]
    assert spoiled.coverage_deg == pytest.approx(120, abs=2)
    assert np.hypot(*spoiled.points_mm.T).max() > 57.9


@pytest.mark.parametrize(("count", "coverage_deg"), [(4, 360), (3, 300), (2, 210), (1, 120)])
@pytest.mark.parametrize("bin_deg", [1.0, 3.0])
def test_the_angle_that_was_seen_is_told(count, coverage_deg, bin_deg):
    """Neighbours overlap by 30 degrees of their 120."""
    blocks, crops = pieces.ring()
    found = pieces.measure(blocks[:count], crops[:count], bin_deg=bin_deg)
    assert found.sections[1].coverage_deg == pytest.approx(coverage_deg, abs=6 if count < 4 else 0)
    assert found.sections[1].diameter_mm == pytest.approx(110.0, abs=0.02)


def test_sections_are_cut_about_the_aligned_axis():
    """A ring that lies 5 degrees askew would show ellipses if it were cut along its own y."""
    askew = pieces.Motion((5.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    blocks, crops = pieces.ring((askew,) * 4)
    section = pieces.measure(blocks, crops).sections[1]
    assert section.max_mm - section.min_mm < 0.03
    assert section.diameter_mm == pytest.approx(110, abs=0.02)


def test_the_alignment_itself_is_taken_from_the_ring():
    blocks, crops = pieces.ring()
    shifted = replace(
        pieces.join(blocks, crops, cell_mm=4.0, texel_mm=8.0),
        alignment=Alignment(rotation=np.eye(3), translation=np.array([0.002, 0, -0.001])),
    )
    section = pieces.measure(blocks, crops, ring=shifted).sections[1]
    np.testing.assert_allclose(section.centre_mm, [2, -1], atol=0.01)
    assert section.diameter_mm == pytest.approx(110, abs=0.01)
