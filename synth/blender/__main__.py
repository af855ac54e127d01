"""Render a survey from within Blender, or under its package: ``... SPEC.toml OUT``.

For the extension.  A Blender program starts this file with ``--python`` (its words come after ``--``), the
package bpy runs it as ``python -m synth.blender``.  A Blender program does not heed PYTHONPATH: this module
does, behind what Blender brings itself.  Progress goes to stderr, one event a line; a failure is a line that
begins with ``error:``; exit codes are those of ``python -m synth``.
"""

import os
import sys

sys.path.extend(p for p in os.environ.get("PYTHONPATH", "").split(os.pathsep) if p and p not in sys.path)

import json
from dataclasses import asdict
from pathlib import Path

from pipeline.core.errors import Cancelled, StageError
from pipeline.core.events import Event
from synth.render import render_survey
from synth.spec_reader import read_spec


def main(arguments: list[str]) -> int:
    """Render; returns the exit code."""
    spec, out = arguments
    try:
        print(render_survey(read_spec(Path(spec)), Path(out), _tell))
    except StageError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except (KeyboardInterrupt, Cancelled):
        return 130
    return 0


def _tell(event: Event) -> None:
    print(json.dumps(asdict(event)), file=sys.stderr, flush=True)


if __name__ == "__main__":
    words = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    sys.exit(main(words))
