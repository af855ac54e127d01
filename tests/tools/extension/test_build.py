"""A project in small is staged and named; what is missing is told in one sentence."""

import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from tools.extension import assets, build, staging
from tools.extension.blender import check, find_blender
from tools.extension.build import Plan
from tools.extension.errors import ExtensionError
from tools.extension.manifest import write_manifest
from tools.extension.packages import Package

ROOT = Path(__file__).parents[3]


@pytest.fixture
def project(tmp_path):
    """A project with one module of each part, this one's manifest and licence."""
    root = tmp_path / "project"
    texts = {
        "addon/__init__.py": "from pipeline.core import lens\n",
        "addon/operators/lens.py": "def work():\n    from pipeline.core.lens import x\n",
        "addon/__pycache__/old.pyc": "",
        "pipeline/__init__.py": "",
        "pipeline/core/lens.py": "from pipeline.core.errors import y\n",
        "pipeline/report/page.css": "a {}",
        "synth/__init__.py": "from pipeline.core.errors import y\n",
        "synth/tests/test_x.py": "",
        "pyproject.toml": '[project]\nname = "cabletwin"\nversion = "1.2.3"\n',
        "requirements.lock": "",
    }
    for name, text in texts.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    for name in ("LICENSE", "addon/blender_manifest.toml"):
        shutil.copyfile(ROOT / name, root / name)
    (root / "assets").mkdir()
    for name in ("cabletwin.blend", "blender_assets.cats.txt", ".stamp", "cabletwin.blend1"):
        (root / "assets" / name).write_text("")
    return root


def test_the_add_on_lies_at_the_root_and_the_rest_beside_it(project, tmp_path):
    folder = tmp_path / "staged"
    staging.stage(project, folder, project / "assets")
    found = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    assert found == {
        *("LICENSE", "__init__.py", "operators/lens.py"),
        *("pipeline/__init__.py", "pipeline/core/lens.py", "pipeline/report/page.css", "synth/__init__.py"),
        *("assets/cabletwin.blend", "assets/blender_assets.cats.txt"),
    }
    assert "from ..pipeline.core.lens import x" in (folder / "operators/lens.py").read_text()
    assert (folder / "synth/__init__.py").read_text() == "from pipeline.core.errors import y\n"


def test_staging_again_leaves_nothing_of_before(project, tmp_path):
    folder = tmp_path / "staged"
    staging.stage(project, folder, project / "assets")
    (project / "addon/operators/lens.py").unlink()
    staging.stage(project, folder, project / "assets")
    assert not (folder / "operators").exists()


@pytest.mark.parametrize("name", ["addon/operators/lens.py", "synth/__init__.py", "requirements.lock"])
def test_the_digest_follows_every_source(project, name):
    before = staging.digest(project)
    assert staging.digest(project) == before
    (project / name).write_text("x = 1\n")
    assert staging.digest(project) != before


def test_a_folder_that_is_not_the_project_is_refused(tmp_path):
    with pytest.raises(ExtensionError, match="is not the project's folder"):
        staging.files(tmp_path)


def test_the_manifest_has_version_platforms_and_wheels(project, tmp_path):
    write_manifest(project, tmp_path, ["linux-x64", "windows-x64"], ["a-1-py3-none-any.whl"])
    manifest = tomllib.loads((tmp_path / "blender_manifest.toml").read_text())
    assert manifest["version"] == "1.2.3"
    assert manifest["platforms"] == ["linux-x64", "windows-x64"]
    assert manifest["wheels"] == ["./wheels/a-1-py3-none-any.whl"]
    assert set(manifest["permissions"]) == {"files"}


def test_a_template_that_knows_better_is_refused(project, tmp_path):
    template = project / "addon/blender_manifest.toml"
    template.write_text('version = "9.9.9"\n' + template.read_text())
    with pytest.raises(ExtensionError, match="must leave version to the build"):
        write_manifest(project, tmp_path, ["linux-x64"], [])


