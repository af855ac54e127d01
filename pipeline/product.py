"""From a survey to the finished run folder: the stages, then everything a person opens.

This is the one call that the command line, the Blender extension and the benchmarks make.
"""

import time
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from pipeline.cable.pairs import read_pairs
from pipeline.cable.records import CableRun
from pipeline.cable.run import STAGES, bind_options, run_cable
from pipeline.cable.survey import Survey
from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event
from pipeline.core.files import replacing, write_json
from pipeline.core.memory import peak_memory_mb
from pipeline.core.runfolder import RunFolder
from pipeline.evaluate.documents import read_document
from pipeline.report.block_files import write_block_files
from pipeline.report.collect import collect
from pipeline.report.exports import (
    write_cloud_ply,
    write_diameters_csv,
    write_model_glb,
    write_model_ply,
    write_report_json,
    write_unrolled_png,
)
from pipeline.report.labels import Language
from pipeline.report.metrics import compare_with_truth, mean_absolute_error_mm
from pipeline.report.model import ring_cloud
from pipeline.report.types import ReportData, TruthStation
from pipeline.set_aside import drop_set_aside, none_if_refused, set_aside


def make_product(
    survey: Survey,
    out: Path,
    emit: Emit,
    *,
    assignments: tuple[str, ...] = (),
    start: str | None = None,
    only: str | None = None,
    pairs: Path | None = None,
    truth: Path | None = None,
    language: Language = "en",
) -> str:
    """Run the pipeline and write the product.

    Once anything is made again, or the run is refused, what an earlier run left to be opened lies in
    ``OUT/outdated`` (:mod:`pipeline.set_aside`), until the new files are there.

    Args:
        survey: what to work on.
        out: the run folder.
        emit: progress; may raise Cancelled.
        assignments: ``STAGE.key=value`` words that override options.
        start: make this stage and all after it again.
        only: make this stage again and stop behind it.
        pairs: corresponding points chosen by hand.
        truth: truth.json; the report then compares with it.
        language: of the report, "en" or "zh".

    Returns:
        What to tell the person: the table of diameters and the files to open.

    Raises:
        StageError: bad input.
    """
    with none_if_refused(out):
        options = bind_options(survey, assignments)
        true = _truth_stations(truth, survey)
        if pairs:
            read_pairs(pairs, tuple(b.name for b in survey.blocks))  # tells now, and not minutes later
        folder = _folder(out, start, only)
        write_json(folder.path / "options.json", options, "run")
        last = only if only and only != "report" else STAGES[-1]
        found = run_cable(survey, options, folder, emit, pairs, last)
        if found is None or (only and only != "report"):
            return f"{only} is done in {out}"
        data = _write(found, folder, true, language, emit)
    return _summary(data, out)


def _folder(out: Path, start: str | None, only: str | None) -> RunFolder:
    stages = (*STAGES, "report")
    fresh = frozenset(stages[stages.index(start) :] if start else (only,) if only else ())
    allowed = None if only in (None, "report") else frozenset({only or ""})
    return RunFolder(out, fresh, allowed, before_making=partial(set_aside, out))


def _write(
    found: CableRun, folder: RunFolder, truth: tuple[TruthStation, ...], language: Language, emit: Emit
) -> ReportData:
    """Everything a person opens; report.json last, so that it stands for a whole product."""
    # its plots load Matplotlib, which a refused survey should not wait for
    from pipeline.report.page import PageOptions, write_report_html

    began, out = time.monotonic(), folder.path
    set_aside(out)
    steps = 5
    emit(Event(stage="report", done=0, total=steps))
    write_block_files(found, out / "blocks")
    emit(Event(stage="report", done=1, total=steps))
    data = collect(found, truth, folder.stage_seconds(), peak_memory_mb())
    emit(Event(stage="report", done=2, total=steps))
    if data.mesh is not None:
        write_model_ply(out / "model.ply", data.mesh)
        write_model_glb(out / "model.glb", data.mesh)
    write_cloud_ply(out / "cloud.ply", ring_cloud(found.ring))
    emit(Event(stage="report", done=3, total=steps))
    if data.unrolled is not None:
        write_unrolled_png(out / "unrolled.png", data.unrolled)
    write_diameters_csv(out / "diameters.csv", data.stations, data.truth)
    with replacing(out / "radius_map.npz", "report") as temporary, temporary.open("wb") as file:
        np.savez_compressed(
            file,
            theta_deg=np.rad2deg(found.ring.azimuth),
            position_m=found.ring.y_m,
            radius_mm=1000 * np.where(found.ring.measured, found.ring.radius_m, np.nan),
        )
    emit(Event(stage="report", done=4, total=steps))
    folder.note_time("report", "", time.monotonic() - began)
    data = replace(data, timing_s=folder.stage_seconds(), peak_memory_mb=peak_memory_mb())
    write_report_html(out / "report.html", data, PageOptions(language=language))
    write_report_json(out / "report.json", data)
    drop_set_aside(out)
    emit(Event(stage="report", done=1, total=1))
    return data


def _truth_stations(path: Path | None, survey: Survey) -> tuple[TruthStation, ...]:
    if path is None:
        return ()
    known = tuple(
        TruthStation(
            name=s.text("name"), position_m=s.number("position_m"), diameter_mm=s.number("diameter_mm")
        )
        for s in read_document(path).items("stations")
    )
    names = [s.name for s in survey.cable.stations]
    if not any(s.name in names for s in known):
        raise StageError(
            "run",
            f"{path} knows none of the survey's stations {', '.join(names[:5])}",
            "give the truth of this survey",
        )
    return known


def _summary(data: ReportData, out: Path) -> str:
    compared = compare_with_truth(data.stations, data.truth)
    lines = [
        "station  position m  diameter mm  sigma mm" + ("   truth mm  difference mm" if compared else "")
    ]
    for s in data.stations:
        line = f"{s.name:8s} {s.position_m:10.3f} {s.diameter_mm:12.3f} {s.sigma_mm:9.3f}"
        if s.name in compared:
            row = compared[s.name]
            line += f" {row.truth_mm:10.3f} {row.difference_mm:+14.3f}"
        lines.append(line)
    if compared:
        mae = mean_absolute_error_mm(compared)
        lines.append(f"mean absolute error {mae:.3f} mm (paper: 1.0053 mm)")
    lines.append("")
    lines.extend(
        f"{what:7s} {out / name}" for what, name in (("model", "model.glb"), ("report", "report.html"))
    )
    return "\n".join(lines)
