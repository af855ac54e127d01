"""The run against the truth: what was found beside what was asked for."""

import math

from pipeline.evaluate.steel.records import SteelEvaluation
from pipeline.report.markup import Row, Writer, number, signed
from pipeline.report.steel.tables import head

Line = tuple[str, str, str]
"""Label key, found, target."""


def truth_section(writer: Writer, found: SteelEvaluation | None) -> str:
    """A table of key figures; "" without truth."""
    if found is None:
        return ""
    lines = [*_stations(found), *_structure(found)]
    rows = [
        Row(head=writer.say(key, "th", 'scope="row"'), cells=[value, wanted]) for key, value, wanted in lines
    ]
    heads = head(writer, ["steel_figure", "steel_found", "steel_wanted"])
    return writer.table(writer.say("steel_truth_caption", "figcaption"), heads, rows)


def _stations(found: SteelEvaluation) -> list[Line]:
    stations, gross = found.stations, found.gross
    counts = f"{len(gross.named)}, {len(gross.missed)}, {len(gross.false)}"
    return [
        ("steel_truth_position", number(stations.rms_mm, 2), "≤ 1"),
        ("steel_truth_fitted", number(stations.fitted_rms_mm, 2), ""),
        ("steel_truth_attitude", number(stations.rms_arcsec, 1), "≤ 20"),
        ("steel_truth_chained", _both(stations.chained_rms_mm, stations.chained_fitted_rms_mm), ""),
        *(
            [("steel_truth_icp", _both(stations.icp_rms_mm, stations.icp_fitted_rms_mm), "")]
            if math.isfinite(stations.icp_rms_mm)
            else []
        ),
        ("steel_truth_sigma_share", number(stations.sigma.within_percent, 0), "≥ 90"),
        ("steel_truth_sigma_ratio", number(stations.sigma.over_rms, 2), "≤ 3"),
        ("steel_truth_gross", counts, "–, 0, 0"),
    ]


def _both(as_it_stands_mm: float, fitted_mm: float) -> str:
    return f"{number(as_it_stands_mm, 2)}, {number(fitted_mm, 2)}"


def _structure(found: SteelEvaluation) -> list[Line]:
    lines: list[Line] = []
    if found.nodes is not None:
        nodes = found.nodes
        lines += [
            ("steel_truth_nodes", number(nodes.amount_rms_mm, 2), "≤ 0.5"),
            ("steel_truth_nodes_false", f"{nodes.false}, {nodes.missed}", "≤ 2 %, 0"),
        ]
    if found.columns is not None:
        columns = found.columns
        lines += [
            ("steel_truth_columns", number(columns.largest_mm, 2), "≤ 1"),
            ("steel_truth_columns_right", f"{columns.right} / {columns.right + columns.wrong}", ""),
        ]
    if found.deflection is not None:
        lines.append(("steel_truth_deflection", number(found.deflection.rms_mm, 2), ""))
    if found.fusion is not None:
        lines.append(("steel_truth_scale", signed(found.fusion.scale_percent, 3), "≤ 0.1"))
    if found.rods is not None:
        rods = found.rods
        counts = f"{rods.found}, {rods.true - rods.found}, {rods.false}"
        lines.append(("steel_truth_members", counts, ""))
    return lines
