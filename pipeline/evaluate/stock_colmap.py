"""Compare with stock COLMAP on the frames of a run: each strip alone, as the paper does, and timed.

``python -m pipeline.evaluate.stock_colmap RUN --survey SURVEY.toml --truth TRUTH.json --json FILE``

Takes a run folder whose frames are extracted, its survey and the truth; gives diameters per block and
averaged over the blocks, their errors, and the seconds of features, matching and mapping.  Nothing of our
own adjustment enters: the survey gives lens, travel and nominal attitudes, COLMAP the rest.  A block that
COLMAP cannot reconstruct is a result, not an error.
"""

import argparse
import signal
import sys
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2  # before pycolmap: the other way round the two libraries' PNG writers collide
import numpy as np
import pycolmap

from pipeline.cable.sources import image_files, is_video
from pipeline.cable.survey import Block, Survey, read_survey
from pipeline.core.errors import StageError
from pipeline.core.events import Emit, silent
from pipeline.core.files import natural_key, write_json
from pipeline.core.rotations import nominal_pose
from pipeline.core.vocabulary import Array
from pipeline.evaluate.documents import Document, read_document
from pipeline.evaluate.stock.place import points_in_cable
from pipeline.evaluate.stock.reconstruct import STAGE, reconstruct
from pipeline.evaluate.stock.records import StockBlock, StockModel, StockOptions, StockResult
from pipeline.evaluate.stock.sections import station_diameters_mm
from pipeline.evaluate.stock.summary import Stations, format_stock_table, summarise

__all__ = [
    "compare_with_stock_colmap",
    "format_stock_table",
    "main",
    "measure_model",
    "summarise",
    "write_stock_result",
]


def compare_with_stock_colmap(
    run_folder: Path,
    survey: Survey,
    truth: Document,
    options: StockOptions | None = None,
    blocks: Sequence[str] = (),
    emit: Emit = silent,
) -> StockResult:
    """Reconstruct blocks of a run with stock COLMAP and compare their diameters with truth.

    Args:
        run_folder: holds blocks/NAME/frames/*.png, NAME as in the survey.
        survey: the run's survey.
        truth: its stations are measured.
        options: see there.
        blocks: names; none takes all of the survey's.
        emit: progress; see :func:`~pipeline.evaluate.stock.reconstruct.reconstruct` for where it may stop.

    Raises:
        StageError: a block is not in the survey or has no frames, or the truth has no stations.
    """
    choice, stations = options or StockOptions(), _stations(truth)
    per_block = tuple(
        _block(run_folder, survey, block, stations, choice, emit) for block in _chosen(survey, blocks)
    )
    return summarise(per_block, stations)


def write_stock_result(result: StockResult, path: Path) -> None:
    """Write the comparison as JSON, fields by their names.

    Raises:
        StageError: the place cannot be written.
    """
    write_json(path, {"format": 1, **vars(result)}, stage=STAGE)


def _stations(truth: Document) -> Stations:
    found = [
        (s.text("name"), s.number("position_m"), s.number("diameter_mm")) for s in truth.items("stations")
    ]
    if not found:
        raise truth.error("stations is empty")
    return found


def _chosen(survey: Survey, names: Sequence[str]) -> list[Block]:
    known = {block.name: block for block in survey.blocks}
    for name in names:
        if name not in known:
            raise StageError(STAGE, f'block "{name}" is not in the survey', f"choose from {', '.join(known)}")
    return [known[name] for name in names] if names else list(survey.blocks)


