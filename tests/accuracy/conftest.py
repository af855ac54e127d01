"""What several tests look at: the finished run's report, the truth, and a run with the lens uncorrected."""

import json

import pytest

from tests.command import pipeline


@pytest.fixture(scope="session")
def report(finished):
    return finished.report


@pytest.fixture(scope="session")
def truth(rendered):
    return json.loads((rendered / "truth.json").read_text())


@pytest.fixture(scope="session")
def bent(rendered, tmp_path_factory):
    """The report of the same survey with lambda held at zero: the bent model of figures 5 and 6.

    Of fewer frames, to save time: the lens is as wrong as it would be with all of them.
    """
    folder = tmp_path_factory.mktemp("bent") / "run"
    words = ("--no-lens-correction", "--set", "frames.most_frames=8", "--events", "none")
    truth = ("--truth", rendered / "truth.json")
    done = pipeline("run", rendered / "survey.toml", "--out", folder, *truth, *words)
    assert done.code == 0, done.stderr[-2000:]
    return json.loads((folder / "report.json").read_text())


@pytest.fixture(scope="session")
def evaluation(finished, rendered, tmp_path_factory):
    """What ``evaluate`` says."""
    path = tmp_path_factory.mktemp("evaluation") / "evaluation.json"
    words = ("--truth", rendered / "truth.json", "--json", path)
    assert pipeline("evaluate", finished.folder, *words).code == 0
    return json.loads(path.read_text())
