"""The sections of the page below its head (see ``header``), one function each.

Each takes the writer and the report's data and gives HTML, or "" where the run has nothing to show.
"""

import math

from PIL import Image

from pipeline.report import section_plots
from pipeline.report.lens_plots import lens_effect_plot
from pipeline.report.markup import Writer, escaped, number
from pipeline.report.metrics import (
    mean,
    residual_gain,
)
from pipeline.report.pictures import data_address, jpeg_bytes, reduced
from pipeline.report.plots import axis_plot, diameter_plot, time_plot
from pipeline.report.tables import (
    diameters_table,
    lens_effect_table,
    mosaic_table,
    paper_diameters_table,
    surface_prior_table,
    triangulation_table,
)
from pipeline.report.types import Picture, ReportData, UnrolledPicture
from pipeline.report.viewer import ViewerOptions, viewer_record

# What browsers and JPEG bear as one side of a picture.
_MAX_SIDE_PX = 16_000
# From this ratio on the lens correction is worth a claim, either way.
_CLEAR_GAIN = 1.1


def diameters(writer: Writer, data: ReportData) -> str:
    """Table 2, the plot along the cable, the axis, and the paper's Table 2 where truth is known."""
    html = diameters_table(writer, data.stations, data.truth)
    plot = diameter_plot(data.stations, data.truth, data.profile, writer.language)
    caption = "profile_caption" if data.profile is not None else "profile_caption_plain"
    html += writer.figure(plot, writer.say(caption, "figcaption"))
    if data.axis is not None and len(data.axis.position_m):
        caption = writer.say("axis_caption", "figcaption", value=number(data.axis.straightness_mm_per_m, 3))
        html += writer.figure(axis_plot(data.axis, writer.language), caption)
    if data.surface_prior is not None:
        html += surface_prior_table(writer, data.surface_prior)
    if data.truth:
        html += f'<div class="quiet">{paper_diameters_table(writer)}</div>'
    return html


def model(writer: Writer, data: ReportData, options: ViewerOptions) -> str:
    """The 3D view and the record it draws."""
    if data.mesh is None:
        return ""
    boxes = (
        f'<label><input type="checkbox" name="texture" checked>{writer.say("viewer_texture")}</label>'
        f'<label><input type="checkbox" name="turn" checked>{writer.say("viewer_turn")}</label>'
    )
    missing = writer.say("viewer_missing", "p", 'class="missing"')
    record = viewer_record(data.mesh, data.stations, options)
    return (
        '<div id="viewer"><canvas tabindex="0"></canvas><div class="ring-labels"></div>'
        f'<div class="controls">{boxes}</div>{missing}<noscript>{missing}</noscript></div>'
        f"{writer.say('viewer_hint', 'p', 'class="note"')}"
        f'<script type="application/json" id="viewer-data">{record}</script>'
    )


def unrolled(writer: Writer, data: ReportData, max_pixels: int, block_side_px: int) -> str:
    """The unrolled surface, and what each block contributed."""
    html = ""
    if data.unrolled is not None:
        html += _unrolled_figure(writer, data.unrolled, max_pixels)
    if data.block_unrolled:
        figures = [
            writer.figure(
                _surface(picture, block_side_px),
                f"<figcaption>{escaped(picture.name)}</figcaption>",
                "thumbnail",
            )
            for picture in data.block_unrolled
        ]
        heading = writer.say("block_pictures", "h3")
        html += f'<div class="blocks">{heading}<div class="thumbnails">{"".join(figures)}</div></div>'
    return f'<div class="beside">{html}</div>' if html else ""


def _unrolled_figure(writer: Writer, picture: UnrolledPicture, max_pixels: int) -> str:
    height, width = picture.image.shape[:2]
    caption = writer.say(
        "unrolled_caption",
        scale=number(picture.mm_per_px, 3),
        arc=number(width * picture.mm_per_px, 0),
        length=number(height * picture.mm_per_px, 0),
    )
    axes = writer.say(
        "unrolled_axes",
        left=number(picture.theta_range_deg[0], 0),
        right=number(picture.theta_range_deg[1], 0),
        top=number(picture.y_range_m[0], 3),
        bottom=number(picture.y_range_m[1], 3),
    )
    link = writer.say("unrolled_file", "a", 'href="unrolled.png"')
    content = _surface(picture, _MAX_SIDE_PX, max_pixels)
    return writer.figure(content, f"<figcaption>{caption} {axes} {link}</figcaption>", "unrolled")


def sections(writer: Writer, data: ReportData) -> str:
    """The cross sections with their deviation from the circle enlarged."""
    shown = section_plots.shown_stations(data.stations)
    if not shown:
        return ""
    factor = section_plots.exaggeration(shown)
    text = writer.say("sections_caption", factor=str(factor))
    if len(shown) < len(data.stations):
        text += " " + writer.say("sections_some", shown=str(len(shown)), total=str(len(data.stations)))
    plot = section_plots.sections_plot(shown, factor, writer.language)
    return writer.figure(plot, f"<figcaption>{text}</figcaption>")


