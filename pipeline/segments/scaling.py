"""An adjusted ring in another scale: every length times the same factor.

Takes a :class:`~pipeline.cable.joint.RingOrientation`; gives another one.  Angles, pixels and relative
standard deviations stay.
"""

from dataclasses import replace

import numpy as np

from pipeline.cable.adjust import LensEffect, Orientation
from pipeline.cable.joint import RingOrientation
from pipeline.cable.joint_path import RingPath
from pipeline.cable.joint_sections import RingSigmas

SHIFTS = slice(3, 6)
"""Where the shift stands in a similarity: rotation vector, shift, scale."""


def scaled_ring(ring: RingOrientation, scale: float) -> RingOrientation:
    """The ring with all lengths, places and their standard deviations times ``scale``."""
    units = np.ones((len(ring.blocks), 7))
    units[:, SHIFTS] = scale
    effect = ring.surface_effect
    return replace(
        ring,
        blocks=tuple(_block(b, scale) for b in ring.blocks),
        covariance=ring.covariance * np.outer(units, units),
        section_y_m=scale * ring.section_y_m,
        diameter_sigma_mm=scale * ring.diameter_sigma_mm,
        lens_sigma_mm=scale * ring.lens_sigma_mm,
        strips=_strips(ring.strips, scale),
        readout_mm=scale * ring.readout_mm,
        readout_sigma_mm=scale * ring.readout_sigma_mm,
        path=None if ring.path is None else _path(ring.path, scale),
        surface_effect=None
        if effect is None
        else replace(
            effect,
            without_mm=scale * effect.without_mm,
            with_mm=scale * effect.with_mm,
            without_sigma_mm=scale * effect.without_sigma_mm,
            with_sigma_mm=scale * effect.with_sigma_mm,
        ),
    )


def _block(block: Orientation, scale: float) -> Orientation:
    poses, effect = block.poses, block.lens_effect
    units = np.ones(7)
    units[SHIFTS] = scale
    return replace(
        block,
        poses=replace(poses, translations=scale * poses.translations, readout_m=scale * poses.readout_m),
        points=scale * block.points,
        datum_origin=scale * block.datum_origin,
        datum_information=block.datum_information / np.outer(units, units),
        lens_effect=None if effect is None else _effect(effect, scale),
    )


def _effect(effect: LensEffect, scale: float) -> LensEffect:
    return replace(effect, points_uncorrected=scale * effect.points_uncorrected)


def _strips(strips: RingSigmas, scale: float) -> RingSigmas:
    return replace(
        strips,
        y_m=scale * strips.y_m,
        strips_mm2=scale**2 * strips.strips_mm2,
        lens_mm2=scale**2 * strips.lens_mm2,
    )


def _path(path: RingPath, scale: float) -> RingPath:
    units = np.ones(2 * len(path.y_m))
    units[: len(path.y_m)] = scale
    return replace(
        path,
        y_m=scale * path.y_m,
        covariance_m2=scale**2 * path.covariance_m2,
        size_m=scale * path.size_m,
        size_sigma_m=scale * path.size_sigma_m,
        across_covariance=path.across_covariance * np.outer(units, units),
    )
