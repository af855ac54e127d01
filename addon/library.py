"""Where the staged pipeline and the bundled wheels lie, and how a process of its own finds them.

Takes nothing; gives the folders, the Python and the environment for ``python -m pipeline`` (and ``synth``).
Nothing here changes ``sys.path`` of Blender's own process: Blender counts that as a violation of its policy.
"""

import os
import sys
from pathlib import Path

import bpy

from pipeline.core.errors import StageError


def library_path() -> tuple[Path, ...]:
    """The folders a process needs on its path, first first.

    Returns:
        The extension's folder, which holds ``pipeline`` and ``synth``, and the folder into which Blender
        unpacks the wheels of all extensions.  Blender's own packages (numpy) belong to its Python.
    """
    unpacked = Path(
        bpy.utils.user_resource("EXTENSIONS"),
        ".local",
        "lib",
        "python{}.{}".format(*sys.version_info[:2]),
        "site-packages",
    )
    return Path(__file__).resolve().parent, unpacked


def python_executable() -> Path:
    """The Python program that belongs to this Blender.

    Raises:
        StageError: there is none, so nothing can be reconstructed from within this Blender.
    """
    version = "{}.{}".format(*sys.version_info[:2])
    names = (f"python{version}", "python3", "python", "python.exe")
    prefixes = (Path(sys.prefix), Path(sys.base_prefix))
    candidates = [
        Path(sys.executable or os.devnull),
        *(folder / name for prefix in prefixes for folder in (prefix / "bin", prefix) for name in names),
    ]
    for path in candidates:
        # in some builds sys.executable is Blender itself
        if path.stem.lower().startswith("python") and path.is_file():
            return path
    raise StageError(
        "run",
        f"Blender's own Python {version} was not found in {sys.prefix}",
        "install Blender from blender.org, or the package python3 of your distribution",
    )


def environment() -> dict[str, str]:
    """The environment of a process that runs ``python_executable()``."""
    own = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
    own["PYTHONPATH"] = os.pathsep.join(map(str, library_path()))
    # neither the current folder nor the person's own packages may stand before what was installed
    own["PYTHONSAFEPATH"] = "1"
    own["PYTHONNOUSERSITE"] = "1"
    own["PYTHONUTF8"] = "1"
    # an extension must not write into its own folder; compiled modules go where Blender lets it write
    own["PYTHONPYCACHEPREFIX"] = bpy.utils.extension_path_user(__package__, path="pycache", create=True)
    return own