def triangulation(writer: Writer, data: ReportData) -> str:
    """Table 1."""
    return triangulation_table(writer, data.blocks) if data.blocks else ""


def lens(writer: Writer, data: ReportData, max_side_px: int) -> str:
    """Distortion grid, and a frame before and after (figures 2 and 3 of the paper)."""
    if not data.lens_pictures:
        return ""
    html = writer.say("lens_intro", "p")
    for pictures in data.lens_pictures:
        figures = [
            writer.figure(
                _picture(picture, max_side_px, f"{pictures.block} {key}"),
                writer.say(key, "figcaption"),
                "picture",
            )
            for key, picture in (
                ("grid", pictures.grid),
                ("before", pictures.before),
                ("after", pictures.after),
            )
        ]
        html += f'<h3>{escaped(pictures.block)}</h3><div class="three">{"".join(figures)}</div>'
    return html


def lens_effect(writer: Writer, data: ReportData) -> str:
    """What the correction changes: a sentence, a table, and figures 5 and 6 of the paper."""
    if not data.lens_effects:
        return ""
    html = f'<p class="lead">{_lens_effect_sentence(writer, data)}</p>'
    html += lens_effect_table(writer, data.lens_effects)
    angles_deg = {block.name: block.angle_deg for block in data.blocks}
    for index, effect in enumerate(data.lens_effects):
        if not len(effect.points_corrected_mm) or not len(effect.points_uncorrected_mm):
            continue
        plot = lens_effect_plot(effect, angles_deg.get(effect.block, 0.0), f"effect{index}", writer.language)
        html += writer.figure(plot, writer.say("lens_effect_figure", "figcaption", block=effect.block))
    return html


def _lens_effect_sentence(writer: Writer, data: ReportData) -> str:
    gain = residual_gain(data.lens_effects)
    if not math.isfinite(gain):
        return ""
    if gain >= _CLEAR_GAIN:
        key = "lens_effect_helps"
    else:
        key = "lens_effect_worse" if gain <= 1 / _CLEAR_GAIN else "lens_effect_little"
    sentence = writer.say(
        key,
        factor=number(gain, 1 if gain < 10 else 0),
        without=number(mean([effect.residual_uncorrected_mm for effect in data.lens_effects]), 3),
        corrected=number(mean([effect.residual_corrected_mm for effect in data.lens_effects]), 3),
    )
    if data.truth:
        true_mm = mean([station.diameter_mm for station in data.truth])
        without = [abs(effect.diameter_uncorrected_mm - true_mm) for effect in data.lens_effects]
        corrected = [abs(effect.diameter_corrected_mm - true_mm) for effect in data.lens_effects]
        sentence += " " + writer.say(
            "lens_effect_truth", without=number(mean(without), 2), corrected=number(mean(corrected), 2)
        )
    return sentence


def mosaic(writer: Writer, data: ReportData) -> str:
    """How the blocks were joined."""
    return mosaic_table(writer, data.mosaic) if data.mosaic is not None else ""


def resources(writer: Writer, data: ReportData) -> str:
    """Seconds per stage and peak memory."""
    if not data.timing_s:
        return ""
    caption = writer.say(
        "timing_caption",
        "figcaption",
        total=number(sum(data.timing_s.values()), 1),
        memory=number(data.peak_memory_mb, 0),
    )
    return writer.figure(time_plot(data.timing_s, writer.language), caption)


def file_list(writer: Writer, names: tuple[str, ...]) -> str:
    """The files that lie beside the page, and the frame of reference they are in."""
    if not names:
        return ""
    items = [f'<li><a href="{name}">{name}</a> {writer.say(f"file_{name}")}</li>' for name in names]
    return f'<ul class="files">{"".join(items)}</ul>{writer.say("frame_note", "p", 'class="note"')}'


def _picture(picture: Picture, max_side_px: int, name: str) -> str:
    return _zoomable(reduced(picture, max_side_px), name)


def _surface(picture: UnrolledPicture, max_side_px: int, max_pixels: int | None = None) -> str:
    """A picture of the surface; the page's script reads from the ranges where on the cable a pixel is."""
    ranges = " ".join(f"{edge:g}" for edge in (*picture.theta_range_deg, *picture.y_range_m))
    image = reduced(picture.image, max_side_px, max_pixels)
    return _zoomable(image, picture.name or "unrolled", f' data-ranges="{ranges}"')


def _zoomable(image: Image.Image, name: str, attributes: str = "") -> str:
    address = data_address(jpeg_bytes(image), "image/jpeg")
    picture = f'<img src="{address}" alt="{escaped(name)}">'
    return f'<button class="zoom" type="button"{attributes}>{picture}</button>'
