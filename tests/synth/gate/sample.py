"""A run that the bounds below let pass, and a runner that writes it where the commands would have."""

import json
from pathlib import Path

from synth.child import Finished

BOUNDS = {
    "mae_mm": (0.001, 0.02),
    "largest_mm": (0.001, 0.04),
    "sigma_mm": (0.005, 0.05),
    "sigma_over_rms": (0.5, 5),
    "within_2_sigma": (0.75, 1),
    "coverage_deg": (340, 360),
    "coverage_percent": (95, 100),
    "surface_bias_mm": (0, 0.02),
    "surface_noise_mm": (0.01, 0.1),
    "camera_along_mm": (0.001, 0.02),
    "camera_radial_mm": (0.001, 0.02),
    "focal_percent": (0.01, 0.3),
    "lens_px": (0.01, 1.5),
    "calibrated_percent": (100, 100),
    "keypoints_per_image": (1000, 5000),
    "reprojection_px": (0.01, 0.1),
    "shared_marks": (400, 5000),
    "seconds": (5, 300),
    "peak_memory_mb": (100, 1024),
}


def evaluation():
    return {
        "format": 1,
        "diameters": {
            "stations": [
                {"name": "A", "difference_mm": 0.003, "sigma_mm": 0.01},
                {"name": "B", "difference_mm": -0.004, "sigma_mm": 0.02},
            ],
            "mean_absolute_mm": 0.0035,
            "largest_mm": 0.004,
        },
        "cameras": {
            "as_they_stand": [
                {"block": "Block1", "along_mm": 9.0, "radial_mm": 9.0},
                {"block": "all", "along_mm": 0.004, "radial_mm": 0.003},
            ]
        },
        "lenses": [
            {"focal_percent": 0.05, "displacement_px": 0.2},
            {"focal_percent": -0.1, "displacement_px": 0.5},
        ],
        "surface": {"coverage_percent": 98.0, "bias_mm": -0.005, "noise_mm": 0.05},
    }


def report():
    blocks = [{"images": 16, "calibrated": 16, "keypoints_per_image": 3000.0, "reprojection_px": 0.04}]
    blocks.append({"images": 16, "calibrated": 16, "keypoints_per_image": 2000.0, "reprojection_px": 0.06})
    stations = [{"coverage_deg": 360.0}, {"coverage_deg": 350.0}]
    return {
        "blocks": blocks,
        "stations": stations,
        "mosaic": {"tie_points": 1500},
        "peak_memory_mb": 512.0,
    }


TRUTH = {"stations": [{"name": n, "diameter_mm": 111.0, "base_diameter_mm": 111.0} for n in ("A", "B")]}


def write_bounds(folder, scenarios=("paper", "sway"), **changes):
    """bounds.toml with these scenarios, their specifications beside it; gives its path."""
    lines = []
    for name in scenarios:
        (folder / f"{name}.toml").write_text("seed = 5\n")
        lines.append(f"[{name}]")
        lines += [f"{figure} = {list(pair)}" for figure, pair in {**BOUNDS, **changes}.items()]
    path = folder / "bounds.toml"
    path.write_text("\n".join(lines) + "\n")
    return path


class Bench:
    """Stands for the commands: writes what they would, with other words for one scenario."""

    def __init__(self, scenario="", evaluation=evaluation, report=report, failure=None, seconds=60.0):
        self.scenario, self.failure, self.seconds = scenario, failure, seconds
        self.evaluation, self.report = evaluation, report

    def __call__(self, command, log, beat):
        beat()
        mine = any(f"/{self.scenario}/" in word for word in command)
        words = command[2:]
        match words:
            case ["synth", "render", _, survey, *_]:
                Path(survey).mkdir(parents=True, exist_ok=True)
                (Path(survey) / "truth.json").write_text(json.dumps(TRUTH))
            case ["pipeline", "run", _, "--out", run, *_]:
                if mine and self.failure:
                    return Finished(failure=self.failure, seconds=self.seconds)
                Path(run).mkdir(parents=True)
                made = self.report if mine else report
                (Path(run) / "report.json").write_text(json.dumps(made()))
            case ["pipeline", "evaluate", *_, "--json", file]:
                made = self.evaluation if mine else evaluation
                Path(file).write_text(json.dumps(whole(made())))
        return Finished(failure=None, seconds=self.seconds)


def whole(found):
    """With what the suite reads besides."""
    for station in found["diameters"]["stations"]:
        station.setdefault("model_mm", 111.0 + station["difference_mm"])
        station.setdefault("truth_mm", 111.0)
    return found
