"""A simulator of target networks with known truth, written without a look at pipeline/steel's formulas."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from pipeline.steel.records import Feature, FeatureKind, StationFeatures
from pipeline.steel.survey_records import Scanner, ScanStation, SteelSurvey

ARCSEC = np.pi / 180 / 3600


@dataclass(frozen=True, kw_only=True)
class Simulated:
    """A survey of targets, what the stations saw, and the truth in the base station's frame."""

    survey: SteelSurvey
    found: list[StationFeatures]
    rotations: np.ndarray
    translations: np.ndarray
    targets: dict[str, np.ndarray]


def survey_of(names, *, levelled=False, control=(), level_sigma_arcsec=5.0):
    """A survey that consists of stations alone."""
    return SteelSurvey(
        format=1,
        kind="steel",
        name="simulated",
        scanner=Scanner(levelled=levelled, level_sigma_arcsec=level_sigma_arcsec),
        stations=tuple(ScanStation(name=name) for name in names),
        control=tuple(control),
    )


def point(name, place, sigma_m):
    """A point feature with the same standard deviation along each axis."""
    return Feature(
        kind=FeatureKind.POINT,
        name=name,
        place=np.asarray(place, dtype=float),
        direction=np.zeros(3),
        frame=np.eye(3),
        covariance=sigma_m**2 * np.eye(3),
        radius_m=0.0,
        points=0,
        rms_m=0.0,
    )


def place_in_hall(count, seed, spacing_m=8.0, along=None):
    """Stations (count, 3) on a grid, and targets: (6 to 10) within reach of each."""
    rng = np.random.default_rng(seed)
    along = along or int(np.ceil(np.sqrt(count * 1.5)))
    cells = np.array([(k % along, k // along) for k in range(count)], dtype=float)
    stations = np.column_stack([cells * spacing_m, np.zeros(count)]) + rng.normal(scale=0.5, size=(count, 3))
    extent = stations.max(axis=0) + spacing_m
    per_station = 2.2
    number = int(count * per_station) + 4
    targets = np.column_stack(
        [rng.uniform(-spacing_m, extent[0], number), rng.uniform(-spacing_m, extent[1], number)]
    )
    return stations, np.column_stack([targets, rng.uniform(-1.0, 4.0, number)])


def simulate(
    count=12,
    seed=0,
    *,
    sigma_m=0.002,
    stated_sigma_m=None,
    nearest=8,
    levelled=False,
    along=None,
    level_sigma_arcsec=5.0,
    along_sigma_m=None,
):
    """Simulate stations that each see their nearest targets, in frames of their own.

    ``along_sigma_m``: noise along the ray, where it differs from ``sigma_m`` across.
    """
    rng = np.random.default_rng(1000 + seed)
    places, targets = place_in_hall(count, seed, along=along)
    if levelled:
        turns = Rotation.from_rotvec(np.outer(rng.uniform(-np.pi, np.pi, count), [0, 0, 1]))
        tilts = Rotation.from_rotvec(
            rng.normal(scale=level_sigma_arcsec * ARCSEC, size=(count, 3)) * [1, 1, 0]
        )
        turns = turns * tilts
    else:
        turns = Rotation.random(count, random_state=seed)
    site_from_station = turns.as_matrix()
    names = [f"S{k + 1:03d}" for k in range(count)]
    found = []
    for k, name in enumerate(names):
        nearest_first = np.argsort(np.linalg.norm(targets - places[k], axis=1))[:nearest]
        local = (targets[nearest_first] - places[k]) @ site_from_station[k]
        local += noise(rng, local, sigma_m, along_sigma_m)
        seen = [
            point(f"T{n + 1:03d}", p, stated_sigma_m or sigma_m)
            for n, p in zip(nearest_first, local, strict=True)
        ]
        found.append(StationFeatures(station=name, features=tuple(seen)))
    base_from_site = site_from_station[0].T
    return Simulated(
        survey=survey_of(names, levelled=levelled, level_sigma_arcsec=level_sigma_arcsec),
        found=found,
        rotations=base_from_site @ site_from_station,
        translations=(places - places[0]) @ base_from_site.T,
        targets={f"T{n + 1:03d}": base_from_site @ (p - places[0]) for n, p in enumerate(targets)},
    )


def noise(rng, places, sigma_m, along_sigma_m):
    """(n, 3) of it, the part along the rays to (n, 3) places by its own size where that is given."""
    off = rng.normal(scale=sigma_m, size=places.shape)
    if along_sigma_m is None:
        return off
    rays = places / np.linalg.norm(places, axis=1, keepdims=True)
    along = rng.normal(scale=along_sigma_m, size=(len(places), 1))
    return off + (along - np.sum(off * rays, axis=1, keepdims=True)) * rays


def pose_errors(poses, simulated):
    """Errors of the poses in their station frame's own terms: metres (S, 3) and radians (S, 3)."""
    places = np.array([pose.translation for pose in poses]) - simulated.translations
    turns = [
        Rotation.from_matrix(pose.rotation @ R.T).as_rotvec()
        for pose, R in zip(poses, simulated.rotations, strict=True)
    ]
    return places, np.array(turns)
