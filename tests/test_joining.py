"""Blocks of an opened run are joined by hand as the stages do it, and a ring that gapes is closed."""

from dataclasses import fields, replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.cable.mosaic import MosaicOptions, mosaic_blocks
from pipeline.cable.pairs import HandPair, group_pairs
from pipeline.cable.ring import align
from pipeline.core.errors import StageError
from pipeline.joining import closing_pairs, join_run
from pipeline.opened import OpenedBlock, OpenedRun
from pipeline.report.block_model import cable_from_block
from tests.cable import pieces, scene


@pytest.fixture(scope="module")
def joined_blocks():
    return pieces.ring(pieces.ASTRAY, texture=scene.Texture(seed=3), noise_mm=0.03)


@pytest.fixture(scope="module")
def run(joined_blocks):
    """The run that these blocks would be opened from; what joining does not look at is left out."""
    known = {
        "folder": Path("run"),
        "options": SimpleNamespace(mosaic=MosaicOptions()),
        "blocks": tuple(opened(b, c) for b, c in zip(*joined_blocks, strict=True)),
    }
    return OpenedRun(**{**dict.fromkeys(f.name for f in fields(OpenedRun)), **known})


def opened(block, crop):
    datum = SimpleNamespace(
        datum_origin=block.datum_origin, datum_information=block.datum_information, poses=1.0, lens=2.0
    )
    known = {
        "frames": SimpleNamespace(block=block.name),
        "orientation": datum,
        "surface": block.surface,
        "picture": block.picture,
        "crop": crop,
        "cable_from_block": np.eye(4),
    }
    return OpenedBlock(**{**dict.fromkeys(f.name for f in fields(OpenedBlock)), **known})


def on_surface(block, azimuth_deg, y_m):
    surface = block.surface
    column = np.abs(np.rad2deg(surface.azimuth) - azimuth_deg).argmin()
    row = np.abs(surface.y_m - y_m).argmin()
    return tuple(surface.points()[row, column])


@pytest.fixture(scope="module")
def pairs(joined_blocks):
    """Clumsily picked: the partner lies a millimetre on along the cable."""
    blocks = joined_blocks[0]
    places = ((0, 1, 45.0), (2, 1, 135.0), (2, 3, 225.0))
    return [
        HandPair(
            block_a=a,
            block_b=b,
            point_a=on_surface(blocks[a], azimuth, 0.05),
            point_b=on_surface(blocks[b], azimuth, 0.051),
        )
        for a, b, azimuth in places
    ]


def test_places_are_those_of_the_stages(run, joined_blocks, pairs):
    blocks = joined_blocks[0]
    mosaic = mosaic_blocks(blocks, group_pairs(pairs), None, MosaicOptions(), scene.silent)
    expected = [cable_from_block(n, mosaic, align(blocks, mosaic)) for n in range(4)]
    found = join_run(run, pairs)
    np.testing.assert_array_equal(found.cable_from_block, expected)


def test_residuals_come_in_the_order_of_the_pairs(run, pairs):
    first = pairs[0]
    exchanged = HandPair(block_a=1, block_b=0, point_a=first.point_a, point_b=first.point_b)
    more = [*pairs, exchanged]
    found = np.linalg.norm(join_run(run, more).residuals_mm, axis=1)
    assert found[:3].max() < 0.01
    # the first is held together: its points on each other's blocks lie twice their distance apart
    apart_mm = 1000 * np.linalg.norm(np.subtract(first.point_a, first.point_b))
    assert found[3] == pytest.approx(2 * apart_mm, rel=0.01)


def test_the_ring_is_closed_where_no_pair_was_picked(run, pairs):
    added = closing_pairs(run, pairs)
    assert [(p.block_a, p.block_b) for p in added] == [(0, 3)]
    joins = join_run(run, [*pairs, *added]).mosaic.joins
    assert [(j.first, j.second) for j in joins] == [(0, 1), (0, 3), (1, 2), (2, 3)]
    assert closing_pairs(run, [*pairs, *added]) == ()


def test_closing_pairs_lie_on_the_same_mark(run):
    joined = join_run(run, closing_pairs(run, ()))
    assert joined.residuals_mm.shape == (4, 3)
    radius_mm = 1000 * np.array([np.hypot(*m[[0, 2], 3]) for m in joined.cable_from_block])
    assert radius_mm.max() < 2


def test_no_pairs_are_refused(run):
    with pytest.raises(StageError, match="there are no pairs; pick one for each two neighbours"):
        join_run(run, ())


def test_a_block_without_its_crop_is_refused(run, pairs):
    bare = replace(run, blocks=(replace(run.blocks[0], crop=None),))
    with pytest.raises(StageError, match="Block0 is not cropped yet; run the reconstruction first"):
        join_run(bare, pairs)


def test_pairs_picked_before_a_block_was_adjusted_anew_are_refused(run, pairs):
    added = closing_pairs(run, ())
    assert join_run(run, added).mosaic.joins  # of this adjustment
    again = replace(
        run.blocks[1], orientation=SimpleNamespace(**{**vars(run.blocks[1].orientation), "poses": 1.5})
    )
    moved = replace(run, blocks=(run.blocks[0], again, *run.blocks[2:]))
    with pytest.raises(
        StageError, match=r"pair 1 of pairs.csv was picked on Block90 before it was adjusted anew"
    ):
        join_run(moved, added)
    assert join_run(moved, pairs).mosaic.joins  # without a stamp nothing is known
