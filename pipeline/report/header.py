"""The head of the page: name, size of the survey, headline figures, warnings.

Takes the writer and the report's data, gives HTML.
"""

from pipeline.report.markup import DASH, Writer, escaped, number
from pipeline.report.metrics import compare_with_truth, mean, mean_absolute_error_mm, worst
from pipeline.report.types import ReportData


def header(writer: Writer, data: ReportData) -> str:
    """Name, size of the survey, headline figures, warnings."""
    images = sum(block.images for block in data.blocks)
    facts = [
        writer.say("length", value=number(data.length_m, 2)),
        writer.say("block_count", value=str(len(data.blocks))),
        writer.say("image_count", value=str(images)),
    ]
    head = (
        f'<p class="kind">{writer.say("title")}</p><h1>{escaped(data.name)}</h1>'
        f'{writer.say("subtitle", "p", 'class="subtitle"')}<p class="facts">{" · ".join(facts)}</p>'
    )
    return head + f'<div class="cards">{_cards(writer, data)}</div>' + _warnings(writer, data)


def _cards(writer: Writer, data: ReportData) -> str:
    diameters_mm = [station.diameter_mm for station in data.stations]
    cards = [
        _card(
            writer,
            "mean_diameter",
            f"{number(mean(diameters_mm), 2)} mm",
            writer.say("mean_diameter_note", value=str(len(data.stations))),
        )
    ]
    compared = compare_with_truth(data.stations, data.truth)
    if compared:
        error = f"{number(mean_absolute_error_mm(compared), 3)} mm"
        cards.append(_card(writer, "mae", error, writer.say("mae_note")))
    sigma_mm = worst([station.sigma_mm for station in data.stations])
    names = [station.name for station in data.stations if station.sigma_mm == sigma_mm]
    note = writer.say("worst_sigma_note", name=names[0]) if names else ""
    cards.append(_card(writer, "worst_sigma", f"{number(sigma_mm, 3)} mm", note))
    images = sum(block.images for block in data.blocks)
    calibrated = sum(block.calibrated for block in data.blocks)
    share = f"{100 * calibrated / images:.0f} %" if images else DASH
    note = writer.say("calibrated_note", calibrated=str(calibrated), images=str(images))
    cards.append(_card(writer, "calibrated_short", share, note))
    if data.axis is not None:
        value = f"{number(data.axis.straightness_mm_per_m, 2)} mm/m"
        cards.append(_card(writer, "straightness", value, writer.say("straightness_note")))
    return "".join(cards)


def _card(writer: Writer, key: str, value: str, note: str) -> str:
    name = writer.say(key, "p", 'class="name"')
    return f'<div class="card">{name}<p class="value">{escaped(value)}</p><p class="note">{note}</p></div>'


def _warnings(writer: Writer, data: ReportData) -> str:
    if not data.warnings:
        return ""
    items = "".join(f"<li>{escaped(warning)}</li>" for warning in data.warnings)
    return f'<aside class="warnings">{writer.say("warnings", "h2")}<ul>{items}</ul></aside>'
