"""What the extension must bring: the project's packages, what those need, less what Blender has.

Takes pyproject.toml for the names and requirements.lock for versions and hashes, so that Blender runs what
the tests ran.  What a package needs is read from the project's own environment.
"""

import re
import tomllib
from dataclasses import dataclass
from importlib.metadata import requires
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tools.extension.errors import ExtensionError

IN_BLENDER = frozenset({"bpy", "numpy"})
"""Blender is the one and brings the other; a second numpy beside Blender's would be loaded by half of it."""

_PINNED = re.compile(r"^([\w.-]+)==(\S+)")
_HASH = re.compile(r"--hash=sha256:([0-9a-f]{64})")


@dataclass(frozen=True, kw_only=True)
class Package:
    """One package to bring.

    Attributes:
        name: canonical, such as ``opencv-python-headless``.
        version: exact.
        sha256: of every file that the index has of this version.
    """

    name: str
    version: str
    sha256: frozenset[str]

    def pinned(self) -> str:
        """The line of a requirements file."""
        return " \\\n    ".join(
            [f"{self.name}=={self.version}", *(f"--hash=sha256:{h}" for h in sorted(self.sha256))]
        )


def bundled(root: Path) -> tuple[Package, ...]:
    """The packages to bring, by name.

    Raises:
        ExtensionError: a package is not in requirements.lock.
    """
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    open_ = [Requirement(line) for line in (*project["dependencies"], *extras["synth"], *extras["steel"])]
    names: set[str] = set()
    while open_:
        wanted = open_.pop()
        name = canonicalize_name(wanted.name)
        if name not in names | IN_BLENDER:
            names.add(name)
            open_.extend(_needs(name, wanted.extras))
    pins = locked(root)
    if missing := sorted(names - pins.keys()):
        raise ExtensionError(f"requirements.lock does not pin {', '.join(missing)}: compile it anew")
    return tuple(pins[name] for name in sorted(names))


def _needs(name: str, extras: set[str]) -> list[Requirement]:
    """What a package needs with these of its extras; platforms do not differ in it."""
    found = [Requirement(line) for line in requires(name) or ()]
    return [
        need
        for need in found
        if need.marker is None or any(need.marker.evaluate({"extra": extra}) for extra in ("", *extras))
    ]


def locked(root: Path) -> dict[str, Package]:
    """Everything that requirements.lock pins, by canonical name."""
    found: dict[str, Package] = {}
    for entry in re.split(r"\n(?=\S)", (root / "requirements.lock").read_text(encoding="utf-8")):
        if pin := _PINNED.match(entry):
            name = canonicalize_name(pin[1])
            found[name] = Package(name=name, version=pin[2], sha256=frozenset(_HASH.findall(entry)))
    return found
