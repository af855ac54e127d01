"""Photos of a structure to a cloud in a frame and a scale of their own.

Takes a folder of pictures of one camera and a start of its focal length; gives the oriented photos and the
dense cloud.  The order, no algorithm: :mod:`pipeline.steel.photo_sparse`, :mod:`pipeline.steel.photo_dense`.
Place, turn and scale come from the scans (:mod:`pipeline.steel.fuse`).
"""

from dataclasses import dataclass, field, replace
from pathlib import Path

from pipeline.core.events import Emit, part
from pipeline.steel.fuse_records import PhotoCloud
from pipeline.steel.photo_dense import densify
from pipeline.steel.photo_records import DepthOptions, OrientedPhotos, SparseOptions
from pipeline.steel.photo_sparse import orient, pictures_in
from pipeline.steel.photo_targets import find_targets


@dataclass(frozen=True, kw_only=True)
class PhotoModelOptions:
    """How photos become a cloud.

    Attributes:
        sparse: their orientation.
        depth: their depth maps.
    """

    sparse: SparseOptions = field(default_factory=SparseOptions)
    depth: DepthOptions = field(default_factory=DepthOptions)


@dataclass(frozen=True, kw_only=True)
class PhotoModel:
    """Photos and their cloud, both in the photo frame."""

    photos: OrientedPhotos
    cloud: PhotoCloud


def photo_model(
    folder: Path, focal_px: float, scratch: Path, options: PhotoModelOptions, emit: Emit
) -> PhotoModel:
    """Make the model.

    Args:
        folder: of the pictures.
        focal_px: start of the focal length.
        scratch: a folder that may be emptied.
        options: see there.
        emit: told every half second at least.

    Raises:
        StageError: too few pictures, unreadable ones, too little overlap or texture.
    """
    photos = orient(pictures_in(folder), focal_px, scratch, options.sparse, part(emit, 0.0, 0.35))
    spheres = find_targets(photos, part(emit, 0.35, 0.4))
    cloud = densify(photos, options.depth, part(emit, 0.4, 1.0))
    return PhotoModel(photos=photos, cloud=replace(cloud, spheres=spheres))
