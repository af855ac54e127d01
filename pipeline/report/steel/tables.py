"""The tables of the steel report: stations, components, ICP pairs, columns, nodes, the paper's figures."""

import math
from collections.abc import Sequence

import numpy as np

from pipeline.report.labels import TEXTS, Label, label
from pipeline.report.markup import DASH, Row, Writer, escaped, number, signed, thousands
from pipeline.report.steel import paper
from pipeline.report.steel.directions import wind
from pipeline.report.steel.records import SteelReport
from pipeline.report.steel.structure_rows import ColumnRow, NodeRow
from pipeline.steel.registration_records import IcpPair, VarianceComponent

MOST_NODES, MOST_PAIRS = 40, 12
FINE_MM = 0.095
"""Below this standard deviation a second decimal is worth its ink."""
TALL = 14
"""A table of more rows scrolls in a box of its own."""


def head(writer: Writer, keys: Sequence[str]) -> list[str]:
    """The cells of a first row."""
    return [writer.say(key, "th", 'scope="col"') for key in keys]


def name_cell(text: str) -> str:
    """The heading cell of a row."""
    return f'<th scope="row">{escaped(text)}</th>'


def boxed(table: str, rows: int) -> str:
    """A long table scrolls in a box."""
    return f'<div class="tall">{table}</div>' if rows > TALL else table


def stations_table(writer: Writer, report: SteelReport) -> str:
    """Every station with its standard deviations."""
    keys = ("station", "x_m", "y_m", "z_m", "sigma_mm", "sigma_arcsec", "ring", "parent")
    rows = [
        Row(
            head=name_cell(row.name),
            cells=[
                *(number(value, 4) for value in row.position_m),
                number(row.sigma_mm, 2),
                number(row.sigma_arcsec, 1),
                str(row.ring),
                row.parent or label("steel_base"),
            ],
        )
        for row in report.stations
    ]
    caption = writer.say("steel_stations_caption", "figcaption")
    note = writer.say("steel_stations_note", "p", 'class="note"')
    heads = head(writer, [f"steel_{key}" for key in keys])
    return boxed(writer.table(caption, heads, rows, note), len(rows))


def components_table(writer: Writer, components: Sequence[VarianceComponent]) -> str:
    """How well each kind of observation fits."""
    rows = [
        Row(
            head=_kind(writer, row.kind),
            cells=[number(row.factor, 2), str(row.observations), number(row.redundancy, 0)],
        )
        for row in components
    ]
    heads = head(writer, ["steel_kind", "steel_factor", "steel_observations", "steel_redundancy"])
    caption = writer.say("steel_components_caption", "figcaption")
    return writer.table(caption, heads, rows, writer.say("steel_components_note", "p", 'class="note"'))


def _kind(writer: Writer, kind: str) -> str:
    key = f"steel_kind_{kind}"
    return writer.say(key, "th", 'scope="row"') if key in TEXTS else name_cell(kind)


def icp_table(writer: Writer, pairs: Sequence[IcpPair]) -> str:
    """The pairs that ICP got most wrong."""
    worst = sorted(pairs, key=lambda pair: -pair.offset_mm)[:MOST_PAIRS]
    rows = [
        Row(
            head=name_cell(f"{pair.first} – {pair.second}"),
            cells=[
                number(pair.offset_mm, 1),
                number(pair.turn_arcsec, 0),
                number(pair.rms_mm, 1),
                number(100 * pair.matched, 0),
                label("steel_yes" if pair.converged else "steel_no"),
            ],
        )
        for pair in worst
    ]
    keys = ("pair", "offset_mm", "turn_arcsec", "rms_mm", "matched", "converged")
    heads = head(writer, [f"steel_{key}" for key in keys])
    return writer.table(writer.say("steel_icp_caption", "figcaption"), heads, rows)


def columns_table(writer: Writer, columns: Sequence[ColumnRow]) -> str:
    """Table 1: both components, the deviation, its direction, height difference, ratio, verdict."""
    rows = [
        Row(
            head=name_cell(row.name),
            cells=[
                _with_sigma(row.north_mm, row.north_sigma_mm, sign=True),
                _with_sigma(row.east_mm, row.east_sigma_mm, sign=True),
                _with_sigma(row.deviation_mm, row.sigma_mm),
                label(f"steel_wind_{wind(row.direction_deg)}"),
                thousands(1000 * row.height_m),
                f"1/{row.ratio:.0f}" if math.isfinite(row.ratio) else DASH,
                label(_verdict(row)),
            ],
            kind="over" if row.over_limit else "",
        )
        for row in columns
    ]
    keys = ("column", "north_mm", "east_mm", "deviation_mm", "direction", "height_mm", "ratio")
    limits = {row.limit_mm for row in columns}
    shown = number(limits.pop(), 0) if len(limits) == 1 else ""
    heads = [
        *head(writer, [f"steel_{key}" for key in keys]),
        writer.say("steel_verdict", "th", 'scope="col"', limit=shown),
    ]
    caption = writer.say("steel_columns_caption", "figcaption")
    return writer.table(caption, heads, rows, writer.say("steel_columns_note", "p", 'class="note"'))


