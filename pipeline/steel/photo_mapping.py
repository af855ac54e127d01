"""Features and matches to oriented photos: verified, mapped and adjusted by COLMAP.

Takes what SIFT found in each picture and matched between them; gives orientations, lens and sparse points.
One thread and a fixed seed make it the same every time.  Leaves out finding features (``photo_features.py``)
and the order of it all (``photo_sparse.py``).
"""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING

import cv2  # noqa: F401 - before pycolmap: the other order crashes when pictures are written
import numpy as np
from numpy.typing import NDArray

from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event
from pipeline.core.vocabulary import LambdaRadius, Lens, Poses
from pipeline.steel.photo_features import STAGE, Features
from pipeline.steel.photo_records import OrientedPhotos, SparseOptions

if TYPE_CHECKING:
    import pycolmap

LEAST_PHOTOS = 3
POLL_S = 0.3


def mapped(
    files: tuple[Path, ...],
    size: tuple[int, int],
    focal_px: float,
    features: list[Features],
    matches: dict[tuple[int, int], NDArray[np.uint32]],
    scratch: Path,
    options: SparseOptions,
    emit: Emit,
    steps: int,
) -> OrientedPhotos:
    """Map photos.

    Args:
        files: pictures.
        size: (rows, columns) of each.
        focal_px: start value.
        features, matches: of each picture; of each pair (i, j) rows of feature numbers.
        scratch: an empty folder for the database.
        options: see there.
        emit: told every half second at least; where it raises, the mapping is stopped.
        steps: of the whole stage, the last two for each picture are the mapping's.

    Raises:
        StageError: too few photos overlap.
    """
    # here and not above: whoever only reads products (Blender) must not load pycolmap
    import pycolmap

    pycolmap.logging.minloglevel = int(pycolmap.logging.Level.FATAL)
    database = pycolmap.Database.open(str(scratch / "database.db"))
    camera = pycolmap.Camera(
        model="SIMPLE_DIVISION",
        width=size[1],
        height=size[0],
        params=[focal_px, size[1] / 2, size[0] / 2, 0.0],
        camera_id=1,
        has_prior_focal_length=True,
    )
    _write_images(database, camera, files, features)

    def tell() -> None:
        emit(Event(stage=STAGE, done=len(files) + len(matches), total=steps))

    _write_matches(database, camera, features, matches, options, tell)
    database.close()
    return _record(_adjusted(_map(files, scratch, options, emit, steps), options), files, size)


def _write_images(
    database: "pycolmap.Database",
    camera: "pycolmap.Camera",
    files: tuple[Path, ...],
    features: list[Features],
) -> None:
    """One camera, and of each picture its keypoints."""
    import pycolmap

    database.write_camera(camera, use_camera_id=True)
    rig = pycolmap.Rig(rig_id=1)
    rig.add_ref_sensor(camera.sensor_id)
    database.write_rig(rig, use_rig_id=True)
    for number, (file, (places, _)) in enumerate(zip(files, features, strict=True), 1):
        image = pycolmap.Image(name=file.name, camera_id=1, image_id=number)
        database.write_image(image, use_image_id=True)
        frame = pycolmap.Frame(frame_id=number, rig_id=1)
        frame.add_data_id(image.data_id)
        database.write_frame(frame, use_frame_id=True)
        database.write_keypoints(number, places.astype(np.float32))


def _write_matches(
    database: "pycolmap.Database",
    camera: "pycolmap.Camera",
    features: list[Features],
    matches: dict[tuple[int, int], NDArray[np.uint32]],
    options: SparseOptions,
    tell: Callable[[], None],
) -> None:
    """The matches of each pair, and which of them agree with two views of one scene."""
    import pycolmap

    verify = pycolmap.TwoViewGeometryOptions(detect_watermark=False)
    verify.ransac.random_seed, verify.ransac.max_error = options.seed, 2.0
    verify.min_num_inliers = options.least_matches
    for number, ((i, j), found) in enumerate(matches.items()):
        if number % 8 == 0:
            tell()
        if len(found) < options.least_matches:
            continue
        geometry = pycolmap.estimate_two_view_geometry(
            camera, features[i][0], camera, features[j][0], found, verify
        )
        database.write_matches(i + 1, j + 1, found)
        database.write_two_view_geometry(i + 1, j + 1, geometry)


