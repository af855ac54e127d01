"""The command line: ``python -m tools.extension build | install``; see ``--help``.

Exit code 0 when everything asked for is there, 1 with one sentence on stderr for each thing that is not.
"""

import argparse
import sys
from pathlib import Path

from tools.extension.blender import find_blender, install
from tools.extension.build import Plan, build, this_platform, this_python
from tools.extension.errors import ExtensionError
from tools.extension.wheels import PLATFORMS, PYTHONS

ROOT = Path(__file__).parents[2]
OUT = Path("build", "extension")
CACHE = ROOT / "build" / "wheels"
ASSETS = ROOT / "build" / "assets"


def main(arguments: list[str] | None = None) -> int:
    """Parse the command line, do what it says, and give the exit code."""
    chosen = _parser().parse_args(arguments)
    try:
        return int(chosen.act(chosen))
    except ExtensionError as problem:
        print(f"error: {problem}", file=sys.stderr)
        return 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m tools.extension", description="Make the Blender extension."
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    make = commands.add_parser("build", help="one zip for each platform, checked by Blender's own checker")
    make.add_argument(
        "--platform",
        action="append",
        choices=("this", *PLATFORMS),
        help="may be repeated; 'this': the present one, for bpy's Python only (quick); default: all",
    )
    make.add_argument("--out", type=Path, help=f"folder of the zips (default {OUT})")
    make.set_defaults(act=_build)
    put = commands.add_parser("install", help="build for a Blender of this machine and install it there")
    put.add_argument("--blender", default="", help="the program (default: blender on PATH)")
    put.set_defaults(act=_install)
    return parser


def _build(chosen: argparse.Namespace) -> int:
    this = chosen.platform == ["this"]
    names = [this_platform() if name == "this" else name for name in chosen.platform or PLATFORMS]
    plan = Plan(
        platforms=tuple(dict.fromkeys(names)),
        pythons=(this_python(),) if this else PYTHONS,
        out=(chosen.out or ROOT / OUT / ("this" if this else "all")),
        cache=CACHE,
        assets=ASSETS,
    )
    return _show(plan)


def _install(chosen: argparse.Namespace) -> int:
    blender = find_blender(chosen.blender)
    python = next((python for python in PYTHONS if python == blender.python), None)
    if python is None:
        raise ExtensionError(
            f"{blender.program} runs on Python {blender.python}: no wheels are pinned for it"
        )
    out = ROOT / OUT / "install"
    plan = Plan(platforms=(this_platform(),), pythons=(python,), out=out, cache=CACHE, assets=ASSETS)
    built = build(ROOT, plan, _tell)
    install(blender, built.packages[0])
    print(f"installed in {blender.program}: press N in the 3D view, tab CableTwin")
    return 0


def _show(plan: Plan) -> int:
    built = build(ROOT, plan, _tell)
    for package in built.packages:
        print(package)
    for sentence in built.left_out:
        print(f"error: {sentence}", file=sys.stderr)
    return 1 if built.left_out else 0


def _tell(words: str) -> None:
    print(words, file=sys.stderr)


if __name__ == "__main__":
    sys.exit(main())
