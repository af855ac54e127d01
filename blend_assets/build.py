"""Build the asset library: ``python -m blend_assets.build OUT``; see ``--help``.

Writes OUT/cabletwin.blend with the assets, and OUT/blender_assets.cats.txt.
Where these very modules have made them already, nothing is done: a stamp beside them tells.
"""

import argparse
import hashlib
import sys
from pathlib import Path

from synth.apart import keep_apart

STAMP = ".stamp"


def build(out: Path) -> Path:
    """Build the library, unless it is there and as new as the modules.

    Args:
        out: folder; made where it is missing.

    Returns:
        The folder.
    """
    stamp = out / STAMP
    if stamp.is_file() and stamp.read_text(encoding="ascii") == sources_stamp():
        return out
    keep_apart()
    from blend_assets.library import write_library  # bpy takes seconds to load

    write_library(out)
    stamp.write_text(sources_stamp(), encoding="ascii")
    return out


def sources_stamp() -> str:
    """Digest of the modules that the library is built from."""
    total = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob("*.py")):
        total.update(path.read_bytes())
    return total.hexdigest()


def main(arguments: list[str] | None = None) -> int:
    """The command line; returns the exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m blend_assets.build", description="Build CableTwin's asset library."
    )
    parser.add_argument("out", type=Path, help="folder of the library")
    sys.stdout.write(f"{build(parser.parse_args(arguments).out)}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
