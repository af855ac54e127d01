"""The manifest of a build: the project's template with the version, the platforms and the wheels."""

import tomllib
from collections.abc import Sequence
from pathlib import Path

from tools.extension.errors import ExtensionError

NAME = "blender_manifest.toml"
IDENTIFIER = "cabletwin"


def write_manifest(root: Path, folder: Path, platforms: Sequence[str], wheels: Sequence[str]) -> None:
    """Write the manifest into a staged extension.

    Args:
        root: the project's folder, with the template in addon/ and the version in pyproject.toml.
        folder: the staged extension.
        platforms: Blender's names of the platforms of this build.
        wheels: names of the files in the extension's folder ``wheels``.

    Raises:
        ExtensionError: the template says what only a build can know.
    """
    template = (root / "addon" / NAME).read_text(encoding="utf-8")
    if taken := {"version", "platforms", "wheels"} & tomllib.loads(template).keys():
        raise ExtensionError(
            f"addon/{NAME} must leave {', '.join(sorted(taken))} to the build: delete it there"
        )
    # keys of the whole must stand before the first table
    head, mark, tables = template.partition("\n[")
    lines = [
        f'version = "{version(root)}"',
        f"platforms = {_array(platforms)}",
        f"wheels = {_array([f'./wheels/{name}' for name in wheels])}",
    ]
    (folder / NAME).write_text(
        head.rstrip() + "\n" + "\n".join(lines) + "\n" + mark + tables, encoding="utf-8", newline="\n"
    )


def version(root: Path) -> str:
    """The project's version."""
    project: dict[str, str] = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return project["version"]


def _array(values: Sequence[str]) -> str:
    return "[\n" + "".join(f'  "{value}",\n' for value in values) + "]"
