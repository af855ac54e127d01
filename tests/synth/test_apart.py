"""A Blender of our own keeps out of a person's user folder."""

import os
import subprocess
import sys
from pathlib import Path

from tests.command import ROOT

CALL = "import os; from synth.apart import keep_apart; keep_apart(); "
SHOW = "f = os.environ['BLENDER_USER_RESOURCES']; print(f, os.path.isdir(f))"


def folder_in(environment):
    """What a fresh process has after the call, and whether the folder is there."""
    words = [sys.executable, "-c", CALL + SHOW]
    done = subprocess.run(words, env=environment, cwd=ROOT, capture_output=True, text=True, check=True)
    name, there = done.stdout.split()
    return Path(name), there == "True"


def test_a_process_gets_a_folder_that_goes_with_it():
    bare = {key: value for key, value in os.environ.items() if key != "BLENDER_USER_RESOURCES"}
    (first, there), (second, _) = folder_in(bare), folder_in(bare)
    assert there
    assert first != second
    assert not first.exists()


def test_a_folder_that_is_named_is_kept(tmp_path):
    assert folder_in({**os.environ, "BLENDER_USER_RESOURCES": str(tmp_path)}) == (tmp_path, True)
    assert tmp_path.exists()
