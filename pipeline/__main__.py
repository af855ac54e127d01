"""The command line: ``python -m pipeline run | steel | join-scan | evaluate | lens``; see ``--help``.

Exit code 0 when the product is there, 2 for bad input (one sentence on stderr), 130 when interrupted.
"""

import argparse
import os
import signal
import sys
from pathlib import Path
from types import FrameType

# before numpy is imported: on our small matrices BLAS threads wait for each other, 5 to 1 when cores are busy
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from pipeline.core.errors import Cancelled, StageError
from pipeline.core.events import Emit

STAGE_NAMES = (
    *("frames", "lens", "pos", "match", "adjust", "closing", "joint", "undistort"),
    *("dense", "surface", "texture", "crop"),
    *("mosaic", "ring", "measure", "report"),
)
STEEL_STAGE_NAMES = (
    *("clouds", "targets", "register", "compare"),
    *("tiles", "members", "measure"),
    *("photos", "fuse", "report"),
)


def main(arguments: list[str] | None = None) -> int:
    """Parse the command line, do what it says, and give the exit code."""
    signal.signal(signal.SIGTERM, _interrupt)
    if hasattr(signal, "SIGBREAK"):  # what Windows has in its place
        signal.signal(signal.SIGBREAK, _interrupt)
    chosen = _parser().parse_args(arguments)
    try:
        status: int = chosen.act(chosen)
    except StageError as error:
        # a bar may stand there, half way
        print(f"{'\r\x1b[K' if sys.stderr.isatty() else ''}error: {error}", file=sys.stderr)
        return 2
    except (KeyboardInterrupt, Cancelled):
        print("\ninterrupted; what is finished is kept, start again to go on", file=sys.stderr)
        return 130
    except BrokenPipeError:  # the reader of our output has gone: nothing is wrong here
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    return status


def _interrupt(number: int, frame: FrameType | None) -> None:
    raise KeyboardInterrupt


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m pipeline",
        description="Measure a cable from its videos, or a steel structure from scans.",
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    _run_words(commands.add_parser("run", help="the whole chain, from a survey to a measured model; resumes"))
    steel = (
        "a large steel structure from laser scans and photos: stations, nodes, columns, deflection; resumes"
    )
    _steel_words(commands.add_parser("steel", help=steel))
    joined = "bring a laser scan of a cable into the frame of its finished run, and compare the two"
    _join_scan_words(commands.add_parser("join-scan", help=joined))
    _evaluate_words(commands.add_parser("evaluate", help="compare a run with what is true"))
    lens = "calibrate a lens from pictures of a chessboard, or estimate it from the cable's edges"
    _lens_words(commands.add_parser("lens", help=lens))
    return parser


def _run_words(run: argparse.ArgumentParser) -> None:
    _survey_words(run, STAGE_NAMES)
    run.add_argument(
        "--pairs", type=Path, help="CSV of corresponding points chosen by hand, see docs/survey.md"
    )
    run.add_argument(
        "--adjust",
        choices=("joint", "blocks"),
        help="adjust the ring together (default where the cameras share a clock) or each block alone",
    )
    run.add_argument(
        "--no-lens-correction", action="store_true", help="leave the lens uncorrected, to see the bent model"
    )
    run.set_defaults(act=_run)


def _steel_words(steel: argparse.ArgumentParser) -> None:
    _survey_words(steel, STEEL_STAGE_NAMES)
    steel.set_defaults(act=_steel)


def _survey_words(command: argparse.ArgumentParser, stage_names: tuple[str, ...]) -> None:
    """What every command takes that goes from a survey to a run folder."""
    command.add_argument("survey", type=Path, help="survey.toml")
    command.add_argument("--out", type=Path, required=True, help="the run folder")
    command.add_argument("--truth", type=Path, help="truth.json: the report then compares with it")
    stages = command.add_mutually_exclusive_group()
    stages.add_argument(
        "--only", metavar="STAGE", choices=stage_names, help="make this stage again, no other"
    )
    stages.add_argument(
        "--from",
        dest="start",
        metavar="STAGE",
        choices=stage_names,
        help="make this stage and all after it again",
    )
    command.add_argument(
        "--set", action="append", default=[], metavar="STAGE.KEY=VALUE", help="set an option; may be repeated"
    )
    command.add_argument("--language", choices=("en", "zh"), default="en", help="of the report when it opens")
    command.add_argument(
        "--events", choices=("bar", "json", "none"), default="bar", help="progress on stderr"
    )


def _join_scan_words(joined: argparse.ArgumentParser) -> None:
    joined.add_argument("run", type=Path, help="the folder of a finished cable run")
    joined.add_argument(
        "--scan",
        type=Path,
        required=True,
        action="append",
        metavar="CLOUD",
        help="E57, LAS, LAZ, PLY, PTS or XYZ; may be repeated for clouds in one frame",
    )
    joined.add_argument("--unit", choices=("m", "mm"), default="m", help="of the clouds' coordinates")
    joined.add_argument("--pairs", type=Path, help="CSV of places pointed out in both, see docs/steel.md")
    joined.add_argument("--out", type=Path, help="where to write; default: scan in the run's folder")
    joined.add_argument("--language", choices=("en", "zh"), default="en", help="of the page when it opens")
    joined.add_argument("--events", choices=("bar", "json", "none"), default="bar", help="progress on stderr")
    joined.set_defaults(act=_join_scan)


