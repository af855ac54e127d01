"""The figures that the gate looks at, drawn from evaluation.json and report.json.

Takes the plain JSON values of both; gives one number for each name in :data:`FIGURES`.  Leaves out what is
good enough (``bounds.py``).
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

Json = Mapping[str, Any]


@dataclass(frozen=True)
class Case:
    """What a reconstructed survey left: evaluation.json, report.json, and the seconds that it took."""

    evaluation: Json
    report: Json
    seconds: float

    @property
    def stations(self) -> list[Json]:
        """The stations of the evaluation."""
        return list(self.evaluation["diameters"]["stations"])

    @property
    def blocks(self) -> list[Json]:
        """The blocks of the report."""
        return list(self.report["blocks"])

    @property
    def lenses(self) -> list[Json]:
        """The lenses of the evaluation."""
        return list(self.evaluation["lenses"])


def rms_mm(case: Case) -> float:
    """Root mean square error of the diameters."""
    return math.sqrt(sum(s["difference_mm"] ** 2 for s in case.stations) / len(case.stations))


def mean_sigma_mm(case: Case) -> float:
    """Mean of the stated standard deviations."""
    return float(sum(s["sigma_mm"] for s in case.stations) / len(case.stations))


def within_2_sigma(case: Case) -> float:
    """Share of the stations whose error is at most two of their sigmas."""
    inside = [abs(s["difference_mm"]) <= 2 * s["sigma_mm"] for s in case.stations]
    return sum(inside) / len(inside)


def all_cameras(case: Case) -> Json:
    """Errors of all projection centres together, as they stand in the cable frame."""
    found: Json = next(c for c in case.evaluation["cameras"]["as_they_stand"] if c["block"] == "all")
    return found


FIGURES: Mapping[str, Callable[[Case], float]] = {
    "mae_mm": lambda case: case.evaluation["diameters"]["mean_absolute_mm"],
    "largest_mm": lambda case: case.evaluation["diameters"]["largest_mm"],
    "sigma_mm": mean_sigma_mm,
    "sigma_over_rms": lambda case: mean_sigma_mm(case) / rms_mm(case),
    "within_2_sigma": within_2_sigma,
    "coverage_deg": lambda case: min(s["coverage_deg"] for s in case.report["stations"]),
    "coverage_percent": lambda case: case.evaluation["surface"]["coverage_percent"],
    "surface_bias_mm": lambda case: abs(case.evaluation["surface"]["bias_mm"]),
    "surface_noise_mm": lambda case: case.evaluation["surface"]["noise_mm"],
    "camera_along_mm": lambda case: all_cameras(case)["along_mm"],
    "camera_radial_mm": lambda case: all_cameras(case)["radial_mm"],
    "focal_percent": lambda case: max(abs(lens["focal_percent"]) for lens in case.lenses),
    "lens_px": lambda case: max(lens["displacement_px"] for lens in case.lenses),
    "calibrated_percent": lambda case: (
        100 * sum(b["calibrated"] for b in case.blocks) / sum(b["images"] for b in case.blocks)
    ),
    "keypoints_per_image": lambda case: min(b["keypoints_per_image"] for b in case.blocks),
    "reprojection_px": lambda case: max(b["reprojection_px"] for b in case.blocks),
    "shared_marks": lambda case: case.report["mosaic"]["tie_points"],
    "seconds": lambda case: case.seconds,
    "peak_memory_mb": lambda case: case.report["peak_memory_mb"],
}
"""Name, with its unit, to how it is drawn; the worst block or station speaks for all (docs/accuracy.md)."""


def figures_of(case: Case) -> dict[str, float | None]:
    """Every figure of a case; None where the documents do not hold it."""
    return {name: _drawn(draw, case) for name, draw in FIGURES.items()}


def _drawn(draw: Callable[[Case], float], case: Case) -> float | None:
    """A key that is gone, an empty list or a null leave the figure out; the bounds then say so."""
    try:
        value = float(draw(case))
    except (KeyError, TypeError, ValueError, StopIteration, ZeroDivisionError):
        return None
    return value if math.isfinite(value) else None
