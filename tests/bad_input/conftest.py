"""The good survey, and what it means to be refused."""

import shutil

import pytest

from tests.bad_input import cylinder
from tests.command import pipeline


@pytest.fixture(scope="session")
def good_survey(tmp_path_factory):
    return cylinder.write_survey(tmp_path_factory.mktemp("tiny")).parent


@pytest.fixture
def survey(good_survey, tmp_path):
    """A good survey of the test's own to spoil: the folder that holds survey.toml."""
    return shutil.copytree(good_survey, tmp_path / "survey")


@pytest.fixture
def refused(survey, tmp_path):
    """Run the survey: it must be refused in one sentence, leaving nothing half done; gives the sentence."""

    def run(*words, out=None, before="frames", **limits):
        out = out or tmp_path / "run"
        toml = survey / "survey.toml"
        done = pipeline("run", toml, "--out", out, "--events", "none", *words, **limits)
        assert_refused(done)
        if before == "frames":
            assert not out.is_dir(), sorted(out.rglob("*"))
        else:
            assert_nothing_half_done(out)
        return done.stderr

    return run


def assert_refused(done):
    assert done.code == 2, (done.code, done.stderr[-2000:])
    assert done.stdout == ""
    lines = done.stderr.splitlines()
    assert len(lines) == 1, done.stderr[-2000:]
    assert lines[0].startswith("error: ")
    assert "; " in lines[0]  # what is wrong; what to do
    assert lines[0].endswith(".")


def assert_nothing_half_done(out):
    files = [path for path in out.rglob("*") if path.is_file()]
    assert [path for path in files if ".part" in path.name] == []
    products = {path.stem: path.suffix for path in files if path.parent.name == "products"}
    assert [p for p in files if p.suffix == ".npz" and not p.with_suffix(".stamp").exists()] == []
    assert not (out / "report.json").exists(), products
