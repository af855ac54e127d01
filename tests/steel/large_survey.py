"""A survey as large as the paper's, from clouds to the report: what it takes, and how exact it is.

``python -m tests.steel.large_survey FOLDER [--bays 18 16] [--stations 12 11] [--step-deg 0.069]``: the hall
of ``specs/steel/hall_134.toml`` (or a part of it) is scanned with noise, occlusion and mixed pixels, a
station at a time; each cloud is imported by the pipeline and deleted, for all of them would take 15 GB of
disk besides what the pipeline keeps.  Then comes the command that everybody uses, on empty files in the
clouds' places: it finds them imported.  Prints points, peak memory and processor time of both.  The run
folder stays (25 MB a million points), for ``python -m pipeline evaluate``.  Begun again, it goes on where it
was stopped.
"""

import argparse
import json
import multiprocessing
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from unittest.mock import patch

import numpy as np

from pipeline.core.events import silent
from pipeline.core.memory import peak_memory_mb
from pipeline.core.runfolder import RunFolder
from pipeline.steel import station_stages
from pipeline.steel.chain import SteelChain
from pipeline.steel.clouds import import_cloud
from pipeline.steel.options import bind_steel_options
from pipeline.steel.survey import read_steel_survey
from pipeline.steel_product import make_steel_product
from synth.scan import scanner
from synth.scan.clouds import write_cloud
from synth.scan.frame import build_frame
from synth.scan.layout import build_layout
from synth.scan.lists import station_lists
from synth.scan.primitives import build_world
from synth.scan.spec import CloudFormat, Level, ScanSpec, read_scan_spec
from synth.scan.survey import cloud_name, list_csv, list_name, survey_toml
from synth.scan.truth import truth_of
from tests.command import ROOT

HALL = ROOT / "specs" / "steel" / "hall_134.toml"
REACH_M = 45.0


def spec_of(bays, stations, step_deg):
    """The hall, or a part of it, at the level of clouds; its targets are listed, as in the paper."""
    whole = read_scan_spec(HALL)
    structure = whole.structure
    share = np.array(bays) / structure.bays
    stands = tuple(int(n) for n in np.ceil(share * whole.targets.stands))
    return replace(
        whole,
        level=Level.CLOUDS,
        structure=replace(structure, bays=tuple(bays), span_m=bays[1] * structure.module_m),
        stations=replace(
            whole.stations, count=tuple(stations), at_m=whole.stations.at_m if share.min() == 1 else ()
        ),
        targets=replace(whole.targets, stands=stands),
        scanner=replace(
            whole.scanner, step_deg=step_deg, max_range_m=REACH_M, sub_rays=6, format=CloudFormat.LAS
        ),
        survey=replace(whole.survey, lists=True),
    )


@cache
def hall(spec: ScanSpec):
    frame = build_frame(spec)
    return frame, build_layout(spec, frame)


def write_survey(spec, folder):
    """Everything but the clouds, which are empty files."""
    frame, layout = hall(spec)
    lists = station_lists(spec, frame, layout)
    for name in ("targets", "clouds"):
        (folder / name).mkdir(parents=True)
    for station, seen in zip(layout.stations, lists, strict=True):
        (folder / list_name(station.name)).write_text(list_csv(spec, seen))
        (folder / cloud_name(spec, station.name)).touch()
    (folder / "truth.json").write_text(json.dumps(truth_of(spec, frame, layout, lists)))
    (folder / "survey.toml").write_text(survey_toml(spec, frame, layout))


def scan_station(spec, name, path):
    """Runs in a process of its own: what the scanner takes is not the pipeline's."""
    frame, layout = hall(spec)
    number = [station.name for station in layout.stations].index(name)
    station = layout.stations[number]
    world = build_world(spec, frame, layout, number).seen_from(station.rotation, station.centre)
    # fewer, larger bands: each looks at all of the hall's rods
    with patch.object(scanner, "RAYS_PER_BAND", 4_000_000):
        bands = list(scanner.scan(world, spec.scanner, (spec.seed, number)))
    points, strengths = (np.concatenate([getattr(b, n) for b in bands]) for n in ("points", "intensity"))
    write_cloud(path, points, strengths, spec.scanner.format, spec.scanner.unit)


def imported(spec, pool, station, out, emit):
    pool.submit(scan_station, spec, station.name, station.cloud).result()
    try:
        return import_cloud(station, out, emit)
    finally:
        station.cloud.write_bytes(b"")


def import_clouds(spec, folder, run):
    """The stage *clouds* of the run, each cloud scanned when it is wanted."""
    survey = read_steel_survey(folder / "survey.toml")
    chain = SteelChain(survey, bind_steel_options(survey), RunFolder(run), silent)
    context = multiprocessing.get_context("spawn")
    with (
        ProcessPoolExecutor(1, mp_context=context) as pool,
        patch.object(station_stages, "import_cloud", partial(imported, spec, pool)),
    ):
        chain.run("clouds")
    return sum(product.value.points for product in chain.made["clouds"])


class Stages:
    """Peak memory and processor time at every tenth of every stage, printed at once."""

    def __init__(self):
        self.last = None

    def __call__(self, event):
        now = (event.stage, 10 * event.done // max(event.total, 1))
        if now != self.last:
            told = {"stage": event.stage, "done_percent": 10 * now[1], **spent()}
            print(json.dumps(told), flush=True)  # noqa: T201 - a command
            self.last = now


def spent():
    return {"peak_mb": round(peak_memory_mb()), "cpu_s": round(time.process_time())}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=Path)
    parser.add_argument("--bays", type=int, nargs=2, default=(18, 16))
    parser.add_argument("--stations", type=int, nargs=2, default=(12, 11))
    parser.add_argument("--step-deg", type=float, default=0.069)
    parser.add_argument("--set", action="append", default=[], help="as of python -m pipeline steel")
    asked = parser.parse_args()
    survey, run = asked.folder / "survey", asked.folder / "run"
    spec = spec_of(asked.bays, asked.stations, asked.step_deg)
    if not survey.exists():
        write_survey(spec, survey)
    points = import_clouds(spec, survey, run)
    print(json.dumps({"points": points, "after_clouds": spent()}), flush=True)  # noqa: T201 - a command
    told = make_steel_product(
        read_steel_survey(survey / "survey.toml"),
        run,
        Stages(),
        assignments=tuple(asked.set),
        truth=survey / "truth.json",
    )
    print(told, json.dumps({"points": points, "at_the_end": spent()}), sep="\n")  # noqa: T201 - a command


if __name__ == "__main__":
    main()
