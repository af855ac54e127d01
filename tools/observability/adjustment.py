"""The pipeline's adjustment on simulated measurements, the focal length free or held at a wrong value.

Takes a :class:`~tools.observability.simulation.Simulation`; gives the errors of focal length and diameter and
the reprojection error.  Lambda is always free, from zero.
"""

from dataclasses import dataclass

import numpy as np

from pipeline.core.bundle import BundleOptions, BundleResult, RigPriors, adjust_bundle
from pipeline.core.fits.cylinder import fit_cylinder
from pipeline.core.rig import Rig
from pipeline.core.rotations import nominal_cam_from_world
from pipeline.core.vocabulary import Array
from tools.observability.simulation import RADIUS_M, Simulation

SIGMA_PX = 0.1
LOSS_SCALES_PX = (20.0, 1.0)
END_SIGMA_M = 2e-5
"""How tightly the ends of the travel are held; between them three times the wander of the speed, as a bridge
(pipeline/cable/pos.py)."""


@dataclass(frozen=True, kw_only=True)
class Found:
    """What an adjustment gives.

    Attributes:
        focal_percent: error of the focal length, mean over the cameras.
        diameter_mm: error of the diameter of the cylinder through all points.
        reprojection_px: root mean square residual; shared marks by their weight.
        cost: what the adjustment minimises: weighted squares of measurements (Cauchy) and priors.
    """

    focal_percent: float
    diameter_mm: float
    reprojection_px: float
    cost: float


def adjust(simulation: Simulation, focal_error_percent: float, *, held: bool) -> Found:
    """Adjust with the focal length stated wrong by so much.

    Args:
        simulation: the measurements.
        focal_error_percent: of the stated focal length.
        held: true keeps it there, false frees it.
    """
    true_focal_px = simulation.lens.focal_px
    rig = _nominal(simulation, true_focal_px * (1 + focal_error_percent / 100))
    priors = _priors(simulation, rig, held)
    for scale in LOSS_SCALES_PX:
        options = BundleOptions(sigma_px=SIGMA_PX, loss_scale_px=scale, iterations=60)
        result = adjust_bundle(rig, simulation.observations, priors, options, lambda done, total: None)
        rig = result.rig
    cylinder = fit_cylinder(rig.points, direction=(0.0, 1.0, 0.0))
    return Found(
        focal_percent=float(100 * (rig.lenses[:, 0].mean() / true_focal_px - 1)),
        diameter_mm=2000 * (cylinder.radius - RADIUS_M),
        reprojection_px=float(np.sqrt(np.mean(np.sum(result.residuals**2, axis=1)))),
        cost=_cost(result, priors),
    )


def _cost(result: BundleResult, priors: RigPriors) -> float:
    scale_px = LOSS_SCALES_PX[-1]
    squares = np.sum(result.residuals**2, axis=1) / scale_px**2
    deviation, sigmas = priors.deviation(result.rig), priors.sigmas
    known = sigmas > 0
    priors_part = np.sum((deviation[known] / sigmas[known]) ** 2)
    return float((scale_px / SIGMA_PX) ** 2 * np.log1p(squares).sum() + priors_part)


def _nominal(simulation: Simulation, focal_px: float) -> Rig:
    """The robot as it was built, gliding evenly along the axis."""
    robot, angles = simulation.spec.robot, simulation.spec.angles_deg[: simulation.cameras]
    radians = np.radians(angles)
    y = np.linspace(0, robot.travel_m, robot.frames)
    lens = [focal_px, *simulation.lens.principal_point_px, 0.0]
    return Rig(
        body_rotations=np.tile(np.eye(3), (robot.frames, 1, 1)),
        body_centres=np.stack([0 * y, y, 0 * y], axis=1),
        mount_rotations=np.stack([nominal_cam_from_world(a, robot.travel_in_image) for a in angles]),
        mount_centres=robot.standoff_m * np.stack([np.cos(radians), 0 * radians, -np.sin(radians)], axis=1),
        lenses=np.tile(lens, (simulation.cameras, 1)),
        points=simulation.starts,
    )


def _priors(simulation: Simulation, nominal: Rig, held: bool) -> RigPriors:
    """As honest as the specification: its sway, wander and mountings are the standard deviations."""
    robot = simulation.spec.robot
    fraction = np.linspace(0, 1, robot.frames)
    body = np.tile(_pose_sigmas(robot.sway_deg, robot.sway_mm), (robot.frames, 1))
    bridge = 3 * robot.speed_wander_mm / 1000 * 2 * np.sqrt(fraction * (1 - fraction))
    body[:, 4] = np.hypot(bridge, END_SIGMA_M)
    lens_sigmas = np.tile([0.0 if held else np.inf, 0.0, 0.0, np.inf], (simulation.cameras, 1))
    return RigPriors(
        reference=nominal,
        body_sigmas=body,
        mount_sigmas=np.tile(_pose_sigmas(robot.mounting_deg, robot.mounting_mm), (simulation.cameras, 1)),
        lens_sigmas=lens_sigmas,
    )


def _pose_sigmas(angle_deg: float, shift_mm: float) -> Array:
    return np.array([np.radians(angle_deg)] * 3 + [shift_mm / 1000] * 3)
