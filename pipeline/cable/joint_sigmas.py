"""How well the joint adjustment knows what it found: lenses, blocks as a whole, and diameters.

Takes the adjusted bundle with its covariance; gives standard deviations and covariances.
"""

from dataclasses import replace

import numpy as np

from pipeline.cable.joint_rig import camera_poses
from pipeline.core.bundle import BundleResult
from pipeline.core.division import bend_per_lambda, with_unknowns
from pipeline.core.normals import gradient_through_points
from pipeline.core.rig import LENS_PARAMETERS, POSE_PARAMETERS
from pipeline.core.rotations import cross_matrix
from pipeline.core.vocabulary import Array, Lens

SECTION_STEP_M = 0.02
"""Distance of the sections whose standard deviation is carried through, and their half width."""


def refined_lens(number: int, stated: Lens, result: BundleResult) -> Lens:
    """The block's lens as adjusted, with its standard deviations."""
    if stated.focal_sigma_px == stated.lambda_sigma == 0:
        return stated  # held: it comes back to the last digit
    rig = result.rig
    lens = with_unknowns(stated, rig.lenses[number])
    first = rig.lens_unknowns.start + LENS_PARAMETERS * number
    sigmas = np.sqrt(np.diag(result.covariance)[first : first + LENS_PARAMETERS])
    per_lambda = bend_per_lambda(lens)
    return replace(lens, focal_sigma_px=float(sigmas[0]), lambda_sigma=float(sigmas[3] / per_lambda))


def block_covariance(result: BundleResult, blocks: int) -> Array:
    """Covariance of each block as a whole: the similarity that its cameras' joint errors amount to."""
    rig = result.rig
    frames = len(rig.body_rotations)
    maps = []
    for camera in range(blocks):
        poses = camera_poses(rig, camera)
        by_unknowns = np.zeros((frames, 6, rig.unknowns))
        mount = slice(POSE_PARAMETERS * (frames + camera), POSE_PARAMETERS * (frames + camera + 1))
        back = rig.body_rotations.transpose(0, 2, 1)
        for k in range(frames):
            body = slice(POSE_PARAMETERS * k, POSE_PARAMETERS * (k + 1))
            by_unknowns[k, :3, body][:, :3] = rig.mount_rotations[camera]
            by_unknowns[k, 3:, body][:, :3] = back[k] @ cross_matrix(rig.mount_centres[camera])
            by_unknowns[k, 3:, body][:, 3:] = np.eye(3)
            by_unknowns[k, :3, mount][:, :3] = np.eye(3)
            by_unknowns[k, 3:, mount][:, 3:] = back[k]
        arms = poses.centres - np.array([0.0, poses.centres[:, 1].mean(), 0.0])
        by_whole = np.zeros((frames, 6, 7))
        by_whole[:, :3, :3] = -poses.rotations
        by_whole[:, 3:, :3] = -cross_matrix(arms)
        by_whole[:, 3:, 3:6] = np.eye(3)
        by_whole[:, 3:, 6] = arms
        inverse = np.linalg.pinv(by_whole.reshape(-1, 7))
        maps.append(inverse @ by_unknowns.reshape(-1, rig.unknowns))
    whole = np.concatenate(maps)
    return whole @ result.covariance @ whole.T


def diameter_sigmas(result: BundleResult, blocks: int, y_m: Array) -> tuple[Array, Array, Array]:
    """Places along the cable, the diameter's standard deviation there (mm), and the lenses' share of it.

    A section is the circle through the tie points around it; they follow the orientations along their rays.
    The lenses' share is what would go if they were known: total variance less that with the lenses given.
    """
    points = result.rig.points
    places = np.arange(y_m.min(), y_m.max() + 1e-9, SECTION_STEP_M)
    gains = np.zeros((len(places), len(points), 3))
    for number, place in enumerate(places):
        near = np.flatnonzero(np.abs(points[:, 1] - place) < SECTION_STEP_M)
        centre = np.median(points[near], axis=0)
        away = points[near] - centre
        out = away * [1, 0, 1] / np.hypot(away[:, 0], away[:, 2])[:, None]
        design = np.column_stack([np.ones(len(near)), out[:, 0], out[:, 2]])
        gains[number, near] = 2 * np.linalg.pinv(design)[0][:, None] * out
    gradient = 1000 * gradient_through_points(result.normals, gains)
    total = np.einsum("nu,uv,nv->n", gradient, result.covariance, gradient)
    lenses = result.rig.lens_unknowns
    lens = lenses.start + np.flatnonzero(np.diag(result.covariance)[lenses] > 0)
    if not len(lens):
        return places, np.sqrt(total), np.zeros_like(total)
    towards = gradient @ result.covariance[:, lens]
    share = np.einsum("nl,lk,nk->n", towards, np.linalg.inv(result.covariance[np.ix_(lens, lens)]), towards)
    return places, np.sqrt(total), np.sqrt(np.minimum(share, total))
