"""Sections are cut from what was measured and kept, square to the axis, and tell the angle that was seen."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.cable.ring import Alignment
from tests.cable import pieces


def test_closed_holes_are_not_measured():
    """A hole was closed 3 mm too high: that is nobody's measurement."""
    blocks, crops = pieces.ring()
    surface = blocks[0].surface
    hole = np.zeros_like(surface.measured)
    hole[85:115, 40:100] = True
    radius = np.where(hole, surface.radius_m + 0.003, surface.radius_m).astype(np.float32)
    spoiled = replace(blocks[0], surface=replace(surface, radius_m=radius, measured=~hole))
    section = pieces.measure((spoiled, *blocks[1:]), crops).sections[1]
    assert section.diameter_mm == pytest.approx(110.0, abs=0.01)


def test_cropped_cells_are_not_measured():
    blocks, crops = pieces.ring()
    radius = blocks[0].surface.radius_m.copy()
    keep = crops[0].keep.copy()
    radius[:, :30] += 0.003
    keep[:, :30] = False
    blocks = (replace(blocks[0], surface=replace(blocks[0].surface, radius_m=radius), keep=keep), *blocks[1:])
    crops = (replace(crops[0], keep=keep), *crops[1:])
    assert pieces.measure(blocks, crops).sections[1].diameter_mm == pytest.approx(110.0, abs=0.01)


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
