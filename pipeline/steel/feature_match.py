"""Spheres of a photo cloud and of a scan found to be the same ones, without names and without a scale.

Takes centres and radii of both; gives placements that many of them agree on, the best first.  Three centres
that make a triangle of the same shape (the ratios of its sides) propose a placement; the ratio of the radii
tells the scale roughly.  Leaves out which placement is right where a regular grid allows several: the points
decide (:mod:`pipeline.steel.fuse`).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from pipeline.core.errors import StageError
from pipeline.core.fits import fit_similarity
from pipeline.core.vocabulary import Array
from pipeline.steel.fuse_records import Placement
from pipeline.steel.triangles import Corners, Triangles, from_triangles, triangles

MOST_SPHERES = 40
"""Triangles are made of so many spheres of the scan, and so many of the photos; all are counted."""
MOST_PROPOSALS = 60_000


@dataclass(frozen=True, kw_only=True)
class Agreement:
    """A placement and the spheres that agree on it.

    Attributes:
        placement: seven parameters.
        photo, scan: (k,) numbers of the common spheres.
        rms_m: of the distances between them.
    """

    placement: Placement
    photo: NDArray[np.int64]
    scan: NDArray[np.int64]
    rms_m: float


def match_spheres(
    photo: Array, scan: Array, ball_share: float, tolerance_m: float, least: int, seed: int = 0
) -> list[Agreement]:
    """Placements that spheres agree on, the best first, each different from the others.

    Args:
        photo: (n, 4) centre and radius, photo frame.
        scan: (m, 4) the same, site frame, metres.
        ball_share: radii agree within this share, once scaled.
        tolerance_m: centres agree within this.
        least: fewer common spheres are no agreement.
        seed: of the choice among too many triangles.

    Raises:
        StageError: too few spheres, or all on a line, or none agree.
    """
    for name, spheres in (("photo", photo), ("scan", scan)):
        if len(spheres) < least:
            raise StageError(
                "fuse",
                f"{len(spheres)} spheres in the {name} cloud are too few to match, {least} are needed",
                "take photos that see more balls or targets, or give pairs of places by hand",
            )
        if not _is_wide(spheres[:, :3]):
            raise StageError(
                "fuse",
                f"the {len(spheres)} spheres of the {name} cloud lie on a line, which leaves a turn open",
                "give a pair of places off that line",
            )
    agreements = _agreements(photo, scan, ball_share, tolerance_m, least, seed)
    if not agreements:
        raise StageError(
            "fuse",
            f"no {least} of the {len(photo)} spheres of the photos lie to each other like {least} of the "
            f"{len(scan)} of the scans",
            "check that both show the same part of the structure, or give pairs of places by hand",
        )
    return agreements


def _agreements(
    photo: Array, scan: Array, ball_share: float, tolerance_m: float, least: int, seed: int
) -> list[Agreement]:
    first = triangles(_far_apart(photo, MOST_SPHERES), photo[:, :3])
    second = triangles(_far_apart(scan, MOST_SPHERES), scan[:, :3])
    rng = np.random.default_rng(seed)
    first = first.some(np.sort(rng.permutation(len(first.corners))[:3000]))
    # one sphere out of place by the tolerance changes a ratio by this much, at the triangles' usual size
    slack = 2 * tolerance_m / float(np.median(second.longest))
    near = KDTree(first.shape).query_ball_tree(KDTree(second.shape), slack)
    pairs = np.array([(i, j) for i, some in enumerate(near) for j in some], dtype=np.int64).reshape(-1, 2)
    pairs = pairs[_scale_fits(first, second, pairs, photo, scan, ball_share)]
    if len(pairs) > MOST_PROPOSALS:
        pairs = pairs[np.sort(rng.permutation(len(pairs))[:MOST_PROPOSALS])]
    tree = KDTree(scan[:, :3])
    counts = _counts(photo, scan, tree, first.corners[pairs[:, 0]], second.corners[pairs[:, 1]], tolerance_m)
    found: list[Agreement] = []
    for number in np.argsort(-counts, kind="stable")[:400]:
        if counts[number] < least:
            break
        i, j = pairs[number]
        agreement = _refined(
            photo, scan, tree, first.corners[i], second.corners[j], ball_share, tolerance_m, least
        )
        if agreement is not None and not any(_alike(agreement, other, photo, tolerance_m) for other in found):
            found.append(agreement)
    return sorted(found, key=lambda a: (-len(a.photo), a.rms_m))


def _far_apart(spheres: Array, most: int) -> NDArray[np.int64]:
    """Numbers of at most ``most`` spheres, each as far from those before it as can be."""
    if len(spheres) <= most:
        return np.arange(len(spheres))
    places = spheres[:, :3]
    chosen = [int(np.argmax(np.linalg.norm(places - places.mean(axis=0), axis=1)))]
    away = np.full(len(places), np.inf)
    while len(chosen) < most:
        away = np.minimum(away, np.linalg.norm(places - places[chosen[-1]], axis=1))
        chosen.append(int(np.argmax(away)))
    return np.array(chosen)


def _scale_fits(
    first: Triangles, second: Triangles, pairs: NDArray[np.int64], photo: Array, scan: Array, share: float
) -> NDArray[np.bool_]:
    scale = second.longest[pairs[:, 1]] / first.longest[pairs[:, 0]]
    radii = photo[first.corners[pairs[:, 0]], 3] * scale[:, None]
    return np.all(np.abs(radii / scan[second.corners[pairs[:, 1]], 3] - 1) < share, axis=1)


def _counts(
    photo: Array, scan: Array, tree: KDTree, first: Corners, second: Corners, tolerance_m: float
) -> NDArray[np.int64]:
    """How many photo spheres each pair of triangles brings next to a scan sphere."""
    counts = np.zeros(len(first), dtype=np.int64)
    for begin in range(0, len(first), 2000):
        mine = slice(begin, begin + 2000)
        scale, rotation, translation = from_triangles(photo[first[mine], :3], scan[second[mine], :3])
        places = (
            scale[:, None, None] * np.einsum("hij,nj->hni", rotation, photo[:, :3]) + translation[:, None]
        )
        away, _ = tree.query(places.reshape(-1, 3), distance_upper_bound=2 * tolerance_m)
        counts[mine] = np.isfinite(away.reshape(len(scale), -1)).sum(axis=1)
    return counts


def _refined(
    photo: Array,
    scan: Array,
    tree: KDTree,
    first: Corners,
    second: Corners,
    ball_share: float,
    tolerance_m: float,
    least: int,
) -> Agreement | None:
    scale, rotation, translation = from_triangles(photo[None, first, :3], scan[None, second, :3])
    placement = Placement(scale=float(scale[0]), rotation=rotation[0], translation=translation[0])
    for reach in (2.0, 1.5, 1.0):
        mine, theirs, off = _common(photo, scan, tree, placement, ball_share, reach * tolerance_m)
        if len(mine) < least or not _is_wide(photo[mine, :3]):
            return None
        fit = fit_similarity(photo[mine, :3], scan[theirs, :3])
        placement = Placement(scale=fit.scale, rotation=fit.rotation, translation=fit.translation)
    mine, theirs, off = _common(photo, scan, tree, placement, ball_share, tolerance_m)
    if len(mine) < least:
        return None
    return Agreement(placement=placement, photo=mine, scan=theirs, rms_m=float(np.sqrt(np.mean(off**2))))


def _common(
    photo: Array, scan: Array, tree: KDTree, placement: Placement, ball_share: float, reach_m: float
) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
    near: tuple[Array, NDArray[np.int64]] = tree.query(
        placement.apply(photo[:, :3]), distance_upper_bound=reach_m
    )  # type: ignore[assignment]
    away, index = near
    mine = np.flatnonzero(np.isfinite(away))
    theirs = index[mine]
    alike = np.abs(placement.scale * photo[mine, 3] / scan[theirs, 3] - 1) < ball_share
    mine, theirs = mine[alike], theirs[alike]
    # two photo spheres at one scan sphere: the nearer
    order = np.lexsort((away[mine], theirs))
    _, once = np.unique(theirs[order], return_index=True)
    mine, theirs = mine[order][once], theirs[order][once]
    return mine, theirs, away[mine]


def _alike(one: Agreement, other: Agreement, photo: Array, tolerance_m: float) -> bool:
    apart = one.placement.apply(photo[:, :3]) - other.placement.apply(photo[:, :3])
    return float(np.sqrt(np.mean(np.sum(apart**2, axis=1)))) < 5 * tolerance_m


def _is_wide(places: Array) -> bool:
    singular = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
    return bool(len(places) >= 3 and singular[1] > 0.03 * singular[0])
