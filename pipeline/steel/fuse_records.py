"""What fusing photos and scans works on and what comes out of it.

Frames: *photo* is the photo model's own, arbitrary in place, turn and scale; *site* is the scans', metres.
"""

from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.core.vocabulary import Array

PHOTO = -1
"""Origin of a merged point that came from photos; scanned points carry their station's number, from 0."""


class Start(StrEnum):
    """What brought the two clouds together before their points did."""

    PAIRS = "pairs"
    FEATURES = "features"
    UNROLLED = "unrolled"


@dataclass(frozen=True, kw_only=True)
class PhotoCloud:
    """A cloud from photos.

    Attributes:
        points: (n, 3) photo frame.
        normals: (n, 3) unit vectors towards the cameras; (0, 3) where there are none.
        colours: (n, 3) uint8 red, green, blue.
        sigmas: (n,) standard deviation of each point along its ray, photo units; (0,) where not known.
        spheres: (k, 4) centre and radius of spheres that the photos themselves show, photo units.
    """

    points: Array
    normals: Array
    colours: NDArray[np.uint8]
    sigmas: Array
    spheres: Array = field(default_factory=lambda: np.zeros((0, 4)))

    def __len__(self) -> int:
        return len(self.points)


@dataclass(frozen=True, kw_only=True)
class ScanCloud:
    """Registered scans.

    Attributes:
        points: (n, 3) site frame, metres.
        stations: (n,) number of each point's station.
        scanners: (k, 3) where the stations stood, for the side a surface was seen from; (0, 3) if unknown.
        intensities: (n,) any unit; (0,) where there are none.
    """

    points: Array
    stations: NDArray[np.int64]
    scanners: Array
    intensities: Array

    def __len__(self) -> int:
        return len(self.points)

    def where(self, chosen: NDArray[np.bool_] | NDArray[np.int64]) -> "ScanCloud":
        """Some of the points."""
        return ScanCloud(
            points=self.points[chosen],
            stations=self.stations[chosen],
            scanners=self.scanners,
            intensities=self.intensities[chosen] if len(self.intensities) else self.intensities,
        )


@dataclass(frozen=True, kw_only=True)
class GivenPair:
    """A place that a person has pointed out in both clouds.

    Attributes:
        name: for the residuals.
        photo: (3,) photo frame.
        site: (3,) metres.
    """

    name: str
    photo: Array
    site: Array


@dataclass(frozen=True, kw_only=True)
class FuseOptions:
    """How a photo cloud is brought into the site frame.

    Attributes:
        scale_sigma_share: 0 where the photos know nothing of the scale (photos of a structure), else how far
            it may be off as a share (a cable's model is metric already: 0.01).
        elongated: how many times longer than wide both clouds must be for a cable, which is brought together
            by its unrolled surfaces where there are no features.
        ball_share: spheres of photo and scan agree in radius within this share, once scaled.
        feature_tolerance_mm: a sphere's centre from photos may lie so far off.
        least_features: fewer common spheres are no match.
        clear: a rival placement is one that has more than this share of the best one's agreement.
        photo_points: so many of the photo's points, evenly spread, are laid onto the scan.
        scan_spacing_mm: the scan is thinned to this, which smooths its noise.
        gate_mm: points farther from the surface than this at the start are no partners; it then shrinks.
        least_overlap: share of the photo's points that must have a partner.
        iterations: most steps.
        undetermined_mm: a direction that two thirds of all errors reach farther than this is said to be
            undetermined.
    """

    scale_sigma_share: float = field(default=0.0, metadata={"minimum": 0.0, "maximum": 0.2})
    elongated: float = field(default=3.0, metadata={"minimum": 1.5})
    ball_share: float = field(default=0.15, metadata={"above": 0.0, "maximum": 1.0})
    feature_tolerance_mm: float = field(default=30.0, metadata={"above": 0.0})
    least_features: int = field(default=4, metadata={"minimum": 3})
    clear: float = field(default=0.8, metadata={"above": 0.0, "maximum": 1.0})
    photo_points: int = field(default=20_000, metadata={"minimum": 500})
    scan_spacing_mm: float = field(default=8.0, metadata={"above": 0.0})
    gate_mm: float = field(default=60.0, metadata={"above": 0.0})
    least_overlap: float = field(default=0.1, metadata={"above": 0.0, "maximum": 1.0})
    iterations: int = field(default=40, metadata={"minimum": 5})
    undetermined_mm: float = field(default=20.0, metadata={"above": 0.0})


