"""The wheel of a platform and a Python is chosen as pip does, and only if its hash is pinned."""

import subprocess
from hashlib import sha256
from pathlib import Path

import pytest

from tools.extension import wheels
from tools.extension.errors import ExtensionError
from tools.extension.packages import IN_BLENDER, Package, bundled, locked
from tools.extension.wheels import PLATFORMS, PYTHONS, Target, collect, pick

ROOT = Path(__file__).parents[3]
LINUX = Target(platform="linux-x64", python=(3, 13))
TAGS = {
    "new linux": "cp313-cp313-manylinux_2_28_x86_64",
    "old linux": "cp313-cp313-manylinux2014_x86_64.manylinux_2_17_x86_64",
    "too new linux": "cp313-cp313-manylinux_2_34_x86_64",
    "next python": "cp314-cp314-manylinux_2_28_x86_64",
    "stable": "cp39-abi3-manylinux_2_28_x86_64",
    "pure": "py3-none-any",
    "windows": "cp313-cp313-win_amd64",
    "mac": "cp313-cp313-macosx_11_0_arm64",
    "both macs": "cp313-cp313-macosx_10_13_universal2",
    "intel mac": "cp313-cp313-macosx_11_0_x86_64",
}


@pytest.fixture
def store(tmp_path):
    """Makes wheels of one package, all with the same content, and gives the package."""

    def make(*kinds):
        for kind in kinds:
            (tmp_path / f"some_thing-1.2-{TAGS[kind]}.whl").write_bytes(b"wheel")
        return Package(name="some-thing", version="1.2", sha256=frozenset({sha256(b"wheel").hexdigest()}))

    return make


@pytest.mark.parametrize(
    ("target", "best"),
    [
        (LINUX, "new linux"),
        (Target(platform="linux-x64", python=(3, 14)), "next python"),
        (Target(platform="windows-x64", python=(3, 13)), "windows"),
        (Target(platform="windows-x64", python=(3, 14)), "pure"),
        (Target(platform="macos-arm64", python=(3, 13)), "mac"),
    ],
    ids=str,
)
def test_the_best_wheel_of_each_target(store, tmp_path, target, best):
    package = store(*TAGS)
    assert pick(package, target, tmp_path).name == f"some_thing-1.2-{TAGS[best]}.whl"


def test_next_best_in_turn(store, tmp_path):
    order = ["new linux", "old linux", "stable", "pure"]
    package = store(*TAGS)
    for kind in order:
        found = pick(package, LINUX, tmp_path)
        assert found.name == f"some_thing-1.2-{TAGS[kind]}.whl"
        found.unlink()
    assert pick(package, LINUX, tmp_path) is None


def test_universal_wheels_serve_a_mac(store, tmp_path):
    package = store("both macs", "intel mac")
    assert "universal2" in pick(package, Target(platform="macos-arm64", python=(3, 13)), tmp_path).name


def test_a_wheel_with_another_hash_is_not_taken(store, tmp_path):
    package = store("pure")
    (tmp_path / f"some_thing-1.2-{TAGS['pure']}.whl").write_bytes(b"whee1")
    assert pick(package, LINUX, tmp_path) is None


def test_another_version_is_not_taken(store, tmp_path):
    package = store("pure")
    assert pick(Package(name="some-thing", version="1.3", sha256=package.sha256), LINUX, tmp_path) is None


def test_what_is_in_the_cache_is_not_fetched(store, tmp_path, monkeypatch):
    monkeypatch.setattr(subprocess, "run", None)
    assert len(collect([store("pure")], LINUX, tmp_path)) == 1


def test_a_missing_wheel_is_named_with_its_target(store, tmp_path, monkeypatch):
    package = store("windows")
    said = "noise\nERROR: No matching distribution found for some-thing==1.2\n"
    failed = subprocess.CompletedProcess([], 1, "", said)
    monkeypatch.setattr(wheels.subprocess, "run", lambda *words, **more: failed)
    with pytest.raises(ExtensionError) as problem:
        collect([package], LINUX, tmp_path)
    assert str(problem.value) == (
        "some-thing 1.2 could not be fetched for linux-x64 with Python 3.13 (the index has no such wheel, or "
        "cannot be reached); pip says: ERROR: No matching distribution found for some-thing==1.2"
    )
    assert [path.suffix for path in tmp_path.iterdir()] == [".whl"]


def test_an_index_that_gives_something_else_is_noticed(store, tmp_path, monkeypatch):
    package = store("windows")
    monkeypatch.setattr(
        wheels.subprocess, "run", lambda *words, **more: subprocess.CompletedProcess([], 0, "", "")
    )
    with pytest.raises(
        ExtensionError, match=r"gave no wheel of some-thing 1\.2 for linux-x64 with Python 3\.13"
    ):
        collect([package], LINUX, tmp_path)


def test_the_extension_brings_what_it_imports_and_blender_lacks():
    names = {package.name for package in bundled(ROOT)}
    direct = {
        "pycolmap",
        "opencv-python-headless",
        "scipy",
        "matplotlib",
        "pillow",
        "trimesh",
        "av",
        "openexr",
    }
    assert direct <= names
    assert {"contourpy", "kiwisolver", "pyparsing", "python-dateutil", "tzdata"} <= names  # of Matplotlib
    assert names.isdisjoint(IN_BLENDER | {"pytest", "mypy", "ruff"})


def test_versions_are_those_that_the_tests_run_on():
    pins = locked(ROOT)
    assert all(pins[package.name] == package and package.sha256 for package in bundled(ROOT))
    assert len(pins["scipy"].sha256) > 10  # of every platform, not only of this one


def test_blender_5_2_is_served_on_three_systems():
    assert set(PLATFORMS) == {"linux-x64", "windows-x64", "macos-arm64"}
    assert set(PYTHONS) == {(3, 13), (3, 14)}
