"""The gate's run: its surveys rendered, reconstructed and evaluated by the suite, then judged.

Takes a seed and a folder; gives the verdict and OUT/results.json.  The surveys and runs lie in
OUT/cases/SCENARIO/seed-N/ as the suite leaves them: a survey is rendered once and kept, a run made anew.
"""

import json
from pathlib import Path
from typing import Any

from pipeline.core.events import Emit
from synth.child import run_child
from synth.files import write_text
from synth.gate.bounds import BOUNDS_FILE, read_bounds
from synth.gate.figures import Case, figures_of
from synth.gate.verdict import Line, Verdict, judge, verdict_json
from synth.suite import Runner, SuiteOptions, run_suite


def run_gate(
    out: Path, seed: int, emit: Emit, bounds_file: Path = BOUNDS_FILE, runner: Runner = run_child
) -> Verdict:
    """Run every scenario that has bounds; its specification lies beside them.

    Args:
        out: folder of the products; made if missing.
        seed: of the surveys.
        emit: progress, every half second.
        bounds_file: scenario to figure to bounds.
        runner: starts the commands; see :func:`synth.child.run_child`.

    Raises:
        StageError: the bounds or a specification are bad.
        Cancelled: from ``emit``.
    """
    bounds = read_bounds(bounds_file)
    specs = [bounds_file.parent / f"{name}.toml" for name in bounds]
    cases = out / "cases"
    results = run_suite(specs, cases, SuiteOptions(seeds=(seed,)), emit, runner)
    lines: list[Line] = []
    failures: dict[str, str] = {}
    for case in results.cases:
        if case.failure is not None or case.seconds is None:
            failures[case.scenario] = case.failure or "it was not run"
            continue
        folder = cases / case.scenario / f"seed-{seed}"
        found = Case(
            evaluation=_read(folder / "evaluation.json"),
            report=_read(folder / "run" / "report.json"),
            seconds=case.seconds,
        )
        lines += judge(case.scenario, figures_of(found), bounds[case.scenario])
    verdict = Verdict(seed=seed, lines=tuple(lines), failures=failures)
    write_text(out / "results.json", json.dumps(verdict_json(verdict), indent=1))
    return verdict


def _read(path: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found
