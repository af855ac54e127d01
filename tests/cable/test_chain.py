"""The order of the stages, and what is said where a stage was asked for that this survey does not need."""

from dataclasses import replace
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from pipeline.cable.chain import Chain
from pipeline.cable.joint import JointOptions
from pipeline.cable.records import CableOptions
from pipeline.core.errors import StageError
from pipeline.core.runfolder import Product, RunFolder
from pipeline.core.vocabulary import FrameSequence, Lens
from tests.cable import scene

STATED = Lens(width_px=96, height_px=60, focal_px=70.0, principal_point_px=(48.0, 30.0), division_lambda=0.0)


def test_a_stage_that_has_no_part_in_the_run_is_refused_by_name():
    chain = Chain(None, None, None, scene.silent)
    chain.made = {"adjust": [object()], "closing": [], "joint": []}
    chain.require("adjust")
    for name in ("closing", "joint"):
        with pytest.raises(StageError) as told:
            chain.require(name)
        assert str(told.value) == (
            f"run: the stage {name} has no part in this run, whose blocks are adjusted each for itself; "
            "leave --only out, or see that there are two cameras or more of one clock, no pos and "
            "joint.together = true."
        )


class Joined(Chain):
    """Cameras that contradict each other: 0.06 px alone, 0.5 px together."""

    together = True

    def _joint(self):
        return SimpleNamespace(value=SimpleNamespace(blocks=[SimpleNamespace(reprojection_px=0.5)] * 2))


def test_what_a_stage_gives_cause_to_say_comes_with_the_event_that_closes_it():
    events = []
    chain = Joined(None, None, None, events.append)
    chain.made = {"adjust": [SimpleNamespace(value=SimpleNamespace(reprojection_px=0.06))] * 2}
    chain.run("joint", None)
    assert [(e.stage, e.done, e.total, e.block) for e in events] == [("joint", 1, 1, "")]
    assert "up to 0.50 px, each block alone by 0.06 px" in events[0].message


def test_frames_are_undistorted_with_the_adjusted_lens_and_not_the_stated_one(tmp_path):
    picture = tmp_path / "000000.png"
    cv2.imwrite(str(picture), np.full((60, 96, 3), 90, dtype=np.uint8))
    frames = FrameSequence(
        block="B", files=(picture,), source_indices=np.array([0]), source_count=1, width_px=96, height_px=60
    )
    adjusted = replace(STATED, focal_px=74.0, division_lambda=-0.05)
    ring = SimpleNamespace(blocks=[SimpleNamespace(lens=adjusted)])
    chain = Chain(None, None, RunFolder(tmp_path / "run"), scene.silent)
    chain.made = {
        "frames": [Product.of(frames)],
        "adjust": [Product(SimpleNamespace(lens=STATED), "alone")],
        "joint": [Product(ring, "together")],
    }
    flat = chain._undistort(0, SimpleNamespace(name="B"), scene.silent).value
    assert (flat.pinhole.focal_px, flat.pinhole.division_lambda) == (74.0, 0.0)
    assert cv2.imread(str(flat.frames.files[0])).shape[1] == flat.pinhole.width_px > 96


class Closed(Chain):
    """Tells what the product of *closing* would hang on."""

    def _robot(self):
        return "robot"

    def hangs_on(self, lens, **joint):
        options = CableOptions(joint=JointOptions(**joint))
        survey = SimpleNamespace(blocks=[SimpleNamespace(angle_deg=0.0, travel_in_image="right")])
        self._survey, self._options = survey, options
        self._folder = SimpleNamespace(product=lambda name, kind, make, *needs: needs)
        self.made = {"frames": ["frames"], "adjust": [Product(SimpleNamespace(lens=lens), "alone")]}
        return repr(self._closing())


def test_shared_marks_are_found_anew_where_what_told_the_lenses_changes_and_nowhere_else():
    closed = Closed(None, None, None, scene.silent)
    known, free = STATED, replace(STATED, focal_sigma_px=2.0)
    assert closed.hangs_on(known) == closed.hangs_on(known, sigma_px=0.2)
    assert closed.hangs_on(free) != closed.hangs_on(free, sigma_px=0.2)
    assert closed.hangs_on(free) == closed.hangs_on(free, surface_sigma_mm=0.1, surface_used=True)
    assert "robot" in closed.hangs_on(free)
