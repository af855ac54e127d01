"""Everything that a person opens, written from a finished steel run: tables, model, cloud, page, report.json.

Takes a :class:`~pipeline.steel.steel_run.SteelRun` and the run folder; gives what the report tells.
report.json comes last, so that it stands for a whole product.
"""

import time
from dataclasses import replace
from pathlib import Path

from pipeline.core.events import Emit, Event, part
from pipeline.core.files import plain, write_bytes, write_json
from pipeline.core.memory import peak_memory_mb
from pipeline.core.runfolder import RunFolder
from pipeline.evaluate.documents import Document, read_document
from pipeline.evaluate.steel import evaluate_steel
from pipeline.evaluate.steel.records import SteelEvaluation
from pipeline.report.labels import Language
from pipeline.report.steel.cloud import write_cloud
from pipeline.report.steel.collect import collect
from pipeline.report.steel.document import report_tree
from pipeline.report.steel.records import SteelReport
from pipeline.report.steel.spreadsheets import write_spreadsheets
from pipeline.steel.merged_cloud import write_merged
from pipeline.steel.scan_cloud import scan_cloud
from pipeline.steel.steel_run import SteelRun

MERGED = "merged.ply"
"""Scans and photos in one cloud."""


def write_steel_run(
    found: SteelRun, folder: RunFolder, truth: Path | None, language: Language, emit: Emit
) -> SteelReport:
    """Write all files of the product into the run folder.

    Args:
        found: everything found.
        folder: where to write; knows how long the stages took.
        truth: truth.json, where there is one: the page then compares with it.
        language: that the page opens in.
        emit: progress; may raise Cancelled.

    Raises:
        StageError: the folder cannot be written, or truth and run do not belong together.
    """
    began, out = time.monotonic(), folder.path
    emit(Event(stage="report", done=0, total=1))
    report = collect(found, folder.stage_seconds(), peak_memory_mb())
    compared = None if truth is None else _compare(out, report, truth)
    names = ["report.json", *write_spreadsheets(out, report), *_models(out, report)]
    emit(Event(stage="report", done=2, total=10))
    if found.tiles is not None and len(found.tiles.cells):
        write_cloud(out / "cloud.ply", found.tiles, part(emit, 0.2, 0.7))
        names.append("cloud.ply")
    if found.fusion is not None and found.photo_cloud is not None and found.tiles is not None:
        scan = scan_cloud(found.tiles, _as_report(part(emit, 0.7, 0.9)))
        stations = tuple(pose.name for pose in found.tiles.stations)
        write_merged(out / MERGED, found.photo_cloud, scan, found.fusion, stations)
        names.append(MERGED)
    emit(Event(stage="report", done=9, total=10))
    _write_page(out / "report.html", report, compared, tuple(names), language)
    folder.note_time("report", "", time.monotonic() - began)
    report = replace(report, timing_s=folder.stage_seconds(), peak_memory_mb=peak_memory_mb())
    write_json(out / "report.json", report_tree(report), "report")
    emit(Event(stage="report", done=1, total=1))
    return report


def _as_report(emit: Emit) -> Emit:
    return lambda event: emit(replace(event, stage="report"))


def _compare(out: Path, report: SteelReport, truth: Path) -> SteelEvaluation:
    tree = plain(report_tree(report))
    return evaluate_steel(Document(file=out / "report.json", where="", values=tree), read_document(truth))


def _models(out: Path, report: SteelReport) -> tuple[str, ...]:
    # trimesh is slow to load, which a survey without clouds should not wait for
    from pipeline.report.steel.model import glb_bytes, ply_bytes, shapes

    found = shapes(report)
    if not found:
        return ()
    write_bytes(out / "members.glb", glb_bytes(found), "report")
    write_bytes(out / "members.ply", ply_bytes(found), "report")
    return "members.glb", "members.ply"


def _write_page(
    path: Path,
    report: SteelReport,
    compared: SteelEvaluation | None,
    names: tuple[str, ...],
    language: Language,
) -> None:
    # its plots load Matplotlib, which a refused survey should not wait for
    from pipeline.report.steel.page import write_page

    write_page(path, report, compared, names, language)
