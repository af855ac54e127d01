"""Marks of blocks with wrongly stated lenses lie where the surface has them once the ring told the lenses."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.cable.adjust import AdjustOptions, adjust_block
from pipeline.cable.closing import ClosingBlock, find_shared_marks
from pipeline.cable.closing_lenses import close_ring
from pipeline.cable.joint import JointOptions
from pipeline.cable.match import TiePoints
from tests.cable import ring_scene, scene
from tests.cable.test_closing import OPTIONS

TOO_LONG = replace(scene.lens(scene.BARREL), focal_px=1.05 * scene.FOCAL_PX, focal_sigma_px=12.0)


@pytest.fixture(scope="module")
def views():
    texture = scene.Texture(seed=3)
    swaying = ring_scene.views(sway_deg=0.2, sway_mm=0.3, wander_mm=0.3, division_lambda=scene.BARREL, seed=4)
    return [replace(v, texture=texture, block=f"Block{n}") for n, v in enumerate(swaying, start=1)]


@pytest.fixture(scope="module")
def alone(views):
    """The blocks adjusted alone through the stated lens."""
    return tuple(adjusted(block) for block in ring_scene.blocks(views, noise_px=0.05, lens=TOO_LONG))


@pytest.fixture(scope="module")
def filmed(views, alone, tmp_path_factory):
    folder = tmp_path_factory.mktemp("ring")
    return tuple(
        ClosingBlock(
            frames=view.write(folder / block.name),
            orientation=block.orientation,
            azimuth_deg=block.azimuth_deg,
        )
        for view, block in zip(views, alone, strict=True)
    )


@pytest.fixture(scope="module")
def found(filmed, alone):
    return close(filmed, alone)


def adjusted(block):
    given = block.orientation
    ties = TiePoints(
        frame=given.frame,
        point=given.point,
        pixels=given.pixels,
        starts=given.points,
        epipolar_px=np.zeros(0),
        pos_epipolar_px=np.zeros(0),
        rejected=0.0,
    )
    pos = scene.pos_priors(given.poses)
    orientation = adjust_block(block.name, ties, given.lens, pos, AdjustOptions(), scene.silent)
    return replace(block, orientation=orientation)


def close(filmed, alone, emit=scene.silent):
    return close_ring(filmed, alone, ring_scene.robot(), OPTIONS, JointOptions(), emit)


def seams_mm(found, views):
    """How much further along the girth the second camera sees each mark than the first: each pixel is carried
    to the true surface by the test's own ray."""
    turns = np.full((len(found.points), 2), np.nan)
    for block, view in enumerate(views):
        mine = found.block == block
        spots = np.empty((mine.sum(), 3))
        for frame in np.unique(found.frame[mine]):
            here = found.frame[mine] == frame
            spots[here] = view.meet(int(frame), found.pixels[mine][here])
        # about the block's own azimuth, so that no turn crosses the seam of the angles
        turn = np.angle(np.exp(1j * (np.arctan2(-spots[:, 2], spots[:, 0]) - np.pi / 2 * block)))
        for mark in np.unique(found.mark[mine]):
            side = int(found.pairs[mark, 1] == block)
            turns[mark, side] = np.median(turn[found.mark[mine] == mark]) + np.pi / 2 * block
    return 1000 * scene.RADIUS_M * np.angle(np.exp(1j * (turns[:, 1] - turns[:, 0])))


def test_through_the_stated_lens_marks_are_lost_and_scatter(filmed, found, views):
    through_stated = find_shared_marks(filmed, OPTIONS, scene.silent)
    assert len(through_stated.points) < 0.8 * len(found.points)
    assert np.std(seams_mm(through_stated, views)) > 2 * np.std(seams_mm(found, views))


def test_marks_of_every_seam_lie_where_the_surface_has_them(found, views):
    seams = [(found.pairs == pair).all(axis=1) for pair in ((0, 1), (0, 3), (1, 2), (2, 3))]
    assert min(seam.sum() for seam in seams) > 150
    off_mm = seams_mm(found, views)
    assert 0.005 < np.std(off_mm) < 0.04  # a pixel is 0.6 mm square on, 1 mm at this angle
    assert max(abs(np.mean(off_mm[seam])) for seam in seams) < 0.03


def test_known_lenses_need_no_second_look(filmed, alone):
    """The second look is what costs time."""
    trusted = tuple(
        replace(b, orientation=replace(b.orientation, lens=replace(TOO_LONG, focal_sigma_px=0.0)))
        for b in filmed
    )
    found, once = close(trusted, alone), find_shared_marks(trusted, OPTIONS, scene.silent)
    assert np.array_equal(found.pixels, once.pixels)


def test_progress_of_both_looks_is_told_as_one_stage_that_never_goes_back(filmed, alone):
    told = []
    close(filmed, alone, told.append)
    assert {event.stage for event in told} == {"closing"}
    for block in {event.block for event in told}:
        shares = [event.done / event.total for event in told if event.block == block]
        assert np.all(np.diff(shares) >= 0)
    assert 0.9 < max(event.done / event.total for event in told) < 1
