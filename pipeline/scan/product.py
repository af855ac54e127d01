"""A scan of a cable joined with its finished run, from the folder to everything that a person opens.

Takes the run folder and the scan's files; writes RUN/scan (or another folder): merged.ply, deviation.png,
scan.html and, last, scan.json.
"""

from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np

from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event, part
from pipeline.core.files import write_bytes, write_json
from pipeline.report.labels import Language
from pipeline.scan.finished import FinishedRun, read_finished_run
from pipeline.scan.held import held_ways, screw_mm_per_degree
from pipeline.scan.join import STAGE, ScanJoin, join_scan
from pipeline.scan.pairs import read_scan_pairs
from pipeline.scan.reading import read_scan
from pipeline.steel.fuse_records import Placement
from pipeline.steel.merged_cloud import write_merged
from pipeline.steel.survey_records import LengthUnit

FILES = ("merged.ply", "deviation.png", "scan.json")


def make_scan_product(
    folder: Path,
    scans: Sequence[Path],
    unit: LengthUnit,
    out: Path | None,
    language: Language,
    emit: Emit,
    pairs: Path | None = None,
) -> str:
    """Join a scan with a finished run.

    Args:
        folder: of the run.
        scans: cloud files that share one frame.
        unit: of their coordinates.
        out: where to write; None: ``scan`` in the run's folder.
        language: that the page opens in.
        emit: progress of the stage *scan*; may raise Cancelled.
        pairs: table of places pointed out in both, for a cable without marks.

    Returns:
        What to tell the person.

    Raises:
        StageError: bad input; nothing is written then.
    """
    run = read_finished_run(folder)
    given = () if pairs is None else read_scan_pairs(pairs, unit)
    scan = read_scan(scans, unit, run.radius_m, part(emit, 0.0, 0.6))
    found = join_scan(run, scan, part(emit, 0.6, 0.9), given)
    out = folder / "scan" if out is None else out
    names = tuple(path.name for path in scans)
    _make_folder(out)
    # matplotlib is slow to load, which a refusal should not wait for
    from pipeline.report.scan_page import deviation_png, scan_html

    identity = Placement(scale=1.0, rotation=np.eye(3), translation=np.zeros(3))
    write_merged(
        out / "merged.ply", run.cloud, found.scan, replace(found.fusion, placement=identity), names, "cable"
    )
    emit(Event(stage=STAGE, done=95, total=100))
    picture = deviation_png(found, run)
    write_bytes(out / "deviation.png", picture, STAGE)
    write_bytes(out / "scan.html", scan_html(found, run, names, FILES, language).encode(), STAGE)
    write_json(out / "scan.json", scan_tree(found, run, names), STAGE)
    emit(Event(stage=STAGE, done=1, total=1))
    return _summary(found, run, out)


def _make_folder(out: Path) -> None:
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StageError(
            STAGE, f"{out} cannot be made ({error})", "give another folder with --out"
        ) from error


def scan_tree(found: ScanJoin, run: FinishedRun, names: Sequence[str]) -> dict[str, object]:
    """What scan.json holds; units in the names."""
    fusion, back = found.fusion, found.cable_from_scan
    return {
        "format": 1,
        "kind": "scan-join",
        "name": run.name,
        "scans": list(names),
        "scan_points": len(found.scan),
        "cable_from_scan": {
            "scale": back.scale,
            "rotation": back.rotation.tolist(),
            "translation_m": back.translation.tolist(),
        },
        "scale": {"scan_over_model": found.scale, "sigma": found.scale_sigma},
        "ways": [
            {**asdict(way), "determined": way.determined}
            for way in held_ways(fusion, run.radius_m, run.middle_m)
        ],
        "screw_mm_per_deg": screw_mm_per_degree(fusion, run.middle_m),
        "pairs": [
            {"name": pair.name, "residual_mm": (pair.residual_mm / found.scale).tolist()}
            for pair in fusion.pairs
        ],
        "notes": list(fusion.notes),
        "deviation": {
            "points": int(found.kept.sum()),
            "mean_mm": found.mean_mm,
            "median_mm": found.median_mm,
            "rms_mm": found.rms_mm,
            "noise_mm": found.noise_mm,
            "smoothed_median_mm": fusion.median_mm,
            "coverage": found.coverage,
        },
        "diameters": [
            {**asdict(row), "difference_mm": row.scan_mm - row.photo_mm} for row in found.diameters
        ],
    }


def _summary(found: ScanJoin, run: FinishedRun, out: Path) -> str:
    lines = [
        f"scale of the scan over the model {found.scale:.5f} +- {found.scale_sigma:.5f}; "
        f"scan - model: mean {found.mean_mm:+.3f} mm, rms {found.rms_mm:.3f} mm"
    ]
    for way in held_ways(found.fusion, run.radius_m, run.middle_m):
        size = 100 * way.sigma if way.unit == "share" else way.sigma
        unit = "%" if way.unit == "share" else way.unit
        known = f"{size:.3g} {unit} ({way.held_by})" if way.determined else "not determined"
        lines.append(f"  {WAYS[way.name]:22s} {known}")
    screw = screw_mm_per_degree(found.fusion, run.middle_m)
    if screw is not None and not all(
        w.determined for w in held_ways(found.fusion, run.radius_m, run.middle_m)
    ):
        lines.append(f"  a turn goes with a shift: {screw:+.2f} mm for each degree")
    lines += ["station  position m  photos mm   scan mm  sigma mm  difference mm"]
    lines += [
        f"{row.name:8s} {row.position_m:10.3f} {row.photo_mm:10.3f} {row.scan_mm:9.3f} "
        f"{row.scan_sigma_mm:9.3f} {row.scan_mm - row.photo_mm:+14.3f}"
        for row in found.diameters
    ]
    return "\n".join([*lines, "", f"merged  {out / 'merged.ply'}", f"page    {out / 'scan.html'}"])


WAYS = {
    "along": "shift along the cable",
    "turn": "turn about the cable",
    "across": "shift across",
    "tilt": "tilt",
    "scale": "scale",
}
