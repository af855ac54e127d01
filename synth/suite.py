"""The benchmark: every scenario with every seed rendered, reconstructed and evaluated into one table.

Takes specifications and seeds; gives OUT/results.json and OUT/results.md, brought up to date after every
case, and per case OUT/SCENARIO/seed-N/ with survey/, run/, evaluation.json and log.txt.  Several calls add
up: a case takes the place of an earlier one of the same scenario and seed, and leaves the others.  Rendering
resumes and is kept, and cases that differ in their claims only share it; the reconstruction is made anew, so
that its time is true, unless an up-to-date one is to be kept.  A step that fails is a result of its case and
stops no other.  Everything runs as a child, through the same commands as a person would use.
"""

import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event
from synth.child import Finished, run_child
from synth.files import write_text
from synth.spec_reader import read_spec
from synth.suite_cache import (
    forget_run,
    kept_seconds,
    note_run,
    program_digest,
    read_json,
    share_pictures,
    survey_digest,
)
from synth.suite_figures import evaluation_figures, has_ribs, station_figures
from synth.suite_records import Case, Results
from synth.suite_table import in_order, results_from_json, results_json, results_markdown

BENCH_FOLDER = Path(__file__).parents[1] / "specs" / "bench"
STOCK_MODULE = "pipeline.evaluate.stock_colmap"

Runner = Callable[[Sequence[str], Path, Callable[[], None]], Finished]
"""Runs a command with a log; see :func:`synth.child.run_child`."""


@dataclass(frozen=True, kw_only=True)
class SuiteOptions:
    """What to do with every scenario.

    Attributes:
        seeds: instead of the specifications' own.
        only_render: stop when the videos are there.
        stock: compare with stock COLMAP too.
        keep_runs: keep a finished run, and stock COLMAP's, where survey and program are those that made it.
    """

    seeds: tuple[int, ...] = (1, 2, 3)
    only_render: bool = False
    stock: bool = False
    keep_runs: bool = False


def run_suite(
    specs: Sequence[Path], out: Path, options: SuiteOptions, emit: Emit, runner: Runner = run_child
) -> Results:
    """Run all cases.

    Args:
        specs: specifications; none takes all of specs/bench.
        out: folder of the products; made if missing.
        options: see there.
        emit: progress, every half second; the block names the case and its step.
        runner: starts the commands.

    Returns:
        A case for each specification and seed, failed ones included; the files hold earlier calls' too.

    Raises:
        StageError: a specification is bad, two have one name, stock COLMAP is asked for and not there, or
            OUT/results.json is none that could be added to.
        Cancelled: from ``emit``.
    """
    paths = _checked(specs or sorted(BENCH_FOLDER.glob("*.toml")), options)
    todo = [(path, seed) for path in paths for seed in options.seeds]
    results, merged = Results(), read_results(out)
    for done, (path, seed) in enumerate(todo):

        def tell(step: str, done: int = done, case: str = f"{path.stem} seed {seed}") -> None:
            emit(Event(stage="suite", done=done, total=len(todo), block=f"{case}: {step}"))

        case = _Line(path=path, seed=seed, folder=out / path.stem / f"seed-{seed}", tell=tell, runner=runner)
        results = results.with_case(found := case.run(options))
        merged = in_order(merged.with_case(found))
        if not options.only_render:  # there are no figures, and those of an earlier call are to stay
            write_text(out / "results.json", json.dumps(results_json(merged), indent=1))
            write_text(out / "results.md", results_markdown(merged))
    emit(Event(stage="suite", done=len(todo), total=len(todo)))
    return results


def read_results(out: Path) -> Results:
    """The cases of OUT/results.json, none where there is no such file.

    Raises:
        StageError: it was not written by this program.
    """
    file = out / "results.json"
    if not file.exists():
        return Results()
    try:
        return results_from_json(json.loads(file.read_text(encoding="utf-8")))
    except (ValueError, KeyError, TypeError) as error:
        raise StageError("suite", f"{file} cannot be added to ({error})", "move it away") from error


