"""``python -m synth.gate``: the gate of accuracy, what ``make accuracy`` calls.

The table goes to stdout, progress and complaints to stderr.  Exit code 0 only when every figure lies between
its bounds, 1 when one does not or a step failed, 2 for bad input, 130 when interrupted.
"""

import argparse
import sys
from pathlib import Path

from pipeline.core.errors import Cancelled, StageError
from pipeline.core.events import Event
from synth.gate.run import run_gate
from synth.gate.verdict import verdict_table


def main(arguments: list[str] | None = None) -> int:
    """Run the gate; returns the exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m synth.gate", description="Small surveys whose figures must lie between bounds."
    )
    parser.add_argument("--seed", type=int, default=11, help="of the surveys (default: %(default)s)")
    parser.add_argument("--out", type=Path, default=Path("out/accuracy"))
    options = parser.parse_args(arguments)
    try:
        if options.seed < 0:
            raise StageError("gate", f"the seed {options.seed} is negative", "give 0 or more")
        verdict = run_gate(options.out, options.seed, _Steps())
    except StageError as error:
        print(error, file=sys.stderr)
        return 2
    except (KeyboardInterrupt, Cancelled):
        print("\ninterrupted; the same command goes on from here", file=sys.stderr)
        return 130
    print(verdict_table(verdict), end="")
    print(f"figures: {options.out / 'results.json'}")
    for complaint in verdict.complaints:
        print(complaint, file=sys.stderr)
    return 1 if verdict.complaints else 0


class _Steps:
    """A line for every new step: the gate is watched by a log more often than by a person."""

    def __init__(self) -> None:
        self._last = ""

    def __call__(self, event: Event) -> None:
        if event.block and event.block != self._last:
            self._last = event.block
            print(event.block, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
