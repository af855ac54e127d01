"""A made-up survey with known figures: a 111 mm cable, four blocks, four stations."""

import numpy as np

from pipeline.core.vocabulary import LambdaRadius
from pipeline.report.relief_records import ReliefFeature, ReliefSummary
from pipeline.report.types import (
    AxisSummary,
    BlockSummary,
    Cloud,
    DiameterProfile,
    LensEffect,
    LensPictures,
    Mesh,
    MosaicJoint,
    MosaicSummary,
    ReportData,
    StationResult,
    TruthStation,
    UnrolledPicture,
)

RADIUS_M, LENGTH_M = 0.0555, 0.46
TRUE_MM = {"A": 111.4, "B": 110.8, "C": 110.7, "D": 111.1}
DIFFERENCES_MM = {"A": 0.042, "B": -0.031, "C": 0.018, "D": -0.057}
BLOCKS = ("Block1", "Block2", "Block3", "Block4")


def surface_picture(height, width, seed=0):
    """Streaked grey sheath with an orange patch at the top left and marks every tenth of the height."""
    rng = np.random.default_rng(seed)
    streaks = rng.normal(0, 9, (1, width)) + rng.normal(0, 5, (height, width))
    grey = 128 + streaks + 22 * np.sin(np.arange(width) / width * 6 * np.pi)
    image = np.repeat(np.clip(grey, 0, 255)[:, :, None], 3, axis=2).astype(np.uint8)
    image[:: max(1, height // 10)] = (70, 74, 80)
    image[: height // 4, : width // 4] = (214, 120, 40)
    return image


def cylinder_mesh(rows=60, columns=120, texture=None):
    """Open regular mesh of the cylinder; u runs with the azimuth from 0 to 360 degrees, v with y."""
    azimuth = np.linspace(0, 2 * np.pi, columns + 1)
    y = np.linspace(0, LENGTH_M, rows + 1)
    a, along = np.meshgrid(azimuth, y)
    outward = np.stack([np.cos(a), np.zeros_like(a), -np.sin(a)], axis=-1)
    dents = 0.0004 * np.sin(7 * a) * np.sin(24 * along / LENGTH_M)
    vertices = (RADIUS_M + dents[..., None]) * outward + np.stack([0 * a, along, 0 * a], axis=-1)
    index = np.arange((rows + 1) * (columns + 1)).reshape(rows + 1, columns + 1)
    p, q, r, s = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    lower, upper = np.stack([p, q, r], axis=-1), np.stack([p, r, s], axis=-1)
    faces = np.concatenate([lower.reshape(-1, 3), upper.reshape(-1, 3)])
    return Mesh(
        vertices=vertices.reshape(-1, 3),
        normals=outward.reshape(-1, 3),
        faces=faces,
        uv=np.stack([a / (2 * np.pi), along / LENGTH_M], axis=-1).reshape(-1, 2),
        texture=surface_picture(64, 48) if texture is None else texture,
    )


def cylinder_cloud(count=500, seed=1):
    rng = np.random.default_rng(seed)
    azimuth = rng.uniform(0, 2 * np.pi, count)
    normals = np.stack([np.cos(azimuth), np.zeros(count), -np.sin(azimuth)], axis=1)
    points = RADIUS_M * normals
    points[:, 1] = rng.uniform(0, LENGTH_M, count)
    return Cloud(points=points, normals=normals, colours=rng.integers(0, 256, (count, 3), dtype=np.uint8))


def station(name, position_m, diameter_mm, seed=0, count=3000):
    rng = np.random.default_rng(seed)
    angle = rng.uniform(0, 2 * np.pi, count)
    angle = angle[(angle < 4.2) | (angle > 4.4)]
    radius = diameter_mm / 2 + 0.15 * np.cos(2 * angle + seed) + rng.normal(0, 0.03, len(angle))
    return StationResult(
        name=name,
        position_m=position_m,
        diameter_mm=diameter_mm,
        sigma_mm=0.02 + 0.004 * seed,
        min_mm=diameter_mm - 0.31,
        max_mm=diameter_mm + 0.29,
        coverage_deg=348.0,
        section_mm=np.stack([radius * np.cos(angle) + 0.2, radius * np.sin(angle) - 0.1], axis=1),
        circle_centre_mm=(0.2, -0.1),
        circle_radius_mm=diameter_mm / 2,
    )


def block(index):
    return BlockSummary(
        name=BLOCKS[index],
        images=24,
        calibrated=24,
        keypoints_per_image=2113.0 + 40 * index,
        reprojection_px=0.161 + 0.004 * index,
        focal_px=720.13,
        focal_sigma_px=0.0,
        principal_point_px=(480.0, 300.0),
        division_lambda=-0.02,
        lambda_radius=LambdaRadius.HALF_DIAGONAL,
        lambda_sigma=0.0,
        lens_method="given",
        coverage_m2=0.0534,
        resolution_mm=0.34,
        angle_deg=90.0 * index,
    )


def lens_effect(index, count=4000):
    """Corrected: the cylinder.  Uncorrected: one half as wide, bent by 6 mm towards the camera."""
    rng = np.random.default_rng(index)
    centre = np.radians(90.0 * index)
    azimuth, y = centre + rng.uniform(-1.05, 1.05, count), rng.uniform(0, LENGTH_M, count)

    def points(radius_mm, bow_mm, noise_mm):
        outward = np.stack([np.cos(azimuth), 0 * azimuth, -np.sin(azimuth)], axis=1)
        towards = np.array([np.cos(centre), 0, -np.sin(centre)])
        bend = bow_mm * (1 - (2 * y / LENGTH_M - 1) ** 2)
        along = np.stack([0 * y, 1000 * y, 0 * y], axis=1)
        push = (55.5 - radius_mm) * towards
        radii = radius_mm + rng.normal(0, noise_mm, count)
        return radii[:, None] * outward + bend[:, None] * towards + along + push

    return LensEffect(
        block=BLOCKS[index],
        diameter_uncorrected_mm=53.214,
        diameter_corrected_mm=111.063,
        residual_uncorrected_mm=4.812,
        residual_corrected_mm=0.093,
        bow_uncorrected_mm=6.02,
        bow_corrected_mm=0.11,
        points_uncorrected_mm=points(26.6, 6.0, 0.6),
        points_corrected_mm=points(55.5, 0.0, 0.09),
    )


def unrolled(height=230, width=174, name="", mm_per_px=2.0):
    return UnrolledPicture(
        image=surface_picture(height, width),
        mm_per_px=mm_per_px,
        theta_range_deg=(-60.0, 300.0),
        y_range_m=(0.0, LENGTH_M),
        name=name,
    )


def relief(rows=120, columns=90):
    """A rib that winds around once in 0.6 m, a bulge and a dent, with a patch that was not measured."""
    y = np.linspace(-0.01, 0.47, rows)[:, None]
    azimuth_deg = np.linspace(-178, 178, columns)[None, :]
    turned = np.mod(azimuth_deg - 30 - 600 * y + 180, 360) - 180
    height = 2.0 * np.clip(1 - (turned / 5) ** 2, 0, None)
    height += 1.5 * np.exp(-(((y - 0.145) / 0.01) ** 2) - ((azimuth_deg - 20) / 10) ** 2)
    height -= 1.0 * np.exp(-(((y - 0.325) / 0.01) ** 2) - ((azimuth_deg + 110) / 10) ** 2)
    height[40:50, 60:70] = np.nan
    return ReliefSummary(
        features=(
            ReliefFeature(
                kind="ridge",
                height_mm=1.97,
                sigma_mm=0.05,
                position_m=0.23,
                azimuth_deg=168.2,
                length_mm=480.0,
                width_mm=6.9,
                pitch_m=0.6,
            ),
            ReliefFeature(
                kind="bulge",
                height_mm=1.52,
                sigma_mm=0.03,
                position_m=0.145,
                azimuth_deg=20.1,
                length_mm=31.5,
                width_mm=32.0,
            ),
            ReliefFeature(
                kind="dent",
                height_mm=0.98,
                sigma_mm=0.02,
                position_m=0.325,
                azimuth_deg=-109.9,
                length_mm=29.0,
                width_mm=29.5,
            ),
        ),
        height_mm=height,
        theta_range_deg=(-180.0, 180.0),
        y_range_m=(-0.012, 0.472),
        level_mm=0.2,
    )


def axis(y):
    bend = np.sin(np.pi * y / LENGTH_M)
    return AxisSummary(
        straightness_mm_per_m=0.214,
        position_m=y,
        bow_mm=np.stack([0.06 * bend, -0.03 * bend], axis=1),
        centre_mm=np.stack([0.06 * bend + y, -0.03 * bend - 2 * y], axis=1),
    )


def mosaic():
    joints = (
        MosaicJoint(first=BLOCKS[i], second=BLOCKS[(i + 1) % 4], pairs=312 - i, residual_mm=0.081)
        for i in range(4)
    )
    return MosaicSummary(
        joints=tuple(joints),
        scale_corrections={name: 1.0 + 0.000213 * (i - 1) for i, name in enumerate(BLOCKS)},
        tie_points=1240,
    )


def report_data(**changes):
    """Everything a full run has; keywords replace fields."""
    positions = (0.1, 0.19, 0.28, 0.37)
    stations = tuple(
        station(name, position, TRUE_MM[name] + DIFFERENCES_MM[name], seed=seed)
        for seed, (name, position) in enumerate(zip(TRUE_MM, positions, strict=True))
    )
    y = np.linspace(0.02, 0.44, 85)
    fields = {
        "name": "stay-07",
        "length_m": LENGTH_M,
        "blocks": tuple(block(index) for index in range(4)),
        "stations": stations,
        "truth": tuple(
            TruthStation(name=name, position_m=position, diameter_mm=TRUE_MM[name])
            for name, position in zip(TRUE_MM, positions, strict=True)
        ),
        "lens_pictures": (
            LensPictures(
                block="Block1",
                grid=surface_picture(120, 192),
                before=surface_picture(120, 192, 1),
                after=surface_picture(120, 192, 2),
            ),
        ),
        "lens_effects": (lens_effect(2), lens_effect(3)),
        "unrolled": unrolled(),
        "block_unrolled": tuple(unrolled(230, 60, name) for name in BLOCKS),
        "profile": DiameterProfile(
            position_m=y,
            diameter_mm=np.interp(y, positions, [TRUE_MM[name] for name in TRUE_MM]) + 0.02 * np.sin(60 * y),
            sigma_mm=np.full(len(y), 0.035),
        ),
        "axis": axis(y),
        "mosaic": mosaic(),
        "relief": relief(),
        "mesh": cylinder_mesh(),
        "timing_s": {"frames": 8.1, "lens": 2.4, "match": 31.5, "adjust": 44.2, "dense": 61.0, "report": 3.9},
        "peak_memory_mb": 1834.0,
        "warnings": ("Block3: frame 17 is blurred and was left out.",),
    }
    return ReportData(**(fields | changes))
