"""The head of the steel page: name, size of the survey, headline figures, warnings."""

import math

from pipeline.report.markup import DASH, Writer, escaped, number
from pipeline.report.steel.records import SteelReport
from pipeline.report.steel.residuals import point_residual_mm
from pipeline.report.steel.structure_plots import judged


def header(writer: Writer, report: SteelReport) -> str:
    """Name, size, cards, warnings."""
    facts = [
        writer.say("steel_station_count", value=str(len(report.stations))),
        writer.say("steel_target_count", value=str(sum(row.kind == "point" for row in report.targets))),
        writer.say("steel_base_fact", value=report.base) if report.base else writer.say("steel_control_fact"),
    ]
    text = (
        f'<p class="kind">{writer.say("steel_title")}</p><h1>{escaped(report.name)}</h1>'
        f'{writer.say("steel_subtitle", "p", 'class="subtitle"')}<p class="facts">{" · ".join(facts)}</p>'
        f'<div class="cards">{"".join(_cards(writer, report))}</div>'
    )
    if not report.warnings:
        return text
    items = "".join(f"<li>{escaped(warning)}</li>" for warning in report.warnings)
    return text + f'<aside class="warnings">{writer.say("warnings", "h2")}<ul>{items}</ul></aside>'


def _cards(writer: Writer, report: SteelReport) -> list[str]:
    worst = max(report.stations, key=lambda row: row.sigma_mm)
    cards = [
        _card(
            writer,
            "steel_card_residual",
            f"{number(point_residual_mm(report), 1)} mm",
            writer.say("steel_card_residual_note"),
        ),
        _card(
            writer,
            "steel_card_sigma",
            f"{number(worst.sigma_mm, 2)} mm",
            writer.say("steel_card_sigma_note", name=worst.name),
        ),
        _card(
            writer,
            "steel_card_gross",
            str(len(report.gross)),
            writer.say("steel_card_gross_note", value=str(len(report.residuals))),
        ),
    ]
    if report.columns:
        limits = {row.limit_mm for row in report.columns}
        limit = number(limits.pop(), 0) if len(limits) == 1 else DASH
        over = sum(row.over_limit for row in report.columns)
        note = writer.say("steel_card_columns_note", count=str(len(report.columns)), limit=limit)
        cards.append(_card(writer, "steel_card_columns", str(over), note))
    nodes = judged(report.nodes)
    if nodes:
        loud = [row for row in nodes if row.significant]
        note = (
            writer.say("steel_card_nodes_note", count=str(len(nodes)), largest=number(loud[0].size_mm, 1))
            if loud
            else writer.say("steel_card_nodes_none", count=str(len(nodes)))
        )
        cards.append(_card(writer, "steel_card_nodes", str(len(loud)), note))
    if report.deflection is not None and math.isfinite(report.deflection.largest_mm):
        note = writer.say("steel_card_deflection_note", limit=number(report.deflection.limit_mm, 1))
        value = f"{number(report.deflection.largest_mm, 1)} mm"
        cards.append(_card(writer, "steel_card_deflection", value, note))
    return cards


def _card(writer: Writer, key: str, value: str, note: str) -> str:
    name = writer.say(key, "p", 'class="name"')
    return f'<div class="card">{name}<p class="value">{escaped(value)}</p><p class="note">{note}</p></div>'