def _evaluate_words(evaluate: argparse.ArgumentParser) -> None:
    evaluate.add_argument("run", type=Path, help="the run folder")
    evaluate.add_argument("--truth", type=Path, required=True, help="truth.json")
    evaluate.add_argument("--json", type=Path, help="write all figures there as well")
    evaluate.set_defaults(act=_evaluate)


def _lens_words(lens: argparse.ArgumentParser) -> None:
    lens.add_argument("folder", type=Path, help="folder of pictures; with --block a survey.toml")
    way = lens.add_mutually_exclusive_group(required=True)
    way.add_argument("--chessboard", metavar="9x6", help="inner corners of the board")
    way.add_argument(
        "--block",
        metavar="NAME",
        action="append",
        help="estimate this block's lambda from the cable's edges; may be repeated",
    )
    lens.add_argument(
        "--square-mm", type=float, default=1.0, help="side of a square; only poses depend on it"
    )
    lens.add_argument("--json", type=Path, help="write all that was found there as well")
    lens.add_argument("--events", choices=("bar", "json", "none"), default="none", help="progress on stderr")
    lens.set_defaults(act=_lens)


def _run(chosen: argparse.Namespace) -> int:
    # imported here, so that --help and refusals answer at once
    from pipeline.cable.survey import read_survey
    from pipeline.set_aside import none_if_refused

    with none_if_refused(chosen.out):
        survey = read_survey(chosen.survey)
    from pipeline.console import emitter
    from pipeline.product import make_product

    # importing pycolmap has put glog's own handler there, which aborts with a stack trace
    signal.signal(signal.SIGTERM, _interrupt)
    assignments = (
        *chosen.set,
        *(("lens.correct=false",) if chosen.no_lens_correction else ()),
        *((f"joint.together={str(chosen.adjust == 'joint').lower()}",) if chosen.adjust else ()),
    )
    summary = make_product(
        survey,
        chosen.out,
        emitter(chosen.events, tuple(b.name for b in survey.blocks)),
        assignments=assignments,
        start=chosen.start,
        only=chosen.only,
        pairs=chosen.pairs,
        truth=chosen.truth,
        language=chosen.language,
    )
    print(summary)
    return 0


def _steel(chosen: argparse.Namespace) -> int:
    from pipeline.set_aside import none_if_refused
    from pipeline.steel.survey import read_steel_survey

    with none_if_refused(chosen.out):
        survey = read_steel_survey(chosen.survey)
    from pipeline.console import emitter
    from pipeline.progress import STEEL_SHARES
    from pipeline.steel_product import make_steel_product

    summary = make_steel_product(
        survey,
        chosen.out,
        emitter(chosen.events, tuple(s.name for s in survey.stations), STEEL_SHARES),
        assignments=tuple(chosen.set),
        start=chosen.start,
        only=chosen.only,
        truth=chosen.truth,
        language=chosen.language,
    )
    print(summary)
    return 0


def _join_scan(chosen: argparse.Namespace) -> int:
    from pipeline.console import emitter
    from pipeline.scan.product import make_scan_product
    from pipeline.steel.survey_records import LengthUnit

    summary = make_scan_product(
        chosen.run,
        tuple(chosen.scan),
        LengthUnit(chosen.unit),
        chosen.out,
        chosen.language,
        emitter(chosen.events, (), {"scan": 1.0}),
        chosen.pairs,
    )
    print(summary)
    return 0


def _evaluate(chosen: argparse.Namespace) -> int:
    from pipeline.evaluate import evaluate, write_evaluation
    from pipeline.evaluate.table import format_table

    found = evaluate(chosen.run, chosen.truth)
    print(format_table(found))
    if chosen.json:
        write_evaluation(found, chosen.json)
    return 0


def _lens(chosen: argparse.Namespace) -> int:
    from pipeline.console import emitter
    from pipeline.core.files import write_json

    emit = emitter(chosen.events, tuple(chosen.block or ()))
    if chosen.chessboard:
        from pipeline.cable.chessboard import calibrate_chessboard, survey_lines

        calibration = calibrate_chessboard(chosen.folder, chosen.chessboard, chosen.square_mm, emit)
        found: object = calibration
        said = survey_lines(calibration)
    else:
        found, said = _estimate(chosen.folder, chosen.block, emit)
    if chosen.json:
        write_json(chosen.json, found, "lens")
    print(said)
    return 0


def _estimate(survey_file: Path, blocks: list[str], emit: Emit) -> tuple[object, str]:
    from pipeline.cable.frames import FrameOptions
    from pipeline.cable.lens import LensOptions
    from pipeline.cable.lens_estimate import estimate_lens, solution_lines
    from pipeline.cable.survey import read_survey
    from pipeline.core.options import build

    survey = read_survey(survey_file)
    frames = build(FrameOptions, survey.stage_options("frames"), key="options.frames")
    lens = build(LensOptions, survey.stage_options("lens"), key="options.lens")
    found = {name: estimate_lens(survey, name, frames, lens, emit) for name in blocks}
    return found, "\n\n".join(f"# {name}\n{solution_lines(solution)}" for name, solution in found.items())


if __name__ == "__main__":
    sys.exit(main())
