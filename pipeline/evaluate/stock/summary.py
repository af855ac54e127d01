"""The blocks together: averaged, compared with truth, and laid out as text for the screen."""

from collections.abc import Sequence

import numpy as np

from pipeline.evaluate.stock.records import StepSeconds, StockBlock, StockResult, StockStation

Stations = Sequence[tuple[str, float, float]]
"""Name, position in metres, true diameter in millimetres."""


def summarise(per_block: tuple[StockBlock, ...], stations: Stations) -> StockResult:
    """Average the blocks' diameters at each station and compare with truth."""
    rows, singles = [], []
    for name, position_m, truth_mm in stations:
        seen = [d for block in per_block if (d := block.diameters.get(name)) is not None]
        singles += [abs(diameter_mm - truth_mm) for diameter_mm in seen]
        mean = float(np.mean(seen)) if seen else None
        rows.append(
            StockStation(
                name=name,
                position_m=position_m,
                truth_mm=truth_mm,
                diameter_mm=mean,
                error_mm=None if mean is None else mean - truth_mm,
            )
        )
    sizes = [abs(row.error_mm) for row in rows if row.error_mm is not None]
    failures = [f"{block.name}: {block.failure}" for block in per_block if block.failure]
    return StockResult(
        mae_mm=float(np.mean(sizes)) if sizes else None,
        mae_of_single_blocks_mm=float(np.mean(singles)) if singles else None,
        stations=tuple(rows),
        per_block=per_block,
        seconds=sum((block.seconds for block in per_block), StepSeconds()),
        failure="; ".join(failures) or None,
    )


def format_stock_table(result: StockResult) -> str:
    """Lay out diameters less truth per block, their mean, and the times, as text."""
    names = [row.name for row in result.stations]
    lines = [f"{'block':10}{'images':>9}" + "".join(f"{name:>9}" for name in names) + f"{'seconds':>10}"]
    truth = {row.name: row.truth_mm for row in result.stations}
    for block in result.per_block:
        errors = [None if (d := block.diameters.get(n)) is None else d - truth[n] for n in names]
        cells = "".join(_signed(error) for error in errors)
        count = f"{block.registered}/{block.images}"
        lines.append(f"{block.name:10}{count:>9}{cells}{block.seconds.total:10.1f}")
    spent = result.seconds
    means = "".join(_signed(row.error_mm) for row in result.stations)
    lines.append(f"{'mean':10}{'':9}{means}{spent.total:10.1f}")
    lines.append(
        f"features {spent.features:.1f} s, matching {spent.matching:.1f} s, mapping {spent.mapping:.1f} s"
    )
    together, single = (_in_mm(value) for value in (result.mae_mm, result.mae_of_single_blocks_mm))
    lines.append(f"stock COLMAP, diameter less truth in mm; MAE {together}, of single blocks {single}")
    return "\n".join([*lines, *([f"failed: {result.failure}"] if result.failure else [])]) + "\n"


def _in_mm(value: float | None) -> str:
    return "unknown" if value is None else f"{value:.4f} mm"


def _signed(value: float | None) -> str:
    return f"{'-':>9}" if value is None else f"{value:+9.3f}"
