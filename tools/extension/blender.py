"""Blender's own tools: its packer and checker (they come with the bpy package), and an installed Blender."""

import importlib.util
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from tools.extension.errors import ExtensionError

_SAYS = "cabletwin-python"


@dataclass(frozen=True, kw_only=True)
class Blender:
    """An installed Blender.

    Attributes:
        program: the file to start.
        version: such as (5, 2).
        python: of its own Python, such as (3, 13).
    """

    program: Path
    version: tuple[int, ...]
    python: tuple[int, ...]


def extension_tool() -> Path:
    """Blender's command line for extensions, from the bpy package; bpy itself is not loaded.

    Raises:
        ExtensionError: there is no bpy.
    """
    place = importlib.util.find_spec("bpy")
    for folder in (place and place.submodule_search_locations) or ():
        for tool in Path(folder).glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py"):
            return tool
    raise ExtensionError("bpy is not installed, which brings Blender's packer: run 'make setup'")


def pack(folder: Path, out: Path) -> tuple[Path, ...]:
    """Pack a staged extension, one zip for each platform of its manifest.

    Raises:
        ExtensionError: Blender refuses it.
    """
    out.mkdir(parents=True, exist_ok=True)
    for old in out.glob("*.zip"):
        old.unlink()
    _tool("build", "--source-dir", str(folder), "--output-dir", str(out), "--split-platforms")
    return tuple(sorted(out.glob("*.zip")))


def check(path: Path) -> None:
    """Have Blender check a staged extension or a zip.

    Raises:
        ExtensionError: Blender refuses it.
    """
    _tool("validate", str(path))


def find_blender(named: str) -> Blender:
    """The Blender that a person names, or that of the command line.

    Raises:
        ExtensionError: there is none, or it does not start, or it is too old.
    """
    program = shutil.which(named or "blender")
    if not program:
        raise ExtensionError(
            f"{named or 'blender'} is no program that can be started: name yours, "
            "make install-extension BLENDER=path/to/blender"
        )
    words = f"import sys, bpy; print('{_SAYS}', *bpy.app.version[:2], *sys.version_info[:2])"
    done = _start([program, "--background", "--factory-startup", "--python-expr", words])
    found = re.search(rf"{_SAYS} (\d+) (\d+) (\d+) (\d+)", done.stdout)
    if not found:
        raise ExtensionError(f"{program} does not start as Blender: {_last(done)}")
    numbers = tuple(int(number) for number in found.groups())
    blender = Blender(
        program=Path(program), version=(numbers[0], numbers[1]), python=(numbers[2], numbers[3])
    )
    if blender.version < (5, 2):
        raise ExtensionError(f"{program} is Blender {numbers[0]}.{numbers[1]}: 5.2 or newer is needed")
    return blender


def install(blender: Blender, package: Path) -> None:
    """Install a zip into a Blender and enable it there.

    Raises:
        ExtensionError: Blender refuses it.
    """
    words = ["--command", "extension", "install-file", "--repo", "user_default", "--enable", str(package)]
    done = _start([str(blender.program), *words])
    if done.returncode:
        raise ExtensionError(f"{blender.program} did not install {package.name}: {_last(done)}")


def _tool(*words: str) -> str:
    done = _start([sys.executable, str(extension_tool()), *words])
    if done.returncode:
        raise ExtensionError(f"Blender refuses the extension: {_last(done)}")
    return done.stdout


def _start(words: list[str]) -> subprocess.CompletedProcess[str]:
    # Blender's Python must not see ours
    clean = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
    try:
        return subprocess.run(words, capture_output=True, text=True, check=False, env=clean)
    except OSError as error:
        raise ExtensionError(f"{words[0]} does not start: {error.strerror}") from error


def _last(done: subprocess.CompletedProcess[str]) -> str:
    lines = (done.stdout + done.stderr).strip().splitlines()
    first = next((place for place, line in enumerate(lines) if "rror" in line), len(lines) - 1)
    return " ".join(lines[first : first + 3]) if lines else f"exit code {done.returncode}"