def _block(
    run_folder: Path, survey: Survey, block: Block, stations: Stations, options: StockOptions, emit: Emit
) -> StockBlock:
    files, fractions = _frames(run_folder, block)
    lens = block.lens(*_size(files[0]))
    with TemporaryDirectory(prefix="stock-colmap-") as scratch:
        model, seconds = reconstruct(
            files, lens, block.travel_in_image, Path(scratch), options, emit, block.name
        )
    diameters: dict[str, float | None] = {name: None for name, _, _ in stations}
    failure = None if model is not None else "COLMAP found no model"
    if model is not None:
        try:
            diameters = measure_model(model, fractions, survey, block, stations, options)
        except StageError as error:
            failure = error.cause
    missing = [name for name, found in diameters.items() if found is None]
    if failure is None and missing:
        failure = f"too few points at {', '.join(missing)}"
    return StockBlock(
        name=block.name,
        registered=0 if model is None else len(model.poses),
        images=len(files),
        points=0 if model is None else len(model.points),
        reprojection_px=None if model is None else model.reprojection_px,
        focal_px=None if model is None else model.focal_px,
        seconds=seconds,
        diameters=diameters,
        failure=failure,
    )


def measure_model(
    model: StockModel,
    fractions: Array,
    survey: Survey,
    block: Block,
    stations: Stations,
    options: StockOptions,
) -> dict[str, float | None]:
    """Scale and place a block's model and measure its stations, millimetres.

    Args:
        model: as COLMAP gave it.
        fractions: (images,) share of the travel at which each image of the block was taken.
        survey, block: travel, stand-off, azimuth and travel direction.
        stations: where to measure.
        options: see there.

    Raises:
        StageError: the model has no scale, or its points fit no cylinder.
    """
    y_m = survey.cable.travel_m * fractions[model.frames]
    nominal = nominal_pose(block.angle_deg, survey.robot.standoff_m, y_m, block.travel_in_image)
    diameters = station_diameters_mm(
        points_in_cable(model, nominal),
        block.angle_deg,
        survey.robot.standoff_m,
        [position for _, position, _ in stations],
        options,
    )
    return {name: found for (name, _, _), found in zip(stations, diameters, strict=True)}


def _frames(run_folder: Path, block: Block) -> tuple[tuple[Path, ...], Array]:
    """A block's image files in order, and the share of the travel at which each was taken."""
    folder = run_folder / "blocks" / block.name / "frames"
    # the run's names count the frames of the video, whose last one is always among the chosen
    files = tuple(sorted(folder.glob("[0-9]*.png"), key=natural_key))
    numbers = np.array([int(file.stem) for file in files], dtype=float)
    if not files and not is_video(block):
        files = image_files(block)
        numbers = np.arange(len(files), dtype=float)
    if len(files) < 2:
        raise StageError(STAGE, f"{folder} has no frames", "run the survey first and give its folder")
    return files, numbers / numbers[-1]


def _size(file: Path) -> tuple[int, int]:
    picture = cv2.imread(str(file))
    if picture is None:
        raise StageError(STAGE, f"{file} cannot be read as a picture", "run the frames stage again")
    return picture.shape[1], picture.shape[0]


def main(arguments: list[str] | None = None) -> int:
    """The command line; exit code 0 when the comparison is there, 2 for bad input."""
    parser = argparse.ArgumentParser(
        prog="python -m pipeline.evaluate.stock_colmap",
        description="Compare with stock COLMAP on the frames of a run.",
    )
    parser.add_argument("run", type=Path, help="the run folder, its frames extracted")
    parser.add_argument("--survey", type=Path, required=True, help="survey.toml of the run")
    parser.add_argument("--truth", type=Path, required=True, help="truth.json")
    parser.add_argument("--json", type=Path, help="write all figures there as well")
    parser.add_argument("--blocks", nargs="+", default=[], metavar="NAME", help="only these blocks")
    chosen = parser.parse_args(arguments)
    # a terminated run removes its scratch folder, too
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    pycolmap.logging.minloglevel = int(pycolmap.logging.Level.ERROR)
    try:
        result = compare_with_stock_colmap(
            chosen.run, read_survey(chosen.survey), read_document(chosen.truth), blocks=chosen.blocks
        )
        if chosen.json:
            write_stock_result(result, chosen.json)
    except StageError as error:
        sys.stderr.write(f"error: {error}\n")
        return 2
    except KeyboardInterrupt:
        sys.stderr.write("\ninterrupted\n")
        return 130
    sys.stdout.write(format_stock_table(result))
    return 0


if __name__ == "__main__":
    sys.exit(main())
