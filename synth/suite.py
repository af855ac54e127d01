"""The benchmark: every scenario with every seed rendered, reconstructed and evaluated into one table.

Takes specifications and seeds; gives OUT/results.json and OUT/results.md, written anew after every case, and
per case OUT/SCENARIO/seed-N/ with survey/, run/, evaluation.json and log.txt.  Rendering resumes and is kept;
the reconstruction is always made anew, so that its time is true.  A step that fails is a result of its case
and stops no other.  Everything runs as a child, through the same commands as a person would use.
"""

import json
import shutil
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
from synth.suite_records import Case, Results, largest_focal_percent, station_figures
from synth.suite_table import results_json, results_markdown

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
    """

    seeds: tuple[int, ...] = (1, 2, 3)
    only_render: bool = False
    stock: bool = False


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
        A case for each specification and seed, failed ones included.

    Raises:
        StageError: a specification is bad, two have one name, or stock COLMAP is asked for and not there.
        Cancelled: from ``emit``.
    """
    paths = _checked(specs or sorted(BENCH_FOLDER.glob("*.toml")), options)
    todo = [(path, seed) for path in paths for seed in options.seeds]
    results = Results()
    for done, (path, seed) in enumerate(todo):

        def tell(step: str, done: int = done, case: str = f"{path.stem} seed {seed}") -> None:
            emit(Event(stage="suite", done=done, total=len(todo), block=f"{case}: {step}"))

        case = _Line(path=path, seed=seed, folder=out / path.stem / f"seed-{seed}", tell=tell, runner=runner)
        results = Results(cases=(*results.cases, case.run(options)))
        if not options.only_render:  # there are no figures, and those of an earlier call are to stay
            write_text(out / "results.json", json.dumps(results_json(results), indent=1))
            write_text(out / "results.md", results_markdown(results))
    emit(Event(stage="suite", done=len(todo), total=len(todo)))
    return results


@dataclass(frozen=True, kw_only=True)
class _Line:
    """The commands of one case, in their order."""

    path: Path
    seed: int
    folder: Path
    tell: Callable[[str], None]
    runner: Runner

    def run(self, options: SuiteOptions) -> Case:
        survey, run = self.folder / "survey", self.folder / "run"
        survey_toml, truth_json = survey / "survey.toml", survey / "truth.json"
        evaluation_json = self.folder / "evaluation.json"
        case = Case(scenario=self.path.stem, seed=self.seed)
        self.folder.mkdir(parents=True, exist_ok=True)
        (self.folder / "log.txt").unlink(missing_ok=True)
        rendered = self._step("render", "synth", "render", self.path, survey, "--seed", self.seed, "--quiet")
        if rendered.failure is not None or options.only_render:
            return replace(case, failure=rendered.failure)
        shutil.rmtree(run, ignore_errors=True)
        ran = self._step("run", "pipeline", "run", survey_toml, "--out", run, "--events", "none")
        if ran.failure is not None:
            return replace(case, failure=ran.failure, seconds=ran.seconds)
        wanted = ("pipeline", "evaluate", run, "--truth", truth_json, "--json", evaluation_json)
        judged = self._step("evaluate", *wanted)
        if judged.failure is not None:
            return replace(case, failure=judged.failure, seconds=ran.seconds)
        evaluation, surface = _read(evaluation_json), _read(evaluation_json)["surface"]
        return replace(
            case,
            stations=station_figures(evaluation, _read(truth_json)),
            focal_percent=largest_focal_percent(evaluation),
            coverage_percent=surface["coverage_percent"] if surface else None,
            seconds=ran.seconds,
            peak_memory_mb=_read(run / "report.json").get("peak_memory_mb"),
            stock=self._stock(run, survey_toml, truth_json) if options.stock else None,
        )

    def _stock(self, run: Path, survey_toml: Path, truth_json: Path) -> dict[str, Any]:
        """Stock COLMAP's figures; that it fails is one of them."""
        file = self.folder / "stock.json"
        files = (run, "--survey", survey_toml, "--truth", truth_json, "--json", file)
        finished = self._step("stock COLMAP", STOCK_MODULE, *files)
        if finished.failure is not None:
            return {"mae_mm": None, "seconds": finished.seconds, "failure": finished.failure}
        found = {"failure": None} | _read(file)
        if isinstance(found.get("seconds"), dict):
            found["seconds"] = found["seconds"]["total"]
        return found

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


def _read(path: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found
