"""One adjusted block in COLMAP's own format, for its viewers, its dense tools and everybody's scripts.

Takes frames and their adjusted orientation; writes cameras, images and points with tracks.
"""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pipeline.cable.adjust import Orientation
from pipeline.core.division import parameters
from pipeline.core.files import replacing
from pipeline.core.vocabulary import FrameSequence

if TYPE_CHECKING:
    import pycolmap


def write_sparse_model(folder: Path, frames: FrameSequence, orientation: Orientation) -> None:
    """Write the adjusted block in COLMAP's format: one SIMPLE_DIVISION camera, images, points with tracks."""
    # here and not above: whoever only reads products (Blender) must not load pycolmap
    import cv2  # noqa: F401 - before pycolmap: the other way round the two libraries' PNG writers collide
    import pycolmap

    lens = orientation.lens
    model = pycolmap.Reconstruction()
    camera = pycolmap.Camera(
        model="SIMPLE_DIVISION",
        width=lens.width_px,
        height=lens.height_px,
        params=parameters(lens),
        camera_id=1,
    )
    model.add_camera_with_trivial_rig(camera)
    rows = [np.flatnonzero(orientation.frame == k) for k in range(len(frames))]
    for k, file in enumerate(frames.files):
        image = pycolmap.Image(
            name=file.name, keypoints=orientation.pixels[rows[k]], camera_id=1, image_id=k + 1
        )
        pose = pycolmap.Rigid3d(
            pycolmap.Rotation3d(orientation.poses.rotations[k]), orientation.poses.translations[k]
        )
        model.add_image_with_trivial_frame(image, pose)
    _add_points(model, orientation, rows)
    with replacing(folder, "report") as temporary:
        temporary.mkdir(parents=True)
        model.write_binary(str(temporary))


def _add_points(model: "pycolmap.Reconstruction", orientation: Orientation, rows: list[np.ndarray]) -> None:
    import pycolmap

    place = np.concatenate([np.arange(len(r)) for r in rows])
    order = np.concatenate(rows)
    by_point = order[np.argsort(orientation.point[order], kind="stable")]
    place_of = np.empty(len(orientation.point), dtype=np.int64)
    place_of[order] = place
    cuts = np.flatnonzero(np.diff(orientation.point[by_point])) + 1
    for group in np.split(by_point, cuts):
        track = pycolmap.Track()
        for row in group:
            track.add_element(int(orientation.frame[row]) + 1, int(place_of[row]))
        model.add_point3D(orientation.points[orientation.point[group[0]]], track, np.zeros(3, dtype=np.uint8))
