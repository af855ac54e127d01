"""The suite's results as results.json and as a Markdown table; pure."""

from dataclasses import asdict
from typing import Any

from synth.suite_records import Case, Figures, Results, figures

HEAD = (
    *("scenario", "seed", "MAE mm", "MAE of the sheath mm", "largest mm", "within 2 sigma", "sigma / RMS"),
    *("focal %", "coverage %", "time s", "memory MB", "stock MAE mm", "stock time s"),
)


def results_json(results: Results) -> dict[str, Any]:
    """Plain values: every case with its stations and figures, and the figures of every scenario."""
    return {
        "format": 1,
        "cases": [asdict(case) | asdict(figures([case])) for case in results.cases],
        "scenarios": [
            {"scenario": name, "seeds": [case.seed for case in results.of(name)]}
            | asdict(figures(results.of(name)))
            | {"failures": sum(case.failure is not None for case in results.of(name))}
            for name in results.scenarios
        ],
    }


def results_markdown(results: Results) -> str:
    """A table with a row a case and, for several seeds, a row for all; then the failures."""
    lines = [_row(HEAD), _row(["---"] * 2 + ["---:"] * (len(HEAD) - 2))]
    for name in results.scenarios:
        cases = results.of(name)
        lines += [_row(_cells(case)) for case in cases]
        if len(cases) > 1:
            lines.append(_row([name, "all", *_figure_cells(figures(cases)), *[""] * 6]))
    failed = [case for case in results.cases if case.failure is not None]
    if failed:
        lines += ["", "Failed:", ""]
        lines += [f"- {case.scenario}, seed {case.seed}: {case.failure}" for case in failed]
    stock = [case for case in results.cases if case.stock and case.stock.get("failure")]
    if stock:
        lines += ["", "Stock COLMAP failed:", ""]
        lines += [f"- {c.scenario}, seed {c.seed}: {(c.stock or {})['failure']}" for c in stock]
    return "\n".join(lines) + "\n"


def _cells(case: Case) -> list[str]:
    if case.failure is not None:
        return [case.scenario, str(case.seed), "failed", *[""] * (len(HEAD) - 3)]
    stock = case.stock or {}
    return [
        case.scenario,
        str(case.seed),
        *_figure_cells(figures([case])),
        _number(case.focal_percent, 2),
        _number(case.coverage_percent, 1),
        _number(case.seconds, 0),
        _number(case.peak_memory_mb, 0),
        _number(stock.get("mae_mm"), 3),
        _number(stock.get("seconds"), 0),
    ]


def _figure_cells(found: Figures) -> list[str]:
    share = None if found.within_2_sigma is None else 100.0 * found.within_2_sigma
    return [
        _number(found.mae_mm, 3),
        _number(found.mae_base_mm, 3),
        _number(found.largest_mm, 3),
        f"{share:.0f} %" if share is not None else "",
        _number(found.sigma_over_rms, 1),
    ]


def _number(value: float | None, digits: int) -> str:
    return "" if value is None else f"{value:.{digits}f}"


def _row(cells: list[str] | tuple[str, ...]) -> str:
    return f"| {' | '.join(cells)} |"
