"""``python -m tests.ui --blender PROGRAM``: install the extension in a Blender, walk the flow.

Pictures of each step come to out/ui.  The program may be any Blender 5.2 with a screen, or a script that
takes Blender's arguments and gives it one.
"""

import argparse
import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
OUT = ROOT / "out" / "ui"
SPEC = ROOT / "specs" / "gate" / "paper.toml"
WINDOW = (1600, 1000)


def main() -> int:
    """Prepare, walk, tell."""
    parser = argparse.ArgumentParser(prog="python -m tests.ui", description="Walk the flow in a real window.")
    parser.add_argument("--blender", default=shutil.which("blender") or "", help="default: blender on PATH")
    parser.add_argument("--walk", default="walk", help="module of tests/ui with the steps (default walk)")
    chosen = parser.parse_args()
    if not chosen.blender:
        print("error: no Blender on PATH; name one: make test-ui BLENDER=/path/to/blender", file=sys.stderr)
        return 1
    os.environ["BLENDER_USER_RESOURCES"] = str(ROOT / "build" / "ui" / "user")
    shutil.rmtree(ROOT / "build" / "ui" / "user", ignore_errors=True)
    (ROOT / "build" / "ui" / "user").mkdir(parents=True)
    _call(sys.executable, "-m", "tools.extension", "install", "--blender", chosen.blender)
    survey = _survey()
    window = ("--window-geometry", "0", "0", *map(str, WINDOW))
    words = (
        "--enable-event-simulate",
        "--python-exit-code",
        "1",
        "--python",
        ROOT / "tests/ui" / f"{chosen.walk}.py",
    )
    os.environ["BLENDER_GUI_SIZE"] = "{}x{}".format(*WINDOW)
    walked = subprocess.run(
        [chosen.blender, "--gpu-backend", "opengl", "-noaudio", *window, *words, "--", survey, OUT]
    )
    print(f"pictures in {OUT.relative_to(ROOT)}" if walked.returncode == 0 else "error: the walk failed")
    return walked.returncode


def _survey() -> Path:
    """A copy of a small rendered survey, which the walk may write to."""
    rendered = Path(os.environ.get("CABLETWIN_TEST_SURVEY", ROOT / "out" / "ui-survey"))
    if not (rendered / "survey.toml").exists():
        _call(sys.executable, "-m", "synth", "render", SPEC, rendered)
    shutil.rmtree(OUT, ignore_errors=True)
    OUT.mkdir(parents=True)
    copy = OUT / "survey"
    copy.mkdir()
    for file in rendered.iterdir():
        if file.is_file():
            shutil.copy(file, copy)
    return copy


def _call(*words: object) -> None:
    subprocess.run([str(w) for w in words], check=True, cwd=ROOT)


if __name__ == "__main__":
    sys.exit(main())
