"""Features of photos and their matches: SIFT, one picture and one pair at a time.

Takes picture files; gives places (origin at the corner) with root descriptors, and mutual best matches.
Leaves out the geometry that verifies them (photo_mapping.py).

Source: R. Arandjelovic and A. Zisserman, "Three things everyone should know to improve object retrieval",
CVPR 2012 (root descriptors).
"""

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from pipeline.core.errors import StageError
from pipeline.core.vocabulary import Array
from pipeline.steel.photo_records import SparseOptions

STAGE = "photos"
Features = tuple[Array, NDArray[np.float32]]


def features_of(file: Path, options: SparseOptions) -> tuple[Features, tuple[int, int]]:
    """Features of a picture, and its height and width.

    Raises:
        StageError: it cannot be read.
    """
    picture = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE)
    if picture is None:
        raise StageError(STAGE, f"{file} cannot be read as a picture", "remove it or take it anew")
    # without the precise upscaling OpenCV's places are a quarter of a pixel off, both ways
    sift = cv2.SIFT.create(options.features, contrastThreshold=0.02, enable_precise_upscale=True)
    marks, raw = sift.detectAndCompute(picture, None)
    if raw is None:
        return (np.zeros((0, 2)), np.zeros((0, 128), dtype=np.float32)), picture.shape
    # OpenCV's places count from the first pixel's centre, ours from its corner
    places = np.array([mark.pt for mark in marks]) + 0.5
    # several orientations at one place are one place
    _, once = np.unique(np.round(places, 2), axis=0, return_index=True)
    root = np.sqrt(raw / np.maximum(raw.sum(axis=1, keepdims=True), 1e-9)).astype(np.float32)
    return (places[np.sort(once)], root[np.sort(once)]), picture.shape


def matches_of(first: Features, second: Features, ratio: float) -> NDArray[np.uint32]:
    """(k, 2) numbers of features that are each other's best and clearly better than the second best."""
    if min(len(first[0]), len(second[0])) < 2:
        return np.zeros((0, 2), dtype=np.uint32)
    alike = first[1] @ second[1].T
    best = alike.argmax(axis=1)
    mutual = np.flatnonzero(alike.argmax(axis=0)[best] == np.arange(len(best)))
    top = alike[mutual, best[mutual]]
    alike[mutual, best[mutual]] = -1.0
    clear = 1 - top < ratio**2 * (1 - alike[mutual].max(axis=1))
    return np.stack([mutual[clear], best[mutual[clear]]], axis=1).astype(np.uint32)