def _verdict(row: ColumnRow) -> str:
    return ("steel_over" if row.over_limit else "steel_within") + ("" if row.certain else "_near")


def _with_sigma(value: float, sigma: float, *, sign: bool = False) -> str:
    digits = 2 if sigma < FINE_MM else 1
    text = signed(value, digits) if sign else number(value, digits)
    return f"{text} ± {number(sigma, digits)}"


def nodes_table(writer: Writer, nodes: Sequence[NodeRow]) -> str:
    """The largest eccentricities."""
    rows = [
        Row(
            head=name_cell(row.name),
            cells=[
                str(len(row.rods)),
                *(signed(value, 1) for value in row.eccentricity_mm),
                _with_sigma(row.size_mm, row.sigma_mm),
                label("steel_yes" if row.significant else "steel_no"),
                number(1000 * float(np.linalg.norm(np.subtract(row.by_perpendiculars_m, row.rods_m))), 1),
            ],
            kind="loud" if row.significant else "",
        )
        for row in nodes[:MOST_NODES]
    ]
    keys = ("node", "rod_count", "dx_mm", "dy_mm", "dz_mm", "size_mm", "significant", "perpendiculars_mm")
    heads = head(writer, [f"steel_{key}" for key in keys])
    note = writer.say("steel_nodes_note", "p", 'class="note"')
    if len(nodes) > MOST_NODES:
        some = {"shown": str(MOST_NODES), "total": str(len(nodes))}
        note = writer.say("steel_nodes_some", "p", 'class="note"', **some) + note
    return boxed(writer.table(writer.say("steel_nodes_caption", "figcaption"), heads, rows, note), len(rows))


def paper_table(writer: Writer, report: SteelReport, residual_mm: float) -> str:
    """The paper's figures beside ours."""
    lines: list[tuple[str, str | Label, str | Label]] = [
        ("steel_paper_stations", str(len(report.stations)), str(paper.STATIONS)),
        ("steel_paper_registration", f"{number(residual_mm, 1)} mm", f"{paper.REGISTRATION_MM} mm"),
    ]
    if report.columns:
        over = [row for row in report.columns if row.over_limit]
        sizes = [row.deviation_mm for row in over]
        ours = f"{number(min(sizes), 1)}–{number(max(sizes), 1)}" if sizes else DASH
        theirs = f"{paper.LEAST_MM}–{paper.MOST_MM}"
        lines += [
            (
                "steel_paper_columns",
                _of(len(over), len(report.columns)),
                _of(paper.COLUMNS_OVER, paper.COLUMNS),
            ),
            ("steel_paper_range", ours, theirs),
        ]
    if report.deflection is not None:
        ratio = 1000 * report.deflection.span_m / max(report.deflection.largest_mm, 1e-9)
        lines.append(("steel_paper_deflection", f"1/{ratio:.0f}", label("steel_paper_under")))
    rows = [Row(head=writer.say(key, "th", 'scope="row"'), cells=cells) for key, *cells in lines]
    heads = head(writer, ["steel_figure", "steel_paper_ours", "steel_paper_theirs"])
    return writer.table(writer.say("steel_paper_caption", "figcaption"), heads, rows)


def _of(part: int, whole: int) -> Label:
    return label("steel_of", part=str(part), whole=str(whole))


def paper_columns_table(writer: Writer) -> str:
    """Table 1 as printed."""
    rows = [
        Row(
            head=name_cell(row.column),
            cells=[
                label(f"steel_leans_{row.direction}", value=f"{row.deviation_mm:.1f}"),
                thousands(row.height_mm),
                f"1/{row.ratio}",
            ],
        )
        for row in paper.TABLE_1
    ]
    heads = head(writer, ["steel_column", "steel_deviation_mm", "steel_height_mm", "steel_ratio"])
    return writer.table(writer.say("steel_paper_table1", "figcaption"), heads, rows)
