"""The sections of the steel page below its head, one function each; "" where the run has nothing to show."""

import math

from pipeline.evaluate.steel.records import SteelEvaluation
from pipeline.report.markup import Row, Writer, escaped, number, thousands
from pipeline.report.plots import time_plot
from pipeline.report.steel import model, registration_plots, structure_plots, tables
from pipeline.report.steel.chain_plots import chain_plot
from pipeline.report.steel.gross import GrossGroup, grouped
from pipeline.report.steel.records import FusionSummary, SteelReport
from pipeline.report.steel.residuals import coordinate_residuals, point_residual_mm
from pipeline.report.steel.scaling import largest
from pipeline.report.steel.structure_plots import judged
from pipeline.report.steel.viewer import viewer_element
from pipeline.steel.registration_records import GrossKind


def registration(writer: Writer, report: SteelReport) -> str:
    """Plan, gross errors, stations, components, residuals."""
    counted = {kind: sum(row.kind == kind for row in report.targets) for kind in ("point", "line", "plane")}
    html = writer.say(
        "steel_registration_lead",
        "p",
        'class="lead"',
        stations=str(len(report.stations)),
        targets=str(counted["point"]),
        rounds=str(report.rounds),
        observations=thousands(len(report.residuals)),
        rms=number(point_residual_mm(report), 2),
    )
    if counted["line"] + counted["plane"]:
        axes, planes = str(counted["line"]), str(counted["plane"])
        html += writer.say("steel_registration_figures", "p", axes=axes, planes=planes)
    factor = thousands(registration_plots.ellipse_factor(report))
    caption = writer.say("steel_plan_caption", "figcaption", factor=factor)
    html += writer.figure(registration_plots.network_plot(report, writer.language), caption)
    html += _gross(writer, report) + tables.stations_table(writer, report)
    parts = tables.components_table(writer, report.components) if report.components else ""
    values = coordinate_residuals(report)
    if len(values):
        sigma = number(float((values**2).mean() ** 0.5), 2)
        caption = writer.say("steel_residuals_caption", "figcaption", sigma=sigma)
        parts += writer.figure(registration_plots.residual_plot(report, writer.language), caption)
    return html + (f'<div class="pair">{parts}</div>' if parts else "")


def _gross(writer: Writer, report: SteelReport) -> str:
    heading = writer.say("steel_gross_heading", "h3")
    if not report.gross:
        return heading + writer.say("steel_gross_none", "p")
    items = "".join(f"<li>{_gross_sentence(writer, group)}</li>" for group in grouped(report.gross))
    return f'{heading}{writer.say("steel_gross_lead", "p")}<ul class="gross">{items}</ul>'


def _gross_sentence(writer: Writer, group: GrossGroup) -> str:
    error = group.first
    who = {"station": error.station, "target": error.target}
    if error.kind is GrossKind.MISNAMED:
        said = [writer.say("steel_gross_misnamed", **who, size=number(error.size_mm / 1000, 2))]
    elif len(group.together) == 1:
        size = {"size": number(error.size_mm, 1), "sigma": number(error.sigma_mm, 1)}
        said = [writer.say("steel_gross_moved", **who, **size)]
    else:
        sizes = [row.size_mm for row in group.errors]
        ends = {"least": number(min(sizes), 1), "most": number(max(sizes), 1)}
        who = {"target": error.target, "stations": ", ".join(group.together)}
        said = [writer.say("steel_gross_moved_many", **who, **ends)]
    if error.fits:
        said.append(writer.say("steel_gross_fits", fits=error.fits))
    if error.instead:
        said.append(writer.say("steel_gross_instead", instead=error.instead))
    return " ".join(said)


def chain(writer: Writer, report: SteelReport, truth: SteelEvaluation | None) -> str:
    """How the error grows station by station, and how it does not in the adjustment."""
    rows = report.comparison
    icp_pairs = tables.icp_table(writer, report.icp_pairs) if report.icp_pairs else ""
    if len(rows) < 2:  # only the base: no other station could be chained
        return icp_pairs
    last = max(row.position for row in rows)
    ends = [row for row in rows if row.position == last]
    html = writer.say(
        "steel_chain_lead",
        "span",
        chained=number(largest(row.chained_offset_mm for row in ends), 1),
        chained_sigma=number(largest(row.chained_sigma_mm for row in ends), 1),
        adjusted_sigma=number(largest(row.adjusted_sigma_mm for row in ends), 1),
    )
    icp = [row.icp_offset_mm for row in rows if math.isfinite(row.icp_offset_mm)]
    if icp:
        html += " " + writer.say("steel_chain_icp", icp=number(largest(icp), 1))
    html = f'<p class="lead">{html}</p>'
    errors = truth.stations.entries if truth is not None else ()
    plot = chain_plot(rows, errors, writer.language)
    caption = "steel_chain_truth_caption" if errors else "steel_chain_caption"
    html += writer.figure(plot, writer.say(caption, "figcaption"))
    return html + icp_pairs


def structure(writer: Writer, report: SteelReport) -> str:
    """The 3D view of the fitted members."""
    if not (report.rods or report.balls or report.uprights or report.columns):
        return ""
    counts = {
        "rods": thousands(len(report.rods)),
        "balls": thousands(len(report.balls)),
        "columns": thousands(len(report.uprights)),
    }
    hints = [writer.say("steel_viewer_hint")]
    if report.columns:
        hints.append(writer.say("steel_viewer_lean", factor=thousands(model.lean_factor(report))))
    if any(row.significant for row in report.nodes):
        hints.append(writer.say("steel_viewer_apart", factor=thousands(model.eccentricity_factor(report))))
    hint = f'<p class="note">{" ".join(hints)}</p>'
    return writer.say("steel_members_caption", "p", **counts) + viewer_element(writer, report) + hint


