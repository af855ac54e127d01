"""The tables of the page: Table 1, Table 2, the paper's Table 2, lens effect, mosaic.

Takes records of ``types`` and a :class:`~pipeline.report.markup.Writer`, gives HTML.
"""

import math

from pipeline.report import paper
from pipeline.report.labels import TEXTS, Label, label
from pipeline.report.markup import DASH, Row, Writer, escaped, number, signed, thousands
from pipeline.report.metrics import compare_with_truth, mean_absolute_error_mm
from pipeline.report.types import (
    BlockSummary,
    LensEffect,
    MosaicSummary,
    StationResult,
    SurfacePriorSummary,
    TruthStation,
)

_STATION_COLUMNS = ("position_m", "diameter_mm", "sigma_mm", "min_mm", "max_mm", "coverage_deg")
_BASE_COLUMN = ("base_diameter_mm",)
_TRUTH_COLUMNS = ("truth_mm", "difference_mm", "relative_percent")

VISIBLE_READOUT_MM = 0.1


def _name(text: str) -> str:
    return f'<th scope="row">{escaped(text)}</th>'


def triangulation_table(writer: Writer, blocks: tuple[BlockSummary, ...]) -> str:
    """Table 1: a column for each block, and the paper's Block1 beside them."""
    lines: list[tuple[str, list[str | Label], str]] = [
        ("images", [str(block.images) for block in blocks], str(paper.IMAGES)),
        (
            "calibrated",
            [_calibrated(block.calibrated, block.images) for block in blocks],
            _calibrated(paper.CALIBRATED, paper.IMAGES),
        ),
        (
            "keypoints",
            [thousands(block.keypoints_per_image) for block in blocks],
            str(paper.KEYPOINTS_PER_IMAGE),
        ),
        (
            "reprojection_px",
            [number(block.reprojection_px, 3) for block in blocks],
            number(paper.REPROJECTION_PX, 2),
        ),
        ("coverage_m2", [number(block.coverage_m2, 4) for block in blocks], ""),
        ("resolution_mm", [number(block.resolution_mm, 3) for block in blocks], ""),
        ("angle_deg", [number(block.angle_deg, 0) for block in blocks], DASH),
        ("focal_px", [number(block.focal_px, 2) for block in blocks], DASH),
        ("division_lambda", [_lambda(block) for block in blocks], number(paper.DIVISION_LAMBDA, 2)),
        ("lambda_radius", [_known("radius", block.lambda_radius) for block in blocks], DASH),
        ("lens_method", [_known("method", block.lens_method) for block in blocks], DASH),
    ]
    papers = {
        "coverage_m2": writer.say("units2", value=thousands(paper.COVERAGE_UNITS2)),
        "resolution_mm": writer.say("units_per_px", value=number(paper.RESOLUTION_UNITS, 1)),
    }
    rows = []
    for key, cells, printed in lines:
        head = writer.say(key, "th", 'scope="row"')
        last = f'<td class="paper">{papers.get(key, escaped(printed))}</td>'
        rows.append(Row(head=head, cells=cells, tail=last))
    heads = [writer.say("property", "th", 'scope="col"')]
    heads += [f'<th scope="col">{escaped(block.name)}</th>' for block in blocks]
    heads.append(writer.say("paper_block1", "th", 'scope="col" class="paper"'))
    return writer.table(writer.say("triangulation_caption", "figcaption"), heads, rows)


def _known(kind: str, text: str) -> str | Label:
    """The text in both languages where it is one of ours, else as it is."""
    return label(f"{kind}_{text}") if f"{kind}_{text}" in TEXTS else text


def _calibrated(calibrated: int, images: int) -> str:
    percent = f" ({100 * calibrated / images:.0f} %)" if images else ""
    return f"{calibrated} / {images}{percent}"


def _lambda(block: BlockSummary) -> str:
    sigma = f" ± {block.lambda_sigma:.4f}" if block.lambda_sigma > 0 else ""
    return number(block.division_lambda, 4) + sigma


def diameters_table(
    writer: Writer, stations: tuple[StationResult, ...], truth: tuple[TruthStation, ...]
) -> str:
    """Table 2: the stations; with truth also the differences and the mean absolute error."""
    compared = compare_with_truth(stations, truth)
    based = any(_base_differs(station) for station in stations)
    columns = _STATION_COLUMNS + (_BASE_COLUMN if based else ()) + (_TRUTH_COLUMNS if compared else ())
    heads = [writer.say(key, "th", 'scope="col"') for key in ("station", *columns)]
    rows = []
    for station in stations:
        cells = _station_cells(station)
        if based:
            cells.append(number(station.base_diameter_mm, 3) if _base_differs(station) else "")
        if station.name in compared:
            row = compared[station.name]
            cells += [number(row.truth_mm, 3), signed(row.difference_mm, 3), number(row.relative_percent, 3)]
        elif compared:
            cells += [DASH] * len(_TRUTH_COLUMNS)
        rows.append(Row(head=_name(station.name), cells=cells))
    note = writer.say("diameters_note" if compared else "diameters_note_plain", "p", 'class="note"')
    if compared:
        rows.append(_error_row(writer, columns, mean_absolute_error_mm(compared)))
    return writer.table(writer.say("diameters_caption", "figcaption"), heads, rows, note)


def _base_differs(station: StationResult) -> bool:
    """Whether what stands proud or is dented changes the mean diameter by more than its sigma."""
    return abs(station.base_diameter_mm - station.diameter_mm) > station.sigma_mm


