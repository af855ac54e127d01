"""The page about a scan of a cable joined with its photo model, and the map of how the two differ.

Takes what :mod:`pipeline.scan.join` found; gives one self-contained HTML page in two languages, and a PNG.
Frame, style and language switch are the cable report's.
"""

import io
from collections.abc import Sequence
from importlib.resources import files
from string import Template

import numpy as np
from matplotlib.figure import Figure

from pipeline.core.vocabulary import Array
from pipeline.report.labels import Label, Language, label
from pipeline.report.markup import Row, Writer, escaped, number, signed, thousands
from pipeline.report.pictures import data_address
from pipeline.report.svg import plot_style
from pipeline.scan.finished import FinishedRun
from pipeline.scan.held import held_ways, screw_mm_per_degree
from pipeline.scan.join import ScanJoin

CELL_MM = 5.0
LEAST_IN_CELL = 3


def deviation_map(found: ScanJoin, run: FinishedRun) -> tuple[Array, tuple[float, float, float, float]]:
    """Mean deviation (rows along, around), mm, NaN where too few points are; and the extent, mm."""
    around_mm = 2000 * np.pi * run.radius_m
    columns = round(around_mm / CELL_MM)
    low, high = 1000 * run.position_m[0], 1000 * run.position_m[-1]
    rows = max(int(np.ceil((high - low) / CELL_MM)), 1)
    row = np.floor((1000 * found.position_m[found.kept] - low) / CELL_MM).astype(np.int64)
    column = np.floor(found.theta[found.kept] / (2 * np.pi) * columns).astype(np.int64) % columns
    inside = (row >= 0) & (row < rows)
    cell = row[inside] * columns + column[inside]
    count = np.bincount(cell, minlength=rows * columns)
    total = np.bincount(cell, found.deviations_mm[found.kept][inside], minlength=rows * columns)
    mean = np.where(count >= LEAST_IN_CELL, total / np.maximum(count, 1), np.nan).reshape(rows, columns)
    return mean, (low, low + rows * CELL_MM, 0.0, around_mm)


def deviation_png(found: ScanJoin, run: FinishedRun) -> bytes:
    """The map as a picture: the cable runs to the right, azimuth upwards; red lies farther out."""
    mean, extent = deviation_map(found, run)
    reach = max(float(np.nanpercentile(np.abs(mean), 99)) if np.isfinite(mean).any() else 0.0, 0.05)
    with plot_style():
        figure = Figure(figsize=(9.0, 4.2), layout="constrained")
        axes = figure.add_subplot()
        axes.grid(visible=False)
        drawn = axes.imshow(
            mean.T, extent=extent, origin="lower", cmap="RdBu_r", vmin=-reach, vmax=reach, aspect="auto"
        )
        for station in found.diameters:
            axes.axvline(1000 * station.position_m, color="#22303c", linewidth=0.7, linestyle=":")
            axes.annotate(station.name, (1000 * station.position_m, extent[3]), ha="center", va="bottom")
        axes.set_xlabel("y  mm")
        axes.set_ylabel("r · a  mm")
        figure.colorbar(drawn, ax=axes, label="mm")
        stream = io.BytesIO()
        figure.savefig(stream, format="png", dpi=130)
    return stream.getvalue()


def scan_html(
    found: ScanJoin, run: FinishedRun, scans: Sequence[str], beside: Sequence[str], language: Language
) -> str:
    """The whole page as one string; ``beside`` are the files that lie beside it."""
    writer = Writer(language=language)
    picture = data_address(deviation_png(found, run), "image/png")
    image = f'<img src="{picture}" alt="{escaped(label("scan_deviation").text(language))}">'
    caption = writer.say("scan_deviation_caption", "figcaption")
    items = "".join(f'<li><a href="{name}">{name}</a> {writer.say(f"file_{name}")}</li>' for name in beside)
    parts = (
        ("scan_held", _held_table(writer, found, run)),
        ("scan_deviation", writer.figure(image, caption)),
        ("scan_diameters", _diameters_table(writer, found)),
        ("files", f'<ul class="files">{items}</ul>{writer.say("frame_note", "p", 'class="note"')}'),
    )
    return Template(_shared("template.html")).substitute(
        language=language,
        title=f"{escaped(run.name)} · CableTwin",
        style=_shared("style.css"),
        header=_header(writer, found, run, scans),
        contents="".join(writer.say(key, "a", f'href="#{key}"') for key, _ in parts),
        main="".join(f'<section id="{key}">{writer.say(key, "h2")}{body}</section>' for key, body in parts),
        close=writer.say("close", "button", 'class="close" type="button"'),
        point_at=writer.template("point_at", "span", 'class="where" hidden'),
        actual_size=writer.say("actual_size", "button", 'class="size" type="button"'),
        script=_shared("page.js"),
        viewer_script="",
    )


