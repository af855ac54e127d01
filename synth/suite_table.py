"""The suite's results as results.json and as Markdown tables beside their targets; pure."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from synth.suite_figures import figures
from synth.suite_records import Case, Figures, Results, case_from_json
from synth.suite_targets import TARGETS, Target, missed, target_mm

FORMAT = 2

HEAD = (
    *("scenario", "seed", "MAE mm", "target mm", "largest mm", "within 2 sigma", "sigma / RMS"),
    *("focal %", "height mm", "bow mm", "coverage %", "overclaimed deg", "time s", "memory MB"),
    *("stock MAE mm", "times closer", "stock time s", "times faster", "missed"),
)


def results_json(results: Results) -> dict[str, Any]:
    """Plain values: every case with its stations and figures, and the figures of every scenario."""
    return {
        "format": FORMAT,
        "cases": [{**asdict(figures([case])), **asdict(case)} for case in results.cases],
        "scenarios": [
            {"scenario": name, "seeds": [case.seed for case in results.of(name)]}
            | {
                "target_mm": target_mm(name, found := figures(results.of(name))),
                "missed": missed(name, found),
            }
            | asdict(found)
            | {"failures": sum(case.failure is not None for case in results.of(name))}
            for name in results.scenarios
        ],
    }


def results_from_json(values: dict[str, Any]) -> Results:
    """The cases that results.json holds.

    Raises:
        ValueError: it is of another format.
    """
    if values.get("format") != FORMAT:
        raise ValueError(f"format is {values.get('format')}, not {FORMAT}")
    return Results(cases=tuple(case_from_json(case) for case in values["cases"]))


def in_order(results: Results, seeds: Sequence[int] = ()) -> Results:
    """Cases in the order of the targets' table, then of names and seeds; of these seeds only, where some are
    given."""
    order = list(TARGETS)

    def key(case: Case) -> tuple[int, str, int]:
        known = case.scenario in TARGETS
        return order.index(case.scenario) if known else len(order), case.scenario, case.seed

    chosen = [case for case in results.cases if not seeds or case.seed in seeds]
    return Results(cases=tuple(sorted(chosen, key=key)))


def results_markdown(results: Results) -> str:
    """A table with a row a case and, for several seeds, a row for all; then the failures."""
    lines = [_row(HEAD), _row(["---"] * 2 + ["---:"] * (len(HEAD) - 3) + ["---"])]
    for name in results.scenarios:
        cases = results.of(name)
        lines += [_case_row(case) for case in cases]
        if len(cases) > 1:
            lines.append(_row([name, "all", *_figure_cells(name, figures(cases))]))
    return "\n".join([*lines, *_failures(results)]) + "\n"


def scenarios_markdown(results: Results) -> str:
    """A table with a row a scenario, all its seeds together, for a page; then the failures."""
    lines = [_row(_pick(HEAD)), _row(["---"] * 2 + ["---:"] * (len(_pick(HEAD)) - 3) + ["---"])]
    for name in results.scenarios:
        seeds = ", ".join(str(case.seed) for case in results.of(name))
        lines.append(_row(_pick([name, seeds, *_figure_cells(name, figures(results.of(name)))])))
    return "\n".join([*lines, *_failures(results)]) + "\n"


def extras(scenario: str, found: Figures) -> str:
    """The figure that a scenario is asked for beside the diameter, with its target; empty where there is
    none."""
    target = TARGETS.get(scenario, Target())
    words = []
    if target.focal_percent is not None:
        words.append(f"focal {_number(found.focal_percent, 2)} % ({target.focal_percent:g})")
    if target.height_mm is not None:
        count = f"{found.relief_missed} missed, {found.relief_false} false"
        told = count if found.relief_missed is not None else "not told"
        words.append(f"height {_number(found.height_mm, 3)} mm ({target.height_mm:g}), {told}")
    if target.bow_mm is not None:
        words.append(f"bow {_number(found.bow_mm, 3)} mm ({target.bow_mm:g})")
    if target.inside_sigma:
        share = "" if found.within_1_sigma is None else f"{100.0 * found.within_1_sigma:.0f} %"
        words.append(f"inside sigma {share} (100 %)")
    return "; ".join(words)


def _pick(cells: Sequence[str]) -> list[str]:
    """A page has no room for what few scenarios are asked for: see :func:`extras`."""
    left_out = ("focal %", "height mm", "bow mm")
    return [cell for name, cell in zip(HEAD, cells, strict=True) if name not in left_out]


def _case_row(case: Case) -> str:
    if case.failure is not None:
        return _row([case.scenario, str(case.seed), "failed", *[""] * (len(HEAD) - 3)])
    return _row([case.scenario, str(case.seed), *_figure_cells(case.scenario, figures([case]))])


def _figure_cells(scenario: str, found: Figures) -> list[str]:
    share = None if found.within_2_sigma is None else 100.0 * found.within_2_sigma
    return [
        _number(found.mae_mm, 3),
        _number(target_mm(scenario, found), 2),
        _number(found.largest_mm, 3),
        f"{share:.0f} %" if share is not None else "",
        _number(found.sigma_over_rms, 1),
        _number(found.focal_percent, 2),
        _number(found.height_mm, 3),
        _number(found.bow_mm, 3),
        _number(found.coverage_percent, 1),
        _number(found.overclaimed_deg, 0),
        _number(found.seconds, 0),
        _number(found.peak_memory_mb, 0),
        _number(found.stock_mae_mm, 3),
        _number(found.times_closer, 1),
        _number(found.stock_seconds, 0),
        _number(found.times_faster, 1),
        ", ".join(missed(scenario, found)) if found.mae_mm is not None else "failed",
    ]


def _failures(results: Results) -> list[str]:
    lines = []
    failed = [case for case in results.cases if case.failure is not None]
    if failed:
        lines += ["", "Failed:", ""]
        lines += [f"- {case.scenario}, seed {case.seed}: {case.failure}" for case in failed]
    stock = [case for case in results.cases if case.stock and case.stock.get("failure")]
    if stock:
        lines += ["", "Stock COLMAP failed:", ""]
        lines += [f"- {c.scenario}, seed {c.seed}: {(c.stock or {})['failure']}" for c in stock]
    return lines


def _number(value: float | None, digits: int) -> str:
    return "" if value is None else f"{value:.{digits}f}"


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"
