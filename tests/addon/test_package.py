"""The package as Blender gets it: checked, whole, unmodified, and gone without a trace when disabled."""

import ast
import subprocess
import sys
import tomllib
import types
import zipfile
from hashlib import sha256
from pathlib import Path

import addon_utils
import bpy
import pytest
from _bpy_internal.extensions import tags as blender_tags

from tests.addon.conftest import MODULE, ROOT
from tests.addon.leftovers import traces
from tools.extension.blender import check
from tools.extension.imports import absolute_imports
from tools.extension.packages import bundled


@pytest.fixture
def manifest(installed):
    return tomllib.loads((installed.folder / "blender_manifest.toml").read_text())


@pytest.fixture
def library(installed):
    return sys.modules[f"{MODULE}.library"]


def test_blender_accepts_the_package(package):
    check(package)


def test_the_manifest_says_what_the_extension_is(manifest):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert (manifest["id"], manifest["type"], manifest["version"]) == (
        "cabletwin",
        "add-on",
        project["version"],
    )
    assert manifest["license"] == ["SPDX:GPL-3.0-or-later"]
    assert set(manifest["permissions"]) == {"files"}
    assert set(manifest["tags"]) <= blender_tags.addons


def test_every_wheel_named_is_there_as_the_index_has_it(installed, manifest):
    known = {package.name: package.sha256 for package in bundled(ROOT)}
    with zipfile.ZipFile(installed.package) as archive:
        inside = {name for name in archive.namelist() if name.startswith("wheels/")}
        assert inside == {name.removeprefix("./") for name in manifest["wheels"]}
        for name in inside:
            package = Path(name).name.split("-")[0].replace("_", "-")
            assert sha256(archive.read(name)).hexdigest() in known.pop(package), name
    assert known == {}, "these packages have no wheel"


def test_no_module_imports_the_library_by_its_absolute_name(installed):
    sources = [
        p for p in installed.folder.rglob("*.py") if p.relative_to(installed.folder).parts[0] != "synth"
    ]
    assert len(sources) > 100
    found = [(path, lines) for path in sources if (lines := absolute_imports(path.read_text()))]
    assert found == []


def test_neither_tests_nor_caches_are_packed(package):
    with zipfile.ZipFile(package) as archive:
        parts = {part for name in archive.namelist() for part in name.split("/")}
    assert {"LICENSE", "pipeline", "synth"} <= parts
    assert parts.isdisjoint({"__pycache__", "tests", "tools", "build.py"})


@pytest.fixture(scope="module")
def loaded(installed):
    """Modules of a Blender of its own in which the installed extension was enabled: tests import much."""
    code = (
        "import sys, bpy, addon_utils\n"
        "addon_utils.extensions_refresh()\n"
        f"assert addon_utils.enable({MODULE!r}) is not None\n"
        "print('loaded', *sys.modules)"
    )
    # not from here, where the library lies beside the tests
    words = [sys.executable, "-P", "-c", code]
    done = subprocess.run(words, cwd=installed.folder.parent, capture_output=True, text=True, check=True)
    (line,) = [line for line in done.stdout.splitlines() if line.startswith("loaded ")]
    return set(line.split())


def test_enabling_loads_no_library_as_a_top_level_module(loaded):
    assert MODULE in loaded
    assert loaded & {"pipeline", "synth", "pycolmap"} == set()


def test_enabling_waits_for_no_heavy_package(loaded):
    assert loaded & {"scipy", "matplotlib", "trimesh", "av"} == set()


def test_blender_finds_no_violation_of_its_policy(installed):
    assert _violations() == []


def test_blender_would_find_a_violation(installed, monkeypatch):
    stray = types.ModuleType("stray")
    stray.__file__ = str(installed.folder / "pipeline" / "__init__.py")
    monkeypatch.setitem(sys.modules, "stray", stray)
    assert _violations() == ["Policy violation with top level module: stray"]


def _violations():
    addon_utils._is_first_reset()  # else Blender remembers what it found the first time
    return addon_utils._extensions_warnings_get().get(MODULE, [])


def test_ten_times_off_and_on_leaves_nothing_and_says_nothing(installed, capfd):
    enabled = traces()
    assert enabled != installed.before
    for _ in range(10):
        # the button does the same and unpacks all wheels anew, which takes seconds: see the next test
        addon_utils.disable(MODULE)
        assert traces() == installed.before
        addon_utils.enable(MODULE)
        assert traces() == enabled
    assert _complaints(capfd) == []


def test_the_button_takes_away_timers_and_wheels_too(installed, library, capfd):
    scipy = library.library_path()[1] / "scipy"
    assert scipy.is_dir()
    bpy.ops.preferences.addon_disable(module=MODULE)
    try:
        assert not scipy.exists()
        functions = [
            value
            for name, module in list(sys.modules.items())
            if name.startswith(MODULE)
            for value in vars(module).values()
            if isinstance(value, types.FunctionType)
        ]
        assert len(functions) > 10
        assert [f.__qualname__ for f in functions if bpy.app.timers.is_registered(f)] == []
    finally:
        bpy.ops.preferences.addon_enable(module=MODULE)
    assert scipy.is_dir()
    assert _complaints(capfd) == []


def _complaints(capfd):
    said = capfd.readouterr()
    return said.err.splitlines() + [
        line for line in said.out.splitlines() if "rror" in line or "arning" in line
    ]


def test_the_python_beside_blender_is_found_even_if_blender_hides_it(library, monkeypatch):
    assert library.python_executable() == Path(sys.executable)
    monkeypatch.setattr(sys, "executable", str(Path("bin", "blender")))
    assert library.python_executable().stem.startswith("python")
    assert library.python_executable().is_file()


def test_the_pipeline_runs_from_the_installed_extension_alone(library, installed):
    words = (
        "import cv2, pipeline, pycolmap, scipy as s; print(pipeline.__file__, pycolmap.__file__, s.__file__)"
    )
    done = _python(library, "-c", words)
    assert done.returncode == 0, done.stderr
    own, *wheels = done.stdout.split()
    assert Path(own).is_relative_to(installed.folder)
    assert all(Path(path).is_relative_to(library.library_path()[1]) for path in wheels)


@pytest.mark.parametrize("command", ["pipeline", "synth"])
def test_both_command_lines_answer(library, command):
    done = _python(library, "-m", command, "--help")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(f"usage: python -m {command}")


def test_a_command_line_writes_nothing_into_the_extension(library, installed):
    before = {path for path in installed.folder.rglob("*.pyc") if "pipeline" in path.parts}
    assert _python(library, "-c", "import pipeline.cable.run").returncode == 0
    assert {path for path in installed.folder.rglob("*.pyc") if "pipeline" in path.parts} == before


def _python(library, *words):
    program = str(library.python_executable())
    return subprocess.run(
        [program, *words], env=library.environment(), cwd=ROOT, capture_output=True, text=True, timeout=120
    )


def test_nothing_that_the_add_on_takes_from_the_pipeline_brings_what_ends_debians_blender():
    taken = {
        node.module
        for path in (ROOT / "addon").rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom) and not node.level and node.module.startswith("pipeline")
    }
    assert len(taken) > 20
    told = "print(sorted({'pycolmap', 'pye57', 'small_gicp'} & set(sys.modules)))"
    code = "\n".join(("import sys", *(f"import {module}" for module in sorted(taken)), told))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert done.stdout.strip() == "[]"