@dataclass(frozen=True, kw_only=True)
class Placement:
    """Seven parameters: x_site = scale * rotation @ x_photo + translation."""

    scale: float
    rotation: Array
    translation: Array

    def apply(self, points_in_photo: ArrayLike) -> Array:
        """(..., 3) points of the photo frame in the site frame."""
        return self.scale * np.asarray(points_in_photo, dtype=float) @ self.rotation.T + self.translation


@dataclass(frozen=True, kw_only=True)
class FusedPair:
    """A feature or given place that both clouds have.

    Attributes:
        name: given, or "sphere 1", ...
        photo, site: (3,) as they came.
        residual_mm: (3,) site frame: the photo's place less the scan's, after the fusion.
    """

    name: str
    photo: Array
    site: Array
    residual_mm: Array


@dataclass(frozen=True, kw_only=True)
class Direction:
    """A way in which the photo cloud could still move against the scan.

    Attributes:
        motion: (7,) rotation vector (radians), translation of ``centre`` (metres), relative scale; scaled to
            move the cloud by 1 m on the average (root mean square).
        sigma_mm: how far two thirds of all errors move the cloud this way; where nothing holds it, how far it
            might be off at all.
        held_by: "points", "pairs", "features", "relief", "brightness", or "" where nothing holds it.
        words: what it is, e.g. "a turn about the cable's axis".
    """

    motion: Array
    sigma_mm: float
    held_by: str
    words: str

    @property
    def determined(self) -> bool:
        """Whether anything holds the cloud this way."""
        return bool(self.held_by)


@dataclass(frozen=True, kw_only=True)
class Fusion:
    """A photo cloud in the site frame.

    Attributes:
        placement: the seven parameters.
        centre: (3,) metres, site frame: the point that the covariance's rotation turns about.
        covariance: (7, 7) of (rotation vector on the left in radians, translation of ``centre`` in metres,
            relative scale); a direction that nothing determines has the sigma of its whole play.
        start: what the points started from.
        pairs: features used, with residuals.
        directions: the seven, from the best determined to the least.
        places: (m, 3) photo points with a partner, site frame.
        residuals_mm: (m,) their distances from the scanned surface, positive on the side it was seen from.
        overlap: share of the photo's points that have one.
        median_mm: median size of the residuals: cloud to cloud.
        noise_mm: standard deviation of one residual, robust.
        patch_mm: size of a patch whose residuals err alike; the covariance counts patches, not points.
        notes: sentences for the report.
    """

    placement: Placement
    centre: Array
    covariance: Array
    start: Start
    pairs: tuple[FusedPair, ...]
    directions: tuple[Direction, ...]
    places: Array
    residuals_mm: Array
    overlap: float
    median_mm: float
    noise_mm: float
    patch_mm: float
    notes: tuple[str, ...]

    def sigmas_at_mm(self, points_in_site: ArrayLike) -> Array:
        """(n,) standard deviation of places (n, 3) from the seven parameters alone, the root of the trace."""
        away = np.asarray(points_in_site, dtype=float) - self.centre
        gains = np.zeros((len(away), 3, 7))
        x, y, z = away.T
        gains[:, 0, 1], gains[:, 0, 2] = z, -y
        gains[:, 1, 0], gains[:, 1, 2] = -z, x
        gains[:, 2, 0], gains[:, 2, 1] = y, -x
        gains[:, :, 3:6] = np.eye(3)
        gains[:, :, 6] = away
        variance = np.einsum("nij,jk,nik->n", gains, self.covariance, gains)
        return 1000 * np.sqrt(np.maximum(variance, 0))
