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
from pathlib import Path

from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event
from pipeline.core.files import natural_key
from pipeline.steel.photo_features import STAGE, features_of, matches_of
from pipeline.steel.photo_mapping import LEAST_PHOTOS, mapped
from pipeline.steel.photo_records import OrientedPhotos, SparseOptions

PICTURES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp")


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
        return mapped(files, size, focal_px, features, matches, scratch, options, emit, steps)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