def _map(
    files: tuple[Path, ...], scratch: Path, options: SparseOptions, emit: Emit, steps: int
) -> "pycolmap.Reconstruction":
    """The largest model that the pictures in the database make."""
    import pycolmap

    choice = pycolmap.IncrementalPipelineOptions()
    choice.num_threads, choice.random_seed = 1, options.seed
    choice.multiple_models, choice.extract_colors, choice.min_model_size = False, False, LEAST_PHOTOS
    choice.ba_refine_focal_length = choice.mapper.abs_pose_refine_focal_length = options.refine_focal
    choice.ba_refine_extra_params = choice.mapper.abs_pose_refine_extra_params = options.refine_distortion
    token, registered = pycolmap.CancellationToken(), [0]

    def one_more() -> None:
        registered[0] += 1

    def tell() -> None:
        done = steps - 2 * len(files) + min(registered[0], len(files))
        emit(Event(stage=STAGE, done=done, total=steps))

    with ThreadPoolExecutor(1) as pool:
        future = pool.submit(
            pycolmap.incremental_mapping,
            scratch / "database.db",
            files[0].parent,
            scratch,
            options=choice,
            next_image_callback=one_more,
            cancellation_token=token,
        )
        try:
            models = _waited(future, tell)
        finally:
            token.cancel()
    largest = max(models.values(), key=lambda model: model.num_reg_images(), default=None)
    if largest is None or largest.num_reg_images() < LEAST_PHOTOS:
        raise StageError(
            STAGE,
            f"the {len(files)} photos in {files[0].parent} do not overlap enough to be oriented",
            "take more photos, each sharing most of its view with the next, of textured surfaces",
        )
    return largest


def _waited[T](future: Future[T], tell: Callable[[], None]) -> T:
    """The result, told of while it is waited for."""
    while True:
        tell()
        try:
            return future.result(timeout=POLL_S)
        except TimeoutError:
            continue


def _adjusted(model: "pycolmap.Reconstruction", options: SparseOptions) -> "pycolmap.Reconstruction":
    """The same model, all its photos adjusted together once more."""
    import pycolmap

    sharper = pycolmap.BundleAdjustmentOptions()
    sharper.refine_focal_length, sharper.refine_extra_params = options.refine_focal, options.refine_distortion
    sharper.refine_principal_point, sharper.print_summary = False, False
    config = pycolmap.BundleAdjustmentConfig()
    for number in model.reg_image_ids():
        config.add_image(number)
    config.fix_gauge(pycolmap.BundleAdjustmentGauge.TWO_CAMS_FROM_WORLD)
    # pycolmap.bundle_adjustment would write headings to stderr, into the progress, whatever the log level
    pycolmap.create_default_bundle_adjuster(sharper, config, model).solve()
    return model


def _record(
    model: "pycolmap.Reconstruction", files: tuple[Path, ...], size: tuple[int, int]
) -> OrientedPhotos:
    numbers = sorted(model.reg_image_ids())
    images = [model.image(number) for number in numbers]
    matrices = np.array([image.cam_from_world().matrix() for image in images])
    focal, cx, cy, k = images[0].camera.params
    order = sorted(model.points3D)
    place = {point: row for row, point in enumerate(order)}
    observed = [
        (row, place[mark.point3D_id], *mark.xy)
        for row, image in enumerate(images)
        for mark in image.points2D
        if mark.has_point3D()
    ]
    rows = np.array(observed, dtype=float).reshape(-1, 4)
    lens = Lens(
        width_px=size[1],
        height_px=size[0],
        focal_px=float(focal),
        principal_point_px=(float(cx), float(cy)),
        division_lambda=float(k),
        lambda_radius=LambdaRadius.FOCAL,
    )
    return OrientedPhotos(
        files=tuple(files[number - 1] for number in numbers),
        lens=lens,
        poses=Poses(rotations=matrices[:, :, :3], translations=matrices[:, :, 3]),
        points=np.array([model.points3D[point].xyz for point in order]).reshape(-1, 3),
        observations=rows[:, :2].astype(np.int64),
        pixels=rows[:, 2:],
        left_out=tuple(file for number, file in enumerate(files, 1) if number not in numbers),
        reprojection_px=float(model.compute_mean_reprojection_error()),
    )
