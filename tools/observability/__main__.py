"""``python -m tools.observability [FIGURE]``: the figure of docs/accuracy.md, and its figures on stdout.

A calm survey (specs/bench/paper.toml, cameras mounted as crookedly as in sway.toml) is simulated for one
camera and for four.  It is adjusted with the focal length held at wrong values and, with several seeds, with
the focal length free from 5 % off; lambda is free every time.  Half a minute on one quiet core.
"""

import argparse
import sys
from dataclasses import replace
from pathlib import Path

from synth.spec import Spec
from synth.spec_reader import read_spec
from tools.observability.adjustment import Found, adjust
from tools.observability.figure import STYLES, Results, draw
from tools.observability.simulation import simulate

ROOT = Path(__file__).parents[2]
CAMERAS = dict(zip(STYLES, (1, 4), strict=True))
HELD_PERCENT = (-5.0, -4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0)
START_PERCENT = 5.0
SEEDS = tuple(range(11, 21))
POINTS, MARKS = 400, 150


def calm_survey() -> Spec:
    """The survey of the figure."""
    spec = read_spec(ROOT / "specs" / "bench" / "paper.toml")
    return replace(spec, seed=SEEDS[0], robot=replace(spec.robot, mounting_deg=0.3, mounting_mm=0.5))


def main(arguments: list[str] | None = None) -> int:
    """Compute, print and draw."""
    parser = argparse.ArgumentParser(prog="python -m tools.observability", description=__doc__.split("\n")[0])
    default = ROOT / "docs" / "images" / "observability.svg"
    parser.add_argument("figure", type=Path, nargs="?", default=default, help="SVG or PNG to write")
    path: Path = parser.parse_args(arguments).figure
    survey = calm_survey()
    held: dict[str, list[Found]] = {}
    free: dict[str, list[Found]] = {}
    for series, cameras in CAMERAS.items():
        seen = simulate(survey, cameras, POINTS, MARKS)
        held[series] = [adjust(seen, percent, held=True) for percent in HELD_PERCENT]
        passes = (simulate(replace(survey, seed=seed), cameras, POINTS, MARKS) for seed in SEEDS)
        free[series] = [adjust(one, START_PERCENT, held=False) for one in passes]
        print(_table(series, held[series], free[series]), flush=True)
    draw(Results(held=held, free=free), path)
    print(path)
    return 0


def _table(series: str, held: list[Found], free: list[Found]) -> str:
    head = f"{series}\n         focal %  diameter mm  reprojection px     cost"
    rows = [("held", f) for f in held] + [("free", f) for f in free]
    cells = [
        f"  {how}  {f.focal_percent:8.2f}  {f.diameter_mm:11.3f}  {f.reprojection_px:15.4f}  {f.cost:7.0f}"
        for how, f in rows
    ]
    return "\n".join([head, *cells])


if __name__ == "__main__":
    sys.exit(main())
