"""Photos of a structure oriented: SIFT, matching, incremental mapping, adjustment.

Takes pictures of one camera and a start of its focal length; gives orientations, lens and sparse points in a
frame of their own.  Features and matches are OpenCV's, one picture and one pair at a time, so that a run can
be stopped between them; geometry is verified and mapped by COLMAP on one thread with a fixed seed, which
makes it the same every time.  Leaves out priors: nothing is known of where the photos were taken.

Sources: paper, section 2.3 (SIFT, RANSAC with the fundamental matrix, a first pair without a dominating
homography, one photo after the other, bundle adjustment); J. L. Schoenberger and J.-M. Frahm,
"Structure-from-Motion Revisited", CVPR 2016.
"""

import shutil
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING

import cv2  # noqa: F401 - before pycolmap: the other order crashes when pictures are written
import numpy as np
from numpy.typing import NDArray

from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event
from pipeline.core.files import natural_key
from pipeline.core.vocabulary import LambdaRadius, Lens, Poses
from pipeline.steel.photo_features import STAGE, Features, features_of, matches_of
from pipeline.steel.photo_records import OrientedPhotos, SparseOptions

if TYPE_CHECKING:
    import pycolmap

PICTURES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp")
LEAST_PHOTOS = 3
POLL_S = 0.3


def pictures_in(folder: Path) -> tuple[Path, ...]:
    """Pictures of a folder in natural order.

    Raises:
        StageError: there is no such folder, or fewer than three pictures in it.
    """
    if not folder.is_dir():
        raise StageError(
            STAGE, f"there is no folder {folder}", "give the folder of the photos in photos.source"
        )
    files = sorted((f for f in folder.iterdir() if f.suffix.lower() in PICTURES), key=natural_key)
    if len(files) < LEAST_PHOTOS:
        raise StageError(STAGE, f"{folder} holds {len(files)} pictures", f"give at least {LEAST_PHOTOS}")
    return tuple(files)


def orient(
    files: tuple[Path, ...], focal_px: float, scratch: Path, options: SparseOptions, emit: Emit
) -> OrientedPhotos:
    """Orient photos.

    Args:
        files: pictures of one camera, of one size.
        focal_px: start value.
        scratch: folder for COLMAP's database; it is emptied and removed.
        options: see there.
        emit: told every half second at least; where it raises, the mapping is stopped.

    Raises:
        StageError: a picture cannot be read, sizes differ, or too few photos overlap.
    """
    pairs = [(i, j) for i in range(len(files)) for j in range(i)]
    steps = len(files) + len(pairs) + 2 * len(files)
    features, size = [], (0, 0)
    for number, file in enumerate(files):
        emit(Event(stage=STAGE, done=number, total=steps))
        found, shape = features_of(file, options)
        if number and shape != size:
            raise StageError(STAGE, f"{file} is not as large as {files[0].name}", "give photos of one camera")
        size = shape
        features.append(found)
    matches = {}
    for number, (i, j) in enumerate(pairs):
        emit(Event(stage=STAGE, done=len(files) + number, total=steps))
        matches[j, i] = matches_of(features[j], features[i], options.ratio)
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir(parents=True)
    try:
        return _mapped(files, size, focal_px, features, matches, scratch, options, emit, steps)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def _mapped(
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
    verify = pycolmap.TwoViewGeometryOptions(detect_watermark=False)
    verify.ransac.random_seed, verify.ransac.max_error = options.seed, 2.0
    verify.min_num_inliers = options.least_matches
    for number, ((i, j), found) in enumerate(matches.items()):
        if number % 8 == 0:
            emit(Event(stage=STAGE, done=len(files) + len(matches), total=steps))
        if len(found) < options.least_matches:
            continue
        geometry = pycolmap.estimate_two_view_geometry(
            camera, features[i][0], camera, features[j][0], found, verify
        )
        database.write_matches(i + 1, j + 1, found)
        database.write_two_view_geometry(i + 1, j + 1, geometry)
    database.close()
    model = _map(files, scratch, options, emit, steps)
    return _record(model, files, size)


def _map(
    files: tuple[Path, ...], scratch: Path, options: SparseOptions, emit: Emit, steps: int
) -> "pycolmap.Reconstruction":
    import pycolmap

    choice = pycolmap.IncrementalPipelineOptions()
    choice.num_threads, choice.random_seed = 1, options.seed
    choice.multiple_models, choice.extract_colors, choice.min_model_size = False, False, LEAST_PHOTOS
    choice.ba_refine_focal_length = choice.mapper.abs_pose_refine_focal_length = options.refine_focal
    choice.ba_refine_extra_params = choice.mapper.abs_pose_refine_extra_params = options.refine_distortion
    token, registered = pycolmap.CancellationToken(), [0]

    def one_more() -> None:
        registered[0] += 1

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
            while True:
                emit(
                    Event(
                        stage=STAGE, done=steps - 2 * len(files) + min(registered[0], len(files)), total=steps
                    )
                )
                try:
                    models = future.result(timeout=POLL_S)
                    break
                except TimeoutError:
                    continue
        finally:
            token.cancel()
    largest = max(models.values(), key=lambda model: model.num_reg_images(), default=None)
    if largest is None or largest.num_reg_images() < LEAST_PHOTOS:
        raise StageError(
            STAGE,
            f"the {len(files)} photos in {files[0].parent} do not overlap enough to be oriented",
            "take more photos, each sharing most of its view with the next, of textured surfaces",
        )
    sharper = pycolmap.BundleAdjustmentOptions()
    sharper.refine_focal_length, sharper.refine_extra_params = options.refine_focal, options.refine_distortion
    sharper.refine_principal_point, sharper.print_summary = False, False
    config = pycolmap.BundleAdjustmentConfig()
    for number in largest.reg_image_ids():
        config.add_image(number)
    config.fix_gauge(pycolmap.BundleAdjustmentGauge.TWO_CAMS_FROM_WORLD)
    # pycolmap.bundle_adjustment would write headings to stderr, into the progress, whatever the log level
    pycolmap.create_default_bundle_adjuster(sharper, config, largest).solve()
    return largest


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
