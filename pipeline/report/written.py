"""Everything that a person opens, written from a finished run: figures, page, model, cloud, pictures, blocks.

Takes a :class:`~pipeline.cable.records.CableRun` and the run folder; gives what the report tells.  The files
know nothing of each other and are written side by side; report.json comes last, so that it stands for a whole
product.
"""

import itertools
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from pipeline.cable.records import CableRun
from pipeline.cable.ring import Ring
from pipeline.core.events import Emit, Event
from pipeline.core.files import replacing
from pipeline.core.memory import peak_memory_mb
from pipeline.core.parallel import side_by_side, workers_for
from pipeline.core.runfolder import RunFolder
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
from pipeline.report.model import ring_cloud, ring_mesh
from pipeline.report.types import ReportData, TruthStation

type Piece = Callable[[], object]


def write_run(
    found: CableRun, folder: RunFolder, truth: tuple[TruthStation, ...], language: Language, emit: Emit
) -> ReportData:
    """Write all files of the product into the run folder.

    Args:
        found: everything found.
        folder: where to write; knows how long the stages took.
        truth: true diameters of stations, where they are known.
        language: that the page opens in.
        emit: progress; may raise Cancelled.

    Raises:
        StageError: the folder cannot be written.
    """
    began = time.monotonic()
    emit(Event(stage="report", done=0, total=1))
    seconds = {stage: value for stage, value in folder.stage_seconds().items() if stage != "report"}
    data = collect(found, truth, seconds, peak_memory_mb())
    blocks = [partial(write_block_files, found, n, folder.path / "blocks") for n in range(len(found.blocks))]
    data = write_files(data, found.ring, folder.path, language, emit, began, blocks)
    folder.note_time("report", "", data.timing_s["report"])
    return data


def write_files(
    data: ReportData,
    ring: Ring,
    out: Path,
    language: Language,
    emit: Emit,
    began: float,
    also: Sequence[Piece] = (),
) -> ReportData:
    """Write page, figures, model, cloud and pictures of a surface, and beside them whatever ``also`` writes.

    Args:
        data: what the report tells; the time since ``began`` is added to its stage "report".
        ring: the surface.
        out: the run folder.
        language: that the page opens in.
        emit: progress; may raise Cancelled.
        began: when the report was begun, ``time.monotonic()``.
        also: further files.

    Raises:
        StageError: the folder cannot be written.
    """
    pieces: tuple[Piece, ...] = (
        partial(_write_page, out, data, language),
        *also,
        partial(_write_model, out, ring),
        partial(_write_pictures, out, data, ring),
        partial(write_diameters_csv, out / "diameters.csv", data.stations, data.truth),
    )
    done = itertools.count(1)
    side_by_side(
        [partial(_told, piece) for piece in pieces],
        lambda _: emit(Event(stage="report", done=next(done), total=len(pieces) + 1)),
        workers_for(len(pieces)),
    )
    spent = round(data.timing_s.get("report", 0.0) + time.monotonic() - began, 3)
    data = replace(data, timing_s={**data.timing_s, "report": spent}, peak_memory_mb=peak_memory_mb())
    write_report_json(out / "report.json", data)
    return data


def _told(piece: Callable[[], object], emit: Emit) -> None:
    piece()
    emit(Event(stage="report", done=1, total=1))


def _write_page(out: Path, data: ReportData, language: Language) -> None:
    # its plots load Matplotlib, which a refused survey should not wait for
    from pipeline.report.page import PageOptions, write_report_html

    write_report_html(out / "report.html", data, PageOptions(language=language))


def _write_model(out: Path, ring: Ring) -> None:
    mesh = ring_mesh(ring)
    write_model_ply(out / "model.ply", mesh)
    write_model_glb(out / "model.glb", mesh)
    write_cloud_ply(out / "cloud.ply", ring_cloud(ring))


def _write_pictures(out: Path, data: ReportData, ring: Ring) -> None:
    if data.unrolled is not None:
        write_unrolled_png(out / "unrolled.png", data.unrolled)
    with replacing(out / "radius_map.npz", "report") as temporary, temporary.open("wb") as file:
        np.savez_compressed(
            file,
            theta_deg=np.rad2deg(ring.azimuth),
            position_m=ring.y_m,
            radius_mm=1000 * np.where(ring.measured, ring.radius_m, np.nan),
        )
