"""A steel run, as it is and with members by hand, and the second one shown in the scene."""

import bpy
import pytest

from tests.addon.shown_run import library
from tests.addon.steel import case
from tests.addon.steel.scene import job


@pytest.fixture(scope="session")
def surveyed(tmp_path_factory):
    """Lists of targets.  Read only."""
    return case.scanned(tmp_path_factory.mktemp("steel") / "survey")


@pytest.fixture(scope="session")
def run(surveyed):
    """A run without clouds.  Read only."""
    return case.registered(surveyed, surveyed.parent / "run")


@pytest.fixture
def framed(run, tmp_path):
    """The same with members by hand, in a folder of the test's own."""
    return case.with_members(run, tmp_path / "framed")


@pytest.fixture(autouse=True)
def no_job_before(cabletwin):
    """What the window manager tells of a job outlives a file."""
    library("operators.following").clear(job())
    job().kind = job().log = ""


@pytest.fixture
def shown(framed):
    assert bpy.ops.cabletwin.steel_choose(directory=str(framed)) == {"FINISHED"}
    return bpy.context.scene.cabletwin.steel
