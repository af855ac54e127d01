"""The command line of synth: ``python -m synth render SPEC.toml OUT/``.

Progress goes to stderr, the product's name to stdout.  Exit code 0 only when the product is there, 2 for bad
input with one sentence, 130 when interrupted.
"""

import argparse
import json
import sys
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

from pipeline.core.errors import Cancelled, StageError
from pipeline.core.events import Event, silent


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    options = _parser().parse_args(arguments)
    from synth.spec_reader import read_spec

    try:
        spec = read_spec(options.spec)
        from synth.render import render_survey  # bpy takes seconds to load: only for a good specification

        survey = render_survey(spec, options.out, _emitter(options))
    except StageError as error:
        print(error, file=sys.stderr)
        return 2
    except (KeyboardInterrupt, Cancelled):
        print("\ninterrupted; the same command goes on from here", file=sys.stderr)
        return 130
    print(survey)
    return 0


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
    render.add_argument("--events", choices=["json"], help="progress as one JSON event a line on stderr")
    render.add_argument("--quiet", action="store_true", help="no progress")
    return parser


def _emitter(options: argparse.Namespace) -> Callable[[Event], None]:
    if options.quiet:
        return silent
    if options.events == "json":
        return lambda event: print(json.dumps(asdict(event)), file=sys.stderr, flush=True)
    return _bar


def _bar(event: Event) -> None:
    filled = 30 * event.done // event.total
    end = "\n" if event.done == event.total or not sys.stderr.isatty() else ""
    start = "\r" if sys.stderr.isatty() else ""
    bar = f"[{'#' * filled}{'.' * (30 - filled)}]"
    print(
        f"{start}{event.stage} {bar} {event.done}/{event.total} {event.block}",
        end=end,
        file=sys.stderr,
        flush=True,
    )


if __name__ == "__main__":
    sys.exit(main())
