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

from tests.ui import chinese

ROOT = Path(__file__).parents[2]
OUT = ROOT / "out" / "ui"
USER = ROOT / "build" / "ui" / "user"
SPEC = ROOT / "specs" / "gate" / "paper.toml"
WINDOW = (1600, 1000)


def main() -> int:
    """Prepare, walk, tell."""
    chosen = _parser().parse_args()
    if not chosen.blender:
        print("error: no Blender on PATH; name one: make test-ui BLENDER=/path/to/blender", file=sys.stderr)
        return 1
    os.environ["BLENDER_USER_RESOURCES"] = str(USER)
    shutil.rmtree(USER, ignore_errors=True)
    USER.mkdir(parents=True)
    _call(sys.executable, "-m", "tools.extension", "install", "--blender", chosen.blender)
    if chosen.chinese:
        chinese.rewrite_all(USER / "extensions" / "user_default" / "cabletwin")
    survey = _survey({"run": chosen.run, "steel": chosen.steel})
    window = ("--window-geometry", "0", "0", *map(str, WINDOW))
    script = ROOT / "tests" / "ui" / f"{chosen.walk}.py"
    words = ("--enable-event-simulate", "--python-exit-code", "1", "--python", script)
    os.environ["BLENDER_GUI_SIZE"] = "{}x{}".format(*WINDOW)
    program = [chosen.blender, "--gpu-backend", "opengl", "-noaudio", *window, *words]
    walked = subprocess.run([*program, "--", survey, OUT, *chosen.rooms])
    print(f"pictures in {OUT.relative_to(ROOT)}" if walked.returncode == 0 else "error: the walk failed")
    return walked.returncode


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m tests.ui", description="Walk the flow in a real window.")
    parser.add_argument("rooms", nargs="*", metavar="ROOM", help="of the walk; default: all of walk.py")
    parser.add_argument("--blender", default=shutil.which("blender") or "", help="default: blender on PATH")
    parser.add_argument(
        "--walk", default="walk", choices=("walk", "redraw", "pages"), help="what to do there (default walk)"
    )
    parser.add_argument("--run", type=Path, help="a finished run of the survey, for redraw, pages, 'opened'")
    parser.add_argument("--steel", type=Path, help="a finished run of a steel structure, for 'steel', pages")
    parser.add_argument("--chinese", action="store_true", help="in Chinese, also where Blender has none")
    return parser


def _survey(runs: dict[str, Path | None]) -> Path:
    """A copy of a small rendered survey, and of runs beside it, which the walk may write to."""
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
    _draw_board(copy / "board")
    for name, run in runs.items():
        if run is not None:
            shutil.copytree(run, copy / name)
    return copy


def _draw_board(folder: Path) -> None:
    """Pictures of a chessboard through a known lens."""
    import cv2

    from tests.cable.test_chessboard import POSES, draw_board

    folder.mkdir()
    for number, (turn, shift) in enumerate(POSES):
        cv2.imwrite(str(folder / f"view{number}.png"), draw_board(turn, shift))


def _call(*words: object) -> None:
    subprocess.run([str(w) for w in words], check=True, cwd=ROOT)


if __name__ == "__main__":
    sys.exit(main())
