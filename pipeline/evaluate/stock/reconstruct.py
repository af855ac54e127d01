"""One block through stock COLMAP: SIFT on the CPU, sequential matching, incremental mapping.

Takes image files, their lens and a scratch folder; gives the largest model and the seconds of each step.
Leaves out scale and place (``place.py``).  The lens is COLMAP's SIMPLE_DIVISION, the very model of the
survey: held where the survey calls it calibrated, else refined by COLMAP from the stated values.
"""

import time
from collections.abc import Callable
from pathlib import Path

import cv2  # before pycolmap: the other way round the two libraries' PNG writers collide
import numpy as np
import pycolmap

from pipeline.cable.silhouette import cable_mask
from pipeline.core.division import parameters
from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event
from pipeline.core.files import write_png
from pipeline.core.vocabulary import Lens, Poses, TravelDirection
from pipeline.evaluate.stock.records import StepSeconds, StockModel, StockOptions

STAGE = "stock colmap"


def reconstruct(
    files: tuple[Path, ...],
    lens: Lens,
    travel_in_image: TravelDirection,
    scratch: Path,
    options: StockOptions,
    emit: Emit,
    block: str = "",
) -> tuple[StockModel | None, StepSeconds]:
    """Reconstruct a block alone; None where COLMAP found no model.

    Args:
        files: images of one folder in the order of travel, names ascending.
        lens: starting values, or the calibrated lens (both its sigmas 0).
        travel_in_image: for the masks.
        scratch: empty folder for masks, database and models.
        options: see there.
        emit: told after each step and each registered image; COLMAP's first two steps cannot be stopped.
        block: name, for the progress.
    """
    began = time.perf_counter()
    masks = _write_masks(files, travel_in_image, scratch / "masks") if options.masks else None
    masking_s = time.perf_counter() - began
    database, count = scratch / "database.db", len(files)

    def told(done: int) -> None:
        emit(Event(stage=STAGE, done=min(done, 3 * count), total=3 * count, block=block))

    told(0)
    features_s = _timed(lambda: _extract(files, lens, masks, database, options))
    told(count)
    matching_s = _timed(lambda: _match(database, options))
    told(2 * count)
    began = time.perf_counter()
    models = _map(files, lens, database, scratch / "models", options, _counter(told, 2 * count))
    mapping_s = time.perf_counter() - began
    seconds = StepSeconds(
        features=features_s,
        matching=matching_s,
        mapping=mapping_s,
        total=features_s + matching_s + mapping_s,
        masks=masking_s,
    )
    largest = max(models, key=lambda model: model.num_reg_images(), default=None)
    return (None if largest is None else _as_record(largest, files)), seconds


def _timed(step: Callable[[], None]) -> float:
    began = time.perf_counter()
    step()
    return time.perf_counter() - began


def _counter(told: Callable[[int], None], start: int) -> Callable[[], None]:
    registered = 0

    def one_more() -> None:
        nonlocal registered
        registered += 1
        told(start + registered)

    return one_more


def _write_masks(files: tuple[Path, ...], travel: TravelDirection, folder: Path) -> Path:
    for file in files:
        picture = cv2.imread(str(file), cv2.IMREAD_COLOR)
        if picture is None:
            raise StageError(STAGE, f"{file} cannot be read as a picture", "run the frames stage again")
        try:
            mask = cable_mask(picture, travel, name=file.name)
        except StageError:  # no outline in this frame: COLMAP gets all of it
            mask = np.full(picture.shape[:2], 255, dtype=np.uint8)
        write_png(folder / f"{file.name}.png", mask, stage=STAGE)
    return folder


def _extract(
    files: tuple[Path, ...], lens: Lens, masks: Path | None, database: Path, options: StockOptions
) -> None:
    reader, extraction = pycolmap.ImageReaderOptions(), pycolmap.FeatureExtractionOptions()
    reader.camera_model = "SIMPLE_DIVISION"
    reader.camera_params = ",".join(repr(float(value)) for value in parameters(lens))
    if masks is not None:
        reader.mask_path = str(masks)
    extraction.use_gpu, extraction.num_threads = False, options.threads
    extraction.sift.max_num_features = options.max_features
    pycolmap.set_random_seed(options.seed)
    pycolmap.extract_features(
        database,
        files[0].parent,
        image_names=[file.name for file in files],
        camera_mode=pycolmap.CameraMode.SINGLE,
        reader_options=reader,
        extraction_options=extraction,
        device=pycolmap.Device.cpu,
    )


def _match(database: Path, options: StockOptions) -> None:
    matching, pairing = pycolmap.FeatureMatchingOptions(), pycolmap.SequentialPairingOptions()
    verification = pycolmap.TwoViewGeometryOptions()
    matching.use_gpu, matching.num_threads = False, options.threads
    pairing.overlap = options.overlap
    verification.ransac.random_seed = options.seed
    pycolmap.match_sequential(
        database,
        matching_options=matching,
        pairing_options=pairing,
        verification_options=verification,
        device=pycolmap.Device.cpu,
    )


def _map(
    files: tuple[Path, ...],
    lens: Lens,
    database: Path,
    folder: Path,
    options: StockOptions,
    registered: Callable[[], None],
) -> list[pycolmap.Reconstruction]:
    choice = pycolmap.IncrementalPipelineOptions()
    choice.num_threads, choice.random_seed = options.threads, options.seed
    refine_focal, refine_lambda = lens.focal_sigma_px > 0, lens.lambda_sigma > 0
    choice.ba_refine_focal_length = choice.mapper.abs_pose_refine_focal_length = refine_focal
    choice.ba_refine_extra_params = choice.mapper.abs_pose_refine_extra_params = refine_lambda
    folder.mkdir()
    found = pycolmap.incremental_mapping(
        database, files[0].parent, folder, options=choice, next_image_callback=registered
    )
    return list(found.values())


def _as_record(model: pycolmap.Reconstruction, files: tuple[Path, ...]) -> StockModel:
    place = {file.name: number for number, file in enumerate(files)}
    images = sorted(
        (model.image(number) for number in model.reg_image_ids()), key=lambda image: place[image.name]
    )
    matrices = np.array([image.cam_from_world().matrix() for image in images])
    return StockModel(
        frames=np.array([place[image.name] for image in images], dtype=np.int64),
        poses=Poses(rotations=matrices[:, :, :3], translations=matrices[:, :, 3]),
        points=np.array([point.xyz for point in model.points3D.values()]).reshape(-1, 3),
        focal_px=float(images[0].camera.params[0]),
        reprojection_px=float(model.compute_mean_reprojection_error()),
    )
