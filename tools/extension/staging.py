"""The extension's folder: the add-on at its root, the library, the renderer and the assets beside it.

Takes the project's folder; leaves out tests, caches, the wheels and the manifest.
"""

import hashlib
import shutil
from pathlib import Path, PurePosixPath

from tools.extension.errors import ExtensionError
from tools.extension.imports import LIBRARY, make_relative

ASSETS = {".blend", ".txt", ".png", ".webp"}
"""Files of the built asset library that the extension takes."""

_SKIPPED = {"__pycache__", "tests"}
_MANIFEST = "blender_manifest.toml"


def files(root: Path) -> dict[PurePosixPath, Path]:
    """Every file of the extension but the assets: its place in there, and where it lies in the project.

    Raises:
        ExtensionError: a part of the project is not there.
    """
    found = {PurePosixPath("LICENSE"): root / "LICENSE"}
    for folder, place in (("addon", ""), (LIBRARY, LIBRARY), ("synth", "synth")):
        for path in _below(root / folder):
            found[PurePosixPath(place, path.relative_to(root / folder).as_posix())] = path
    found.pop(PurePosixPath(_MANIFEST), None)
    missing = [name for name in ("__init__.py", f"{LIBRARY}/__init__.py") if PurePosixPath(name) not in found]
    if missing or not (root / "LICENSE").is_file():
        raise ExtensionError(f"{root} is not the project's folder: {missing or 'LICENSE'} is missing")
    return found


def stage(root: Path, folder: Path, assets: Path) -> None:
    """Fill an empty folder with the extension, imports of the library made relative.

    Args:
        root: the project's folder.
        folder: to fill; what lies there is deleted.
        assets: the built asset library.

    Raises:
        ExtensionError: a part of the project is not there, or an import has no relative form.
    """
    shutil.rmtree(folder, ignore_errors=True)
    for place, path in files(root).items():
        target = folder / place
        target.parent.mkdir(parents=True, exist_ok=True)
        if path.suffix == ".py" and place.parts[0] != "synth":
            text = make_relative(path.read_text(encoding="utf-8"), place)
            target.write_text(text, encoding="utf-8", newline="\n")
        else:
            shutil.copyfile(path, target)
    for path in (path for path in _below(assets) if path.suffix in ASSETS):
        target = folder / "assets" / path.relative_to(assets)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, target)


def digest(root: Path) -> str:
    """What the extension is made of, in short: changes with any file, with the lock, and with this tool."""
    total = hashlib.sha256()
    others = [root / "requirements.lock", root / "pyproject.toml", root / "addon" / _MANIFEST]
    makers = [*_below(root / "tools" / "extension"), *_below(root / "blend_assets")]
    for path in [*files(root).values(), *others, *makers]:
        total.update(f"{path.relative_to(root).as_posix()}\0".encode())
        total.update(hashlib.sha256(path.read_bytes()).digest())
    return total.hexdigest()[:16]


def _below(folder: Path) -> list[Path]:
    return sorted(
        path
        for path in folder.rglob("*")
        if path.is_file() and _SKIPPED.isdisjoint(path.relative_to(folder).parts) and path.name[0] != "."
    )