@dataclass(frozen=True, kw_only=True)
class _Line:
    """The commands of one case, in their order."""

    path: Path
    seed: int
    folder: Path
    tell: Callable[[str], None]
    runner: Runner

    def run(self, options: SuiteOptions) -> Case:
        survey, case = self.folder / "survey", Case(scenario=self.path.stem, seed=self.seed)
        self.folder.mkdir(parents=True, exist_ok=True)
        (self.folder / "log.txt").unlink(missing_ok=True)
        if not survey.is_file():
            share_pictures(replace(read_spec(self.path), seed=self.seed), survey, self.folder.parents[1])
        rendered = self._step("render", "synth", "render", self.path, survey, "--seed", self.seed, "--quiet")
        if rendered.failure is not None or options.only_render:
            return replace(case, failure=rendered.failure)
        case = self._reconstruct(case, options)
        if case.failure is not None:
            return case
        judged = self._step(
            "evaluate",
            *("pipeline", "evaluate", self.folder / "run", "--truth", survey / "truth.json"),
            *("--json", self.folder / "evaluation.json"),
        )
        if judged.failure is not None:
            return replace(case, failure=judged.failure)
        case = self._judged(case)
        return replace(case, stock=self._stock(options)) if options.stock else case

    def _reconstruct(self, case: Case, options: SuiteOptions) -> Case:
        """Run the pipeline, or keep what it made of this survey."""
        survey, run = self.folder / "survey", self.folder / "run"
        of_survey, program = survey_digest(survey), program_digest()
        seconds = kept_seconds(self.folder, of_survey, program) if options.keep_runs else None
        if seconds is None:
            forget_run(self.folder)
            words = ("pipeline", "run", survey / "survey.toml", "--out", run, "--events", "none")
            ran = self._step("run", *words)
            if ran.failure is not None:
                return replace(case, failure=ran.failure, seconds=ran.seconds)
            note_run(self.folder, seconds := ran.seconds, of_survey, program)
        return replace(case, seconds=seconds, program=program)

    def _judged(self, case: Case) -> Case:
        evaluation = read_json(self.folder / "evaluation.json")
        truth = read_json(self.folder / "survey" / "truth.json")
        return replace(
            case,
            stations=station_figures(evaluation, truth),
            counts_base=has_ribs(truth),
            peak_memory_mb=read_json(self.folder / "run" / "report.json").get("peak_memory_mb"),
            **evaluation_figures(evaluation),
        )

    def _stock(self, options: SuiteOptions) -> dict[str, Any]:
        """Stock COLMAP's figures; that it fails is one of them."""
        survey, file = self.folder / "survey", self.folder / "stock.json"
        note, of_survey = self.folder / "stock-survey", survey_digest(survey)
        kept = options.keep_runs and file.exists() and note.exists() and note.read_text() == of_survey
        if not kept:
            note.unlink(missing_ok=True)
            files = (
                self.folder / "run",
                "--survey",
                survey / "survey.toml",
                "--truth",
                survey / "truth.json",
            )
            finished = self._step("stock COLMAP", STOCK_MODULE, *files, "--json", file)
            if finished.failure is not None:
                return {"mae_mm": None, "seconds": finished.seconds, "failure": finished.failure}
            write_text(note, of_survey)
        found = {"failure": None} | read_json(file)
        seconds = found.get("seconds")
        if isinstance(seconds, dict):
            seconds = seconds["total"]
        return {"mae_mm": found.get("mae_mm"), "seconds": seconds, "failure": found["failure"]}

    def _step(self, name: str, *words: object) -> Finished:
        command = [sys.executable, "-m", *map(str, words)]
        self.tell(name)
        return self.runner(command, self.folder / "log.txt", lambda: self.tell(name))


def _checked(specs: Sequence[Path], options: SuiteOptions) -> list[Path]:
    """Refuse before the first of many hours what would fail in the last."""
    names = [path.stem for path in specs]
    for path in specs:
        if names.count(path.stem) > 1:
            raise StageError("suite", f"two specifications are called {path.stem}", "rename one of them")
        read_spec(path)
    if options.stock and find_spec(STOCK_MODULE) is None:
        raise StageError("suite", f"{STOCK_MODULE} is not there", "leave out --stock")
    return list(specs)
