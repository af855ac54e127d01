"""The asset library, which builds itself anew when its sources have changed.

Takes the project's folder; gives the folder with the .blend and the catalogue.  bpy runs in a process of its
own and is loaded nowhere here.
"""

import subprocess
import sys
from pathlib import Path

from tools.extension.errors import ExtensionError


def build_assets(root: Path, folder: Path) -> Path:
    """Build the library if it is not there or older than its sources.

    Args:
        root: the project's folder.
        folder: of the library.

    Returns:
        The folder.

    Raises:
        ExtensionError: the build failed.
    """
    words = [sys.executable, "-m", "blend_assets.build", str(folder)]
    done = subprocess.run(words, cwd=root, capture_output=True, text=True, check=False)
    if done.returncode:
        lines = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
        raise ExtensionError(f"'python -m blend_assets.build' made no asset library: {lines[-1]}")
    return folder