@pytest.fixture
def small(project, monkeypatch):
    """Build that project; ``lacking`` are the platforms without a wheel of "some-thing"."""
    package = Package(name="some-thing", version="1", sha256=frozenset())
    wheel = project / "cache" / "some_thing-1-py3-none-any.whl"
    wheel.parent.mkdir()
    wheel.write_bytes(b"wheel")
    monkeypatch.setattr(build, "bundled", lambda root: (package,))
    monkeypatch.setattr(build, "build_assets", lambda root, folder: folder)

    def run(*lacking):
        def collect(packages, target, folder):
            if target.platform in lacking:
                raise ExtensionError(f"no wheel of some-thing 1 for {target}")
            return (wheel,)

        monkeypatch.setattr(build, "collect", collect)
        plan = Plan(out=project / "out", cache=wheel.parent, assets=project / "assets")
        return build.build(project, plan, lambda words: None)

    return run


def test_one_zip_for_each_platform(small):
    built = small()
    assert built.left_out == ()
    assert [path.name for path in built.packages] == [
        f"cabletwin-1.2.3-{name}.zip" for name in ("linux_x64", "macos_arm64", "windows_x64")
    ]


def test_a_platform_without_a_wheel_is_told_and_the_others_are_made(small):
    small()
    built = small("windows-x64")
    assert built.left_out == (
        "windows-x64 is left out: no wheel of some-thing 1 for windows-x64 with Python 3.13",
    )
    assert [path.name for path in built.packages] == [
        f"cabletwin-1.2.3-{name}.zip" for name in ("linux_x64", "macos_arm64")
    ]


def test_without_any_wheel_there_is_no_extension(small):
    with pytest.raises(ExtensionError, match="linux-x64 is left out: no wheel of some-thing"):
        small("linux-x64", "windows-x64", "macos-arm64")


def test_blenders_reason_reaches_the_person(project, small):
    manifest = project / "addon/blender_manifest.toml"
    manifest.write_text(manifest.read_text().replace('files = "', 'files = "' + "x" * 64))
    with pytest.raises(
        ExtensionError, match=r"Blender refuses the extension: .*no longer than 64 characters"
    ):
        small()


def test_a_zip_that_is_none_is_refused(tmp_path):
    (tmp_path / "a.zip").write_text("no zip")
    with pytest.raises(ExtensionError, match="Blender refuses the extension"):
        check(tmp_path / "a.zip")


def test_assets_that_cannot_be_built_are_told(tmp_path):
    (tmp_path / "blend_assets").mkdir()
    (tmp_path / "blend_assets" / "__init__.py").touch()
    (tmp_path / "blend_assets" / "build.py").write_text('raise RuntimeError("no node of this name")')
    with pytest.raises(ExtensionError, match="made no asset library: RuntimeError: no node of this name"):
        assets.build_assets(tmp_path, tmp_path / "assets")


def test_installing_without_a_blender_says_how_to_name_one():
    words = [sys.executable, "-m", "tools.extension", "install", "--blender", "no-such-program"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 1
    assert done.stderr == (
        "error: no-such-program is no program that can be started: name yours, "
        "make install-extension BLENDER=path/to/blender\n"
    )


@pytest.mark.skipif(sys.platform == "win32", reason="a shell script stands for Blender")
@pytest.mark.parametrize(
    ("says", "sentence"),
    [
        ("echo cabletwin-python 4 5 3 11", "is Blender 4.5: 5.2 or newer is needed"),
        ("echo no display; exit 1", "does not start as Blender: no display"),
    ],
)
def test_a_blender_that_will_not_do_is_told(tmp_path, says, sentence):
    program = tmp_path / "blender"
    program.write_text(f"#!/bin/sh\n{says}\n")
    program.chmod(0o755)
    with pytest.raises(ExtensionError, match=sentence):
        find_blender(str(program))
