"""Python 3.13 is found wherever a machine keeps it, and a shim that fails is passed over."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / "tools" / "find_python.sh"
PYTHON = Path(sys.base_prefix) / "bin" / "python3.13"

pytestmark = pytest.mark.skipif(
    sys.platform == "win32" or not PYTHON.exists(), reason="needs a Python 3.13 in a Unix layout to link to"
)


def find(home, *folders, **variables):
    """Run the script where PATH holds nothing but these folders and two commands.

    Gives the exit code, what it found and what it said.
    """
    bare = home / "bare"
    bare.mkdir()
    for command in ("ls", "ln"):
        (bare / command).symlink_to(shutil.which(command))
    result = subprocess.run(
        [shutil.which("sh"), str(SCRIPT)],
        env={"PATH": ":".join(map(str, (*folders, bare))), "HOME": str(home), **variables},
        capture_output=True,
        text=True,
        check=False,
    )
    return result.returncode, result.stdout.strip(), result.stderr.strip()


def link(folder):
    folder.mkdir(parents=True)
    (folder / "python3.13").symlink_to(PYTHON)
    return folder / "python3.13"


def script(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)


@pytest.mark.parametrize(
    "place",
    [
        ".pyenv/versions/3.13.7/bin",
        ".local/share/mise/installs/python/3.13.0/bin",
        ".asdf/installs/python/3.13.1/bin",
        "miniforge3/envs/cable/bin",
        ".local/share/uv/python/cpython-3.13.2-linux-x86_64-gnu/bin",
    ],
)
def test_the_folders_of_version_managers_are_searched(tmp_path, place):
    expected = link(tmp_path / place)
    assert find(tmp_path) == (0, str(expected), "")


def test_a_shim_that_fails_is_passed_over(tmp_path):
    script(tmp_path / "shims" / "python3.13", "exit 127")
    good = link(tmp_path / "a folder with spaces")
    assert find(tmp_path, tmp_path / "shims", good.parent) == (0, str(good), "")


def test_another_version_under_the_right_name_is_passed_over(tmp_path):
    script(tmp_path / "shims" / "python3.13", "exit 1")
    code, found, said = find(tmp_path, tmp_path / "shims")
    assert (code, found) == (1, "")
    assert said.startswith("CableTwin needs Python 3.13 and found none; install it")
    assert "\n" not in said


def test_uv_installs_one_where_there_is_none(tmp_path):
    store = tmp_path / "store"
    store.mkdir()
    script(
        tmp_path / ".local" / "bin" / "uv",
        f"""case "$1 $2" in
        "python install") ln -s {PYTHON} {store}/python3.13 ;;
        "python find") ls {store}/python3.13 ;;
        esac""",
    )
    code, found, said = find(tmp_path)
    assert (code, found) == (0, str(store / "python3.13"))
    assert "uv installs one" in said


def test_a_python_named_by_hand_is_taken_or_refused(tmp_path):
    good = link(tmp_path / "mine")
    assert find(tmp_path, PYTHON=str(good)) == (0, str(good), "")
    (tmp_path / "other").mkdir()
    code, found, said = find(tmp_path / "other", PYTHON=str(tmp_path / "none"))
    assert (code, found) == (1, "")
    assert "is no Python 3.13 with venv" in said