def _station_cells(station: StationResult) -> list[str]:
    return [
        number(station.position_m, 3),
        number(station.diameter_mm, 3),
        number(station.sigma_mm, 3),
        number(station.min_mm, 3),
        number(station.max_mm, 3),
        number(station.coverage_deg, 0),
    ]


def _error_row(writer: Writer, columns: tuple[str, ...], error_mm: float) -> Row:
    """The last row: mean absolute error under the differences, the paper's beside it."""
    span = len(columns) - 1
    head = writer.say("mae", "th", f'scope="row" colspan="{span}"')
    paper_cell = writer.say("mae_note", "td", 'class="paper"')
    return Row(head=head, cells=[f"{number(error_mm, 4)} mm"], kind="total", tail=paper_cell)


def paper_diameters_table(writer: Writer) -> str:
    """Table 2 of the paper as printed, with the remark on what is printed wrong."""
    keys = ("station", "diameter_mm", *_TRUTH_COLUMNS)
    heads = [writer.say(key, "th", 'scope="col"') for key in keys]
    rows = [
        Row(
            head=_name(row.name),
            cells=[
                number(row.model_mm, 3),
                number(row.truth_mm, 1),
                signed(row.difference_mm, 3),
                number(row.relative_percent, 3),
            ],
        )
        for row in paper.TABLE_2
    ]
    head = writer.say("mae", "th", 'scope="row" colspan="4"')
    rows.append(Row(head=head, cells=[f"{paper.MEAN_ABSOLUTE_ERROR_MM} mm"], kind="total"))
    note = writer.say("paper_diameters_note", "p", 'class="note"')
    return writer.table(writer.say("paper_diameters_caption", "figcaption"), heads, rows, note)


def lens_effect_table(writer: Writer, effects: tuple[LensEffect, ...]) -> str:
    """What each block alone gives without and with the lens correction."""
    keys = (
        ("diameter_without", "diameter_uncorrected_mm"),
        ("diameter_with", "diameter_corrected_mm"),
        ("residual_without", "residual_uncorrected_mm"),
        ("residual_with", "residual_corrected_mm"),
        ("bow_without", "bow_uncorrected_mm"),
        ("bow_with", "bow_corrected_mm"),
    )
    heads = [writer.say(key, "th", 'scope="col"') for key in ("block", *(key for key, _ in keys))]
    rows = [
        Row(head=_name(effect.block), cells=[number(getattr(effect, field), 3) for _, field in keys])
        for effect in effects
    ]
    return writer.table(writer.say("lens_effect_caption", "figcaption"), heads, rows)


def surface_prior_table(writer: Writer, prior: SurfacePriorSummary) -> str:
    """Each station's diameter without and with the surface prior."""
    keys = (
        *("station", "prior_without_mm", "prior_with_mm", "difference_mm"),
        *("prior_without_sigma_mm", "prior_with_sigma_mm"),
    )
    heads = [writer.say(key, "th", 'scope="col"') for key in keys]
    rows = [
        Row(
            head=_name(s.name),
            cells=[
                number(s.without_mm, 3),
                number(s.with_mm, 3),
                signed(s.with_mm - s.without_mm, 3),
                number(s.without_sigma_mm, 3),
                number(s.with_sigma_mm, 3),
            ],
        )
        for s in prior.stations
    ]
    caption = writer.say("surface_prior_caption", "figcaption", sigma=number(prior.sigma_mm, 2))
    note = writer.say(f"surface_prior_{'used' if prior.used else 'unused'}", "p", 'class="note"')
    return writer.table(caption, heads, rows, note)


def _rolling_shutter(writer: Writer, mosaic: MosaicSummary) -> str:
    """A sentence where the frames show one that an eye could see, beyond doubt."""
    if not abs(mosaic.readout_mm) > max(4 * mosaic.readout_sigma_mm, VISIBLE_READOUT_MM):
        return ""
    values = {"value": number(mosaic.readout_mm, 2), "sigma": number(mosaic.readout_sigma_mm, 2)}
    return writer.say("rolling_shutter", "p", 'class="note"', **values)


def mosaic_table(writer: Writer, mosaic: MosaicSummary) -> str:
    """The joints between neighbours, and below them each block's scale correction."""
    heads = [writer.say(key, "th", 'scope="col"') for key in ("joint", "pairs", "joint_residual")]
    rows = [
        Row(
            head=_name(f"{joint.first} – {joint.second}"),
            cells=[str(joint.pairs), number(joint.residual_mm, 3)],
        )
        for joint in mosaic.joints
    ]
    together = math.isfinite(mosaic.shared_residual_px)
    caption = writer.say(
        "together_caption" if together else "mosaic_caption",
        "figcaption",
        value=thousands(mosaic.tie_points),
        residual=number(mosaic.shared_residual_px, 2),
    )
    joints = writer.table(caption, heads, rows) + _rolling_shutter(writer, mosaic)
    if together or not mosaic.scale_corrections:
        return joints
    heads = [writer.say(key, "th", 'scope="col"') for key in ("block", "scale_correction")]
    rows = [
        Row(head=_name(block), cells=[f"{number(scale, 6)} ({signed(1e6 * (scale - 1), 0)} ppm)"])
        for block, scale in mosaic.scale_corrections.items()
    ]
    scales = writer.table(writer.say("scale_caption", "figcaption"), heads, rows)
    return f'<div class="pair">{joints}{scales}</div>'