def _header(writer: Writer, found: ScanJoin, run: FinishedRun, scans: Sequence[str]) -> str:
    facts = [writer.say("scan_points", value=thousands(len(found.scan))), *(escaped(name) for name in scans)]
    sigma = number(100 * found.scale_sigma, 3)
    cards = (
        ("scan_card_scale", number(found.scale, 5), writer.say("scan_card_scale_note", value=sigma)),
        ("scan_card_mean", f"{signed(found.mean_mm, 3)} mm", writer.say("scan_card_mean_note")),
        (
            "scan_card_rms",
            f"{number(found.rms_mm, 2)} mm",
            writer.say("scan_card_rms_note", value=number(found.noise_mm, 2)),
        ),
        ("scan_card_coverage", f"{number(100 * found.coverage, 0)} %", writer.say("scan_card_coverage_note")),
    )
    boxes = "".join(
        f'<div class="card">{writer.say(key, "p", 'class="name"')}<p class="value">{escaped(value)}</p>'
        f'<p class="note">{note}</p></div>'
        for key, value, note in cards
    )
    return (
        f'<p class="kind">{writer.say("scan_title")}</p><h1>{escaped(run.name)}</h1>'
        f'{writer.say("scan_subtitle", "p", 'class="subtitle"')}<p class="facts">{" · ".join(facts)}</p>'
        f'<div class="cards">{boxes}</div>'
    )


def _held_table(writer: Writer, found: ScanJoin, run: FinishedRun) -> str:
    rows, ways = [], held_ways(found.fusion, run.radius_m, run.middle_m)
    for way in ways:
        size = 100 * way.sigma if way.unit == "share" else way.sigma
        unit = {"share": "%", "deg": "°", "mm": "mm"}[way.unit]
        known = number(size, 3) + f" {unit}"
        rows.append(
            Row(
                head=writer.say(f"scan_{way.name}", "th", 'scope="row"'),
                cells=(known, way.held_by) if way.determined else ("–", label("scan_open")),
            )
        )
    head = [writer.say(key, "th", 'scope="col"') for key in ("scan_way", "scan_sigma", "scan_by")]
    screw = screw_mm_per_degree(found.fusion, run.middle_m)
    note = ""
    if screw is not None and any(not way.determined for way in ways):
        note = writer.say("scan_screw", "p", 'class="note"', value=signed(screw, 2))
    return writer.table(writer.say("scan_held_caption", "figcaption"), head, rows, note)


def _diameters_table(writer: Writer, found: ScanJoin) -> str:
    keys = ("scan_station", "scan_position", "scan_photo", "scan_sigma", "scan_scan", "scan_sigma")
    head = [writer.say(key, "th", 'scope="col"') for key in (*keys, "scan_difference", "scan_seen")]
    rows = [
        Row(
            head=writer.element(Label(en=row.name, zh=row.name), "th", 'scope="row"'),
            cells=(
                number(row.position_m, 3),
                number(row.photo_mm, 3),
                number(row.photo_sigma_mm, 3),
                number(row.scan_mm, 3),
                number(row.scan_sigma_mm, 3),
                signed(row.scan_mm - row.photo_mm, 3),
                number(row.coverage_deg, 0),
            ),
        )
        for row in found.diameters
    ]
    return writer.table(writer.say("scan_diameters_caption", "figcaption"), head, rows)


def _shared(name: str) -> str:
    return files("pipeline.report").joinpath(name).read_text(encoding="utf-8")
