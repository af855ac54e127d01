"""The command line of synth: ``python -m synth render | scan | suite``; see ``--help``.

Progress goes to stderr, the product's name to stdout.  Exit code 0 only when the product is there, 1 for a
suite with failed cases, 2 for bad input with one sentence, 130 when interrupted.
"""

import argparse
import json
import sys
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path

from pipeline.core.errors import Cancelled, StageError
from pipeline.core.events import Event, silent
from synth.apart import keep_apart


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    options = _parser().parse_args(arguments)
    try:
        status: int = options.act(options)
    except StageError as error:
        print(error, file=sys.stderr)
        return 2
    except (KeyboardInterrupt, Cancelled):
        print("\ninterrupted; the same command goes on from here", file=sys.stderr)
        return 130
    return status


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m synth", description="Synthetic surveys with known truth."
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    render = commands.add_parser(
        "render", help="render a survey: one video per block, survey.toml, truth.json"
    )
    render.add_argument("spec", type=Path, metavar="SPEC.toml")
    render.add_argument("out", type=Path, metavar="OUT")
    render.add_argument("--seed", type=int, help="instead of the specification's")
    render.set_defaults(act=_render)
    scan = commands.add_parser(
        "scan", help="scan a steel structure: clouds or targets' lists, survey.toml, truth.json"
    )
    scan.add_argument("spec", type=Path, metavar="SPEC.toml")
    scan.add_argument("out", type=Path, metavar="OUT")
    scan.add_argument("--seed", type=int, help="instead of the specification's")
    scan.set_defaults(act=_scan)
    suite = commands.add_parser("suite", help="render, reconstruct and evaluate scenarios with several seeds")
    suite.add_argument("spec", type=Path, nargs="*", metavar="SPEC.toml", help="default: all of specs/bench")
    suite.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3], metavar="SEED")
    suite.add_argument("--out", type=Path, default=Path("out/bench"))
    suite.add_argument("--only-render", action="store_true", help="stop when the videos are there")
    suite.add_argument("--stock", action="store_true", help="compare with stock COLMAP too")
    suite.add_argument(
        "--keep-runs", action="store_true", help="keep runs that survey and program would only repeat"
    )
    suite.add_argument(
        "--only-table", action="store_true", help="run nothing: table and page from OUT/results.json"
    )
    suite.add_argument(
        "--docs", type=Path, metavar="DOCS", help="write DOCS/benchmark.md and its plots, of these seeds"
    )
    suite.set_defaults(act=_suite)
    for command in (render, scan, suite):
        command.add_argument("--events", choices=["json"], help="progress as one JSON event a line on stderr")
        command.add_argument("--quiet", action="store_true", help="no progress")
    return parser


def _render(options: argparse.Namespace) -> int:
    from synth.spec_reader import read_spec

    spec = read_spec(options.spec)
    if options.seed is not None:
        _refuse_negative([options.seed])
        spec = replace(spec, seed=options.seed)
    keep_apart()
    from synth.render import render_survey  # bpy takes seconds to load: only for a good specification

    print(render_survey(spec, options.out, _emitter(options)))
    return 0


def _scan(options: argparse.Namespace) -> int:
    from synth.scan.run import scan_survey
    from synth.scan.spec import read_scan_spec

    spec = read_scan_spec(options.spec)
    if options.seed is not None:
        _refuse_negative([options.seed])
        spec = replace(spec, seed=options.seed)
    scanned = scan_survey(spec, options.out, _emitter(options))
    if scanned.rays:
        speed = f"{scanned.rays} rays, {scanned.points} points, {scanned.rays / scanned.seconds:.0f} rays/s"
        print(speed, file=sys.stderr)
    print(scanned.survey)
    return 0


def _suite(options: argparse.Namespace) -> int:
    from synth.suite import SuiteOptions, read_results, run_suite
    from synth.suite_docs import write_docs
    from synth.suite_table import in_order, results_markdown

    _refuse_negative(options.seeds)
    choice = SuiteOptions(
        seeds=tuple(dict.fromkeys(options.seeds)),
        only_render=options.only_render,
        stock=options.stock,
        keep_runs=options.keep_runs,
    )
    failed = []
    if not options.only_table:
        results = run_suite(options.spec, options.out, choice, _emitter(options))
        failed = [case for case in results.cases if case.failure is not None]
    merged = in_order(read_results(options.out))
    if not options.only_render:
        print(results_markdown(merged), end="")
    if options.docs is not None:
        write_docs(in_order(merged, choice.seeds), options.docs)
    for case in failed:
        print(f"{case.scenario}, seed {case.seed}: {case.failure}", file=sys.stderr)
    return 1 if failed else 0


def _refuse_negative(seeds: list[int]) -> None:
    if min(seeds) < 0:
        raise StageError("synth", f"the seed {min(seeds)} is negative", "give 0 or more")


def _emitter(options: argparse.Namespace) -> Callable[[Event], None]:
    if options.quiet:
        return silent
    if options.events == "json":
        return lambda event: print(json.dumps(asdict(event)), file=sys.stderr, flush=True)
    return _Bar()


class _Bar:
    """A bar on a terminal, else a line for every new event."""

    def __init__(self) -> None:
        self._last: Event | None = None

    def __call__(self, event: Event) -> None:
        if event == self._last:
            return
        self._last = event
        filled = 30 * event.done // event.total
        end = "\n" if event.done == event.total or not sys.stderr.isatty() else ""
        start = "\r\x1b[K" if sys.stderr.isatty() else ""
        bar = f"[{'#' * filled}{'.' * (30 - filled)}]"
        line = f"{start}{event.stage} {bar} {event.done}/{event.total} {event.block}"
        print(line, end=end, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
