"""From the project's folder to the zips: stage, wheels, manifest, Blender's check, Blender's packer."""

import os
import platform
import shutil
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from tools.extension.assets import build_assets
from tools.extension.blender import check, pack
from tools.extension.errors import ExtensionError
from tools.extension.manifest import IDENTIFIER, write_manifest
from tools.extension.packages import Package, bundled
from tools.extension.staging import stage
from tools.extension.wheels import PLATFORMS, PYTHONS, Target, collect

_SYSTEMS = {"linux": "linux", "windows": "windows", "darwin": "macos"}
_MACHINES = {"x86_64": "x64", "amd64": "x64", "aarch64": "arm64", "arm64": "arm64"}


@dataclass(frozen=True, kw_only=True)
class Plan:
    """What to build.

    Attributes:
        platforms: Blender's names.
        pythons: major and minor versions.
        out: folder of the zips; the staged folder lies in there too.
        cache: folder of fetched wheels.
        assets: folder of the built asset library.
    """

    platforms: tuple[str, ...] = tuple(PLATFORMS)
    pythons: tuple[tuple[int, int], ...] = PYTHONS
    out: Path
    cache: Path
    assets: Path


@dataclass(frozen=True, kw_only=True)
class Built:
    """What came of it.

    Attributes:
        packages: the zips.
        left_out: one sentence for each platform that lacks a wheel.
    """

    packages: tuple[Path, ...]
    left_out: tuple[str, ...]


def this_platform() -> str:
    """Blender's name of the platform that this runs on.

    Raises:
        ExtensionError: the extension is not made for it.
    """
    system, machine = platform.system().lower(), platform.machine().lower()
    name = f"{_SYSTEMS.get(system, system)}-{_MACHINES.get(machine, machine)}"
    if name not in PLATFORMS:
        raise ExtensionError(f"the extension is not made for {name}, only for {', '.join(PLATFORMS)}")
    return name


def this_python() -> tuple[int, int]:
    """The Python that this runs on, which is that of the bpy package."""
    return sys.version_info[:2]


def build(root: Path, plan: Plan, tell: Callable[[str], None]) -> Built:
    """Build and check the extension.

    Args:
        root: the project's folder.
        plan: what to build.
        tell: told what is being done.

    Raises:
        ExtensionError: nothing could be built; one sentence says why.
    """
    folder = plan.out / IDENTIFIER
    tell("building the asset library, unless it is there")
    assets = build_assets(root, plan.assets)
    tell(f"staging {folder}")
    stage(root, folder, assets)
    wheels, left_out = _wheels(bundled(root), plan, tell)
    if not wheels:
        raise ExtensionError("; ".join(left_out))
    names = sorted({path.name for paths in wheels.values() for path in paths})
    (folder / "wheels").mkdir()
    for name in names:
        _link(plan.cache / name, folder / "wheels" / name)
    write_manifest(root, folder, tuple(wheels), names)
    check(folder)
    packages = pack(folder, plan.out)
    for package in packages:
        tell(f"checking {package.name}, {package.stat().st_size / 1e6:.0f} MB")
        check(package)
    return Built(packages=packages, left_out=left_out)


def _wheels(
    packages: Sequence[Package], plan: Plan, tell: Callable[[str], None]
) -> tuple[dict[str, set[Path]], tuple[str, ...]]:
    """The wheels by platform, and a sentence for each platform that cannot be served whole."""
    found: dict[str, set[Path]] = {}
    left_out = []
    for name in plan.platforms:
        targets = [Target(platform=name, python=python) for python in plan.pythons]
        tell(f"wheels for {name}")
        try:
            found[name] = {wheel for target in targets for wheel in collect(packages, target, plan.cache)}
        except ExtensionError as problem:
            left_out.append(f"{name} is left out: {problem}")
    return found, tuple(left_out)


def _link(source: Path, target: Path) -> None:
    """The same file under a second name, where the disk can do that."""
    try:
        os.link(source, target)
    except OSError:
        shutil.copyfile(source, target)
