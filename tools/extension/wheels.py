"""The wheels of a platform and a Python: found in the cache, or fetched from the index, always unmodified.

A wheel counts only if its hash is one that requirements.lock has for its package.  Nothing is built here: a
package without a wheel for a target is a problem with a sentence of its own.
"""

import hashlib
import subprocess
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from packaging.tags import Tag, compatible_tags, cpython_tags
from packaging.utils import InvalidWheelFilename, parse_wheel_filename

from tools.extension.errors import ExtensionError
from tools.extension.packages import Package

PYTHONS = ((3, 13), (3, 14))
"""The Pythons of Blender 5.2: 3.13 in the official builds, 3.14 where a distribution builds it on its own."""

PLATFORMS = {
    # Blender's name: tags of the index, best first.  Blender's own builds ask for glibc 2.28; pycolmap and
    # PyAV have wheels from macOS 14 on only
    "linux-x64": (*(f"manylinux_2_{minor}_x86_64" for minor in range(28, 16, -1)), "manylinux2014_x86_64"),
    "windows-x64": ("win_amd64",),
    "macos-arm64": tuple(
        f"macosx_{version}_{kind}"
        for version in ("14_0", "13_0", "12_0", "11_0", *(f"10_{minor}" for minor in range(16, 8, -1)))
        for kind in ("arm64", "universal2")
    ),
}


@dataclass(frozen=True, kw_only=True)
class Target:
    """One platform with one Python.

    Attributes:
        platform: Blender's name, a key of PLATFORMS.
        python: major and minor version.
    """

    platform: str
    python: tuple[int, int]

    def __str__(self) -> str:
        return f"{self.platform} with Python {self.python[0]}.{self.python[1]}"

    def tags(self) -> tuple[Tag, ...]:
        """The tags a wheel may have, best first."""
        platforms = PLATFORMS[self.platform]
        interpreter = f"cp{self.python[0]}{self.python[1]}"
        return (
            *cpython_tags(self.python, platforms=platforms),
            *compatible_tags(self.python, interpreter, platforms),
        )


def collect(packages: Iterable[Package], target: Target, folder: Path) -> tuple[Path, ...]:
    """The wheel of each package for a target; what the cache lacks is fetched.

    Args:
        packages: what is needed.
        target: for what.
        folder: the cache, shared by all targets.

    Raises:
        ExtensionError: the index has no such wheel, or cannot be reached.
    """
    folder.mkdir(parents=True, exist_ok=True)
    found = {package: pick(package, target, folder) for package in packages}
    if missing := [package for package, wheel in found.items() if wheel is None]:
        _fetch(missing, target, folder)
        found = {package: wheel or pick(package, target, folder) for package, wheel in found.items()}
    wheels = [wheel for wheel in found.values() if wheel]
    if len(wheels) < len(found):
        names = ", ".join(f"{p.name} {p.version}" for p, wheel in found.items() if wheel is None)
        raise ExtensionError(f"the index gave no wheel of {names} for {target} that fits requirements.lock")
    return tuple(wheels)


def pick(package: Package, target: Target, folder: Path) -> Path | None:
    """The best wheel of a package for a target among the files of a folder."""
    rank = {tag: place for place, tag in enumerate(target.tags())}
    best: tuple[int, Path] | None = None
    for path in folder.glob("*.whl"):
        try:
            name, version, _, tags = parse_wheel_filename(path.name)
        except InvalidWheelFilename:
            continue
        places = [rank[tag] for tag in tags if tag in rank]
        fits = (name, str(version)) == (package.name, package.version) and places
        if fits and (best is None or min(places) < best[0]) and sha256(path) in package.sha256:
            best = (min(places), path)
    return best[1] if best else None


def sha256(path: Path) -> str:
    """The hash of a file, which is read once as long as it is not touched."""
    known = path.stat()
    return _sha256(path, known.st_mtime_ns, known.st_size)


@cache
def _sha256(path: Path, changed_ns: int, size: int) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _fetch(packages: list[Package], target: Target, folder: Path) -> None:
    """Ask the index for wheels; pip compares their hashes."""
    problems = []
    for package in packages:
        wanted = folder / f".{package.name}-{target.platform}-{target.python[1]}.txt"
        wanted.write_text(package.pinned() + "\n", encoding="utf-8")
        words = ["download", "--quiet", "--no-input", "--disable-pip-version-check", "--no-deps"]
        words += [
            "--only-binary=:all:",
            "--require-hashes",
            "--dest",
            str(folder),
            "--requirement",
            str(wanted),
        ]
        words += ["--python-version", "{}.{}".format(*target.python), "--implementation", "cp"]
        for name in PLATFORMS[target.platform]:
            words += ["--platform", name]
        done = subprocess.run(
            [sys.executable, "-m", "pip", *words], capture_output=True, text=True, check=False
        )
        wanted.unlink()
        if done.returncode:
            problems.append((package, done.stderr.strip()))
    if problems:
        names = ", ".join(f"{package.name} {package.version}" for package, _ in problems)
        reason = problems[0][1].splitlines()
        raise ExtensionError(
            f"{names} could not be fetched for {target} (the index has no such wheel, or cannot be reached); "
            f"pip says: {reason[-1] if reason else 'nothing'}"
        )
