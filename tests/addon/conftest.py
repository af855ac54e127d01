"""One Blender (PyPI's bpy) with the staged extension installed in it, for a pytest process of its own.

bpy shares no process with the other tests: ``pytest`` leaves this folder out, ``pytest tests/addon`` runs it.
To start quicker while working, keep Blender's user folder: ``CABLETWIN_ADDON_HOME=out/addon-home``.
"""

import importlib
import os
import shutil
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import pytest

from tests.addon.leftovers import Traces, traces
from tools.extension.build import Plan, build, this_platform, this_python
from tools.extension.staging import digest

ROOT = Path(__file__).parents[2]
MODULE = "bl_ext.user_default.cabletwin"
KEPT = 4
"""So many packages of earlier sources stay in build/; each takes 200 MB."""

# before anything imports bpy: no test may see the settings of a person's own Blender
_KEEP = os.environ.get("CABLETWIN_ADDON_HOME")
HOME = Path(_KEEP).resolve() if _KEEP else Path(tempfile.mkdtemp(prefix="cabletwin-addon-")).resolve()
HOME.mkdir(parents=True, exist_ok=True)
os.environ["BLENDER_USER_RESOURCES"] = str(HOME)
bpy = importlib.import_module("bpy")


def pytest_configure(config):
    # pytest's own traceback prints arguments, and printing what Blender has freed by then ends the process
    config.option.tbstyle = "native"


def pytest_sessionfinish():
    if not _KEEP:
        shutil.rmtree(HOME, ignore_errors=True)


@dataclass(frozen=True)
class Installed:
    """The extension as Blender has it.

    Attributes:
        module: of the add-on.
        folder: where it lies.
        package: the zip it came from.
        before: what was in Blender before it was installed.
    """

    module: ModuleType
    folder: Path
    package: Path
    before: Traces


@pytest.fixture(scope="session")
def package():
    """The zip for this platform and Python, built anew only if a source has changed."""
    store = ROOT / "build" / "extension" / "tests"
    folder = store / digest(ROOT)
    if not folder.is_dir():
        store.mkdir(parents=True, exist_ok=True)
        making = Path(tempfile.mkdtemp(dir=store))
        plan = Plan(
            platforms=(this_platform(),),
            pythons=(this_python(),),
            out=making,
            cache=ROOT / "build" / "wheels",
            assets=ROOT / "build" / "assets",
        )
        assert not build(ROOT, plan, lambda words: None).left_out
        try:
            making.rename(folder)
        except OSError:  # another process was quicker with the same
            shutil.rmtree(making)
        oldest = sorted(store.iterdir(), key=lambda path: path.stat().st_mtime, reverse=True)[KEPT:]
        for path in oldest:
            shutil.rmtree(path, ignore_errors=True)
    (zipped,) = folder.glob("*.zip")
    return zipped


@pytest.fixture(scope="session")
def installed(package):
    """The extension installed and enabled, with what was there before."""
    # reading factory settings would take the unpacked wheels away with all add-ons
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True, load_ui=False)
    before = traces()
    done = bpy.ops.extensions.package_install_files(
        filepath=str(package), repo="user_default", enable_on_install=True
    )
    assert done == {"FINISHED"}
    module = sys.modules[MODULE]
    return Installed(module, Path(module.__file__).parent, package, before)


@pytest.fixture(scope="session")
def cabletwin(installed):
    """The add-on's module, bl_ext.user_default.cabletwin."""
    return installed.module


@pytest.fixture(autouse=True)
def empty_scene(installed):
    """An empty file before every test; unlike factory settings this leaves the add-on enabled."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True, load_ui=False)
    assert MODULE in bpy.context.preferences.addons