def columns(writer: Writer, report: SteelReport) -> str:
    """Plan with arrows, and Table 1."""
    if not report.columns:
        return ""
    worst = max(report.columns, key=lambda row: row.deviation_mm)
    limits = {row.limit_mm for row in report.columns}
    said = writer.say(
        "steel_columns_lead",
        over=str(sum(row.over_limit for row in report.columns)),
        count=str(len(report.columns)),
        limit=number(max(limits), 0),
        name=worst.name,
        largest=number(worst.deviation_mm, 1),
    )
    unsure = sum(not row.certain for row in report.columns)
    if unsure:
        said += " " + writer.say("steel_columns_unsure", count=str(unsure))
    factor = thousands(structure_plots.column_plan_factor(report.columns))
    caption = writer.say("steel_columns_plan", "figcaption", factor=factor)
    plot = writer.figure(structure_plots.columns_plot(report, writer.language), caption)
    return f'<p class="lead">{said}</p>{plot}{tables.columns_table(writer, report.columns)}'


def nodes(writer: Writer, report: SteelReport) -> str:
    """Plan with arrows, sizes in order, table."""
    found = judged(report.nodes)
    if not found:
        return ""
    loud = sum(row.significant for row in found)
    count = {"count": str(len(found))}
    if loud:
        html = writer.say("steel_nodes_lead", "p", 'class="lead"', significant=str(loud), **count)
        factor = thousands(structure_plots.node_plan_factor(found))
        caption = writer.say("steel_nodes_plan", "figcaption", factor=factor)
        html += writer.figure(structure_plots.nodes_plot(report, writer.language), caption)
    else:
        html = writer.say("steel_nodes_none", "p", 'class="lead"', **count)
    sizes = structure_plots.sizes_plot(report, writer.language)
    html += writer.figure(sizes, writer.say("steel_nodes_sizes", "figcaption"))
    return html + tables.nodes_table(writer, found)


def deflection(writer: Writer, report: SteelReport) -> str:
    """The verdict, the grid from above, and along the structure."""
    found = report.deflection
    if found is None or not found.rows:
        return ""
    said = writer.say(
        "steel_deflection_lead",
        largest=number(found.largest_mm, 1),
        sigma=number(found.largest_sigma_mm, 1),
        node=found.largest_node,
        ratio=thousands(1000 * found.span_m / found.largest_mm) if found.largest_mm > 0 else "∞",
        span=number(found.span_m, 2),
    )
    verdict = "steel_deflection_fails" if found.over_limit else "steel_deflection_holds"
    said += " " + writer.say(verdict, limit=number(found.limit_mm, 1))
    html = f'<p class="lead">{said}</p>'
    plan = structure_plots.deflection_plot(report, found, writer.language)
    html += writer.figure(plan, writer.say("steel_deflection_caption", "figcaption"))
    profile = structure_plots.profile_plot(found, writer.language)
    return html + writer.figure(profile, writer.say("steel_deflection_profile", "figcaption"))


def fusion(writer: Writer, report: SteelReport) -> str:
    """How well photos and scans lie together."""
    found = report.fusion
    if found is None:
        return ""
    html = writer.say(
        "steel_fusion_lead",
        "p",
        'class="lead"',
        median=number(found.median_mm, 2),
        overlap=number(found.overlap_percent, 0),
        scale=number(found.scale_sigma_percent, 3),
    )
    if found.undetermined:
        html += writer.say("steel_fusion_undetermined", "p", value="; ".join(found.undetermined))
    html += "".join(f'<p class="note">{escaped(note)}</p>' for note in found.notes)
    return html + (_fusion_pairs(writer, found) if found.pairs else "")


def _fusion_pairs(writer: Writer, found: FusionSummary) -> str:
    rows = [Row(head=tables.name_cell(name), cells=[number(size, 2)]) for name, size in found.pairs]
    heads = tables.head(writer, ["steel_target_name", "steel_residual_mm"])
    caption = writer.say("steel_fusion_pairs", "figcaption")
    return tables.boxed(writer.table(caption, heads, rows), len(rows))


def beside_the_paper(writer: Writer, report: SteelReport) -> str:
    """The paper's figures, and its Table 1 where columns were judged."""
    html = tables.paper_table(writer, report, point_residual_mm(report))
    if report.columns:
        html += tables.paper_columns_table(writer)
    return f'<div class="pair">{html}</div>'


def resources(writer: Writer, report: SteelReport) -> str:
    """Seconds per stage and peak memory."""
    if not report.timing_s:
        return ""
    caption = writer.say(
        "timing_caption",
        "figcaption",
        total=number(sum(report.timing_s.values()), 1),
        memory=number(report.peak_memory_mb, 0),
    )
    return writer.figure(time_plot(report.timing_s, writer.language), caption)


def file_list(writer: Writer, report: SteelReport, names: tuple[str, ...]) -> str:
    """The files that lie beside the page, and the frame of reference they are in."""
    if not names:
        return ""
    keys = {"cloud.ply": "steel_file_cloud"}
    items = [
        f'<li><a href="{name}">{name}</a> {writer.say(keys.get(name, f"file_{name}"))}</li>' for name in names
    ]
    north = number(report.north_deg, 2)
    note = (
        writer.say("steel_frame_base", "p", 'class="note"', name=report.base, north=north)
        if report.base
        else writer.say("steel_frame_control", "p", 'class="note"', north=north)
    )
    return f'<ul class="files">{"".join(items)}</ul>{note}'
