"""The order of the stages, and what is said where a stage was asked for that this survey does not need."""

from types import SimpleNamespace

import pytest

from pipeline.cable.chain import Chain
from pipeline.core.errors import StageError
from tests.cable import scene


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

    def _together(self):
        return True

    def _joint(self):
        return SimpleNamespace(value=SimpleNamespace(blocks=[SimpleNamespace(reprojection_px=0.5)] * 2))


def test_what_a_stage_gives_cause_to_say_comes_with_the_event_that_closes_it():
    events = []
    chain = Joined(None, None, None, events.append)
    chain.made = {"adjust": [SimpleNamespace(value=SimpleNamespace(reprojection_px=0.06))] * 2}
    chain.run("joint", None)
    assert [(e.stage, e.done, e.total, e.block) for e in events] == [("joint", 1, 1, "")]
    assert "up to 0.50 px, each block alone by 0.06 px" in events[0].message
