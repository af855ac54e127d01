"""One rendered survey and one finished run of it for the whole test session."""

import json
import os
import shutil
import signal
from dataclasses import dataclass
from pathlib import Path

import pytest

from synth.apart import keep_apart
from tests.command import ROOT, Command, pipeline, synth

RENDERED = "CABLETWIN_TEST_SURVEY"
"""Environment variable: a folder that ``python -m synth render specs/gate/paper.toml`` has filled already."""

# no test may clear the extensions of a person's own Blender
keep_apart()

# a shell that starts us in the background has Ctrl-C ignored, by us and by every command a test interrupts
signal.signal(signal.SIGINT, signal.default_int_handler)


@dataclass(frozen=True)
class Run:
    """A run folder and the command that filled it."""

    folder: Path
    command: Command

    @property
    def report(self):
        return json.loads((self.folder / "report.json").read_text())


@pytest.fixture(scope="session")
def rendered(tmp_path_factory):
    """The folder of the gate's easy survey: four videos, survey.toml, truth.json."""
    if os.environ.get(RENDERED):
        return Path(os.environ[RENDERED]).resolve()
    folder = tmp_path_factory.mktemp("rendered")
    done = synth("render", ROOT / "specs" / "gate" / "paper.toml", folder, "--quiet")
    assert done.code == 0, done.stderr
    return folder


@pytest.fixture(scope="session")
def finished(rendered, tmp_path_factory):
    """That survey reconstructed, compared with its truth.  Read only: change a copy."""
    folder = tmp_path_factory.mktemp("finished") / "run"
    words = (rendered / "survey.toml", "--out", folder, "--truth", rendered / "truth.json")
    done = pipeline("run", *words, "--events", "json")
    assert done.code == 0, done.stderr[-2000:]
    return Run(folder, done)


@pytest.fixture
def copied(finished, tmp_path):
    """The finished run in a folder of the test's own."""
    return Path(shutil.copytree(finished.folder, tmp_path / "run"))
