"""A made-up steel run with known figures: five stations in a row, a small grid, columns as in Table 1."""

import itertools
import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from pipeline.steel.columns import Column
from pipeline.steel.deflection import Deflection, Sag
from pipeline.steel.fuse_records import Direction, FusedPair, Fusion, Placement, Start
from pipeline.steel.member_records import Ball, Members, Rod, StationShare
from pipeline.steel.nodes import Node
from pipeline.steel.perpendiculars import CentreRule
from pipeline.steel.records import Feature, FeatureKind, StationPose
from pipeline.steel.registration_records import (
    ChainedRegistration,
    ChainLink,
    GrossError,
    GrossKind,
    IcpPair,
    IcpRegistration,
    Registration,
    Residual,
    VarianceComponent,
)
from pipeline.steel.steel_run import SteelRun
from pipeline.steel.survey_records import ScanStation, SteelSurvey, Structure, Targets

STATIONS = ("S01", "S02", "S03", "S04", "S05")
NORTH_DEG = 90.0  # north is +x, east is -y
UNKNOWN = np.full(3, np.nan)
NO_SHARE = StationShare(stations=np.zeros(0, dtype=np.int64), gains=np.zeros((0, 5, 7)))


def pose(number, moved_mm=0.0, sigma_mm=None):
    sigma = (0.4 if number else 0.0) if sigma_mm is None else sigma_mm
    covariance = np.diag([2.4e-5**2 * bool(sigma)] * 3 + [(sigma / 1000) ** 2] * 3)
    place = np.array([10.0 * number + moved_mm / 1000, 0.5 * (number % 2), 0.0])
    return StationPose(name=STATIONS[number], rotation=np.eye(3), translation=place, covariance=covariance)


def target(number):
    return Feature(
        kind=FeatureKind.POINT,
        name=f"T{number:02d}",
        place=np.array([5.0 * number, 4.0 * (-1) ** number, 1.5]),
        direction=np.zeros(3),
        frame=np.eye(3),
        covariance=np.diag([0.3, 0.4, 0.5]) ** 2 * 1e-6,
        radius_m=0.0725,
        points=900,
        rms_m=0.002,
    )


def residuals():
    """40 of exactly 1 mm in turn along x, y, z; and one gross error that was left out."""
    rows = []
    for n in range(40):
        offset = [0.0, 0.0, 0.0]
        offset[n % 3] = (-1.0) ** (n // 3)
        rows.append(_residual(STATIONS[n % 5], f"T{n // 5 + 1:02d}", offset, 1.0))
    return (*rows, _residual("S04", "T03", (50.0, 0.0, 0.0), 0.0))


def _residual(station, name, offset, weight):
    return Residual(
        station=station, target=name, kind="point", offset_mm=tuple(offset), turn_arcsec=0.0, normalised=1.0,
        redundancy=0.5, weight=weight,
    )  # fmt: skip


MOVED = GrossError(
    station="S04", target="T03", kind=GrossKind.MOVED, offset_mm=(30.0, 40.0, 0.0), size_mm=50.0,
    sigma_mm=1.1, fits="", together=("S04", "S05"), instead="",
)  # fmt: skip
MOVED_TOO = replace(MOVED, station="S05", size_mm=48.0)
MISNAMED = GrossError(
    station="S02", target="T05", kind=GrossKind.MISNAMED, offset_mm=(5000.0, 0.0, 0.0), size_mm=5000.0,
    sigma_mm=1.0, fits="T06", together=("S02",), instead="",
)  # fmt: skip


def registration(**changes):
    made = Registration(
        poses=tuple(pose(n) for n in range(5)),
        features=tuple(target(n) for n in range(1, 9)),
        seen_by=(2, 3, 4, 3, 3, 3, 2, 1),
        gross=(MOVED, MISNAMED, MOVED_TOO),
        components=(
            VarianceComponent(kind="point", factor=1.07, observations=41, redundancy=61.0),
            VarianceComponent(kind="plumb", factor=0.91, observations=5, redundancy=7.0),
        ),
        residuals=residuals(),
        order=STATIONS,
        parents=("", *STATIONS[:-1]),
        ring=(0, 1, 2, 3, 4),
        rounds=3,
        iterations=9,
        largest_step_mm=1e-6,
    )
    return replace(made, **changes)


def chained():
    """Chaining is off by 2 mm a set-up along x."""
    return ChainedRegistration(
        poses=tuple(pose(n, moved_mm=2.0 * n) for n in range(5)),
        links=tuple(
            ChainLink(
                station=name, position=n, offset_mm=2.0 * n, turn_arcsec=3.0 * n, chained_sigma_mm=1.7 * n,
                adjusted_sigma_mm=0.7 * bool(n),
            )
            for n, name in enumerate(STATIONS)
        ),
    )  # fmt: skip


def icp():
    """ICP is off by 5 mm a set-up along x."""
    pairs = tuple(
        IcpPair(
            first=a, second=b, offset_mm=5.0 + n, turn_arcsec=40.0, rms_mm=3.2, matched=0.71,
            converged=n != 2, rotation=np.eye(3), translation=np.zeros(3),
        )
        for n, (a, b) in enumerate(itertools.pairwise(STATIONS))
    )  # fmt: skip
    return IcpRegistration(pairs=pairs, poses=tuple(pose(n, 5.0 * n, sigma_mm=0.0) for n in range(5)))


def rod(name, start, end, radius_m):
    a, b = np.array(start, dtype=float), np.array(end, dtype=float)
    length = float(np.linalg.norm(b - a))
    covariance = np.diag([1e-7, 1e-7, 1e-8, 1e-8, 4e-8])
    return Rod(
        name=name, place=(a + b) / 2, direction=(b - a) / length, frame=np.eye(3), radius_m=radius_m,
        first_m=-length / 2, last_m=length / 2, noise_covariance=covariance, share=NO_SHARE,
        covariance=covariance, points=4000, rms_m=0.0021, arc_deg=200.0,
    )  # fmt: skip


CORNERS = [(x, y, 6.0) for x in (0.0, 3.0, 6.0) for y in (0.0, 3.0)]
"""Where the balls N001 to N006 are."""


def members():
    names = [f"N{n:03d}" for n in range(1, 7)]
    links = [(0, 1), (2, 3), (4, 5), (0, 2), (2, 4), (1, 3), (3, 5)]
    rods = tuple(rod(f"R{n:03d}", CORNERS[a], CORNERS[b], 0.03) for n, (a, b) in enumerate(links, 1))
    balls = tuple(
        Ball(
            name=name, centre=np.array(place), radius_m=0.1, noise_covariance=np.eye(4) * 9e-8,
            share=NO_SHARE, covariance=np.eye(4) * 9e-8, rods=(), column="", points=1500, rms_m=0.002,
        )
        for name, place in zip(names, CORNERS, strict=True)
    )  # fmt: skip
    columns = (rod("C01", (0, 0, 0), (0, 0, 5.8), 0.15), rod("C02", (6, 3, 0), (6, 3, 5.8), 0.15))
    stations = tuple(pose(n) for n in range(5))
    return Members(stations=stations, range_bias_m=0.0, rods=rods, columns=columns, balls=balls)


def node(number, eccentricity_mm, significant=False):
    ball, away = np.array(CORNERS[number - 1]), np.array(eccentricity_mm, dtype=float)
    return Node(
        name=f"N{number:03d}", ball_m=ball, diameter_mm=200.0,
        ball_covariance=np.eye(3) * 9e-8, ball_noise=np.eye(4) * 9e-8, ball_share=NO_SHARE,
        rods=("R001", "R004", "R005")[: 1 + number % 3], column="", rods_m=ball - away / 1000,
        rods_covariance=np.eye(3) * 9e-8, rods_noise=np.eye(3) * 9e-8, rods_share=NO_SHARE, axes_rms_mm=0.2,
        perpendicular_m=ball - away / 1000 + [0, 0, 0.0007],
        perpendicular_rule=CentreRule.SPHERE,
        eccentricity_mm=away, eccentricity_covariance=np.eye(3) * 0.09,
        amount_mm=float(np.linalg.norm(away)), sigma_mm=0.3 if np.isfinite(away).all() else math.nan,
        chi_square=1.0, critical=20.0, significant=significant,
    )  # fmt: skip


def nodes():
    """N001 is eccentric by 10 mm, N006 has one rod and none is known."""
    return (
        node(1, (6.0, 8.0, 0.0), significant=True),
        *(node(n, (0.2, 0.0, 0.1 * n)) for n in (2, 3, 4, 5)),
        node(6, UNKNOWN),
    )


def column(name, place, north_mm, east_mm, height_mm, sigma_mm=0.3):
    """With north along +x and east along -y."""
    bottom = np.array([*place, 0.5])
    deviation = math.hypot(north_mm, east_mm)
    top = bottom + np.array([north_mm, -east_mm, height_mm]) / 1000
    return Column(
        name=name, member="C01", bottom_m=bottom, top_m=top, height_mm=height_mm,
        tilt_mm=np.array([east_mm, north_mm]), tilt_covariance=np.eye(2) * sigma_mm**2,
        deviation_mm=deviation, sigma_mm=sigma_mm,
        azimuth_deg=math.degrees(math.atan2(east_mm, north_mm)) % 360, ratio=height_mm / deviation,
        ratios=np.array([east_mm, north_mm]), limit_mm=35.0, over=deviation > 35.0,
        over_probability=0.5 * math.erfc((35.0 - deviation) / sigma_mm / math.sqrt(2)),
        seen_m=(0.4, 14.6), hidden_mm=0.0, diameter_mm=300.0, rms_mm=2.0, points=9000,
    )  # fmt: skip


def columns():
    """8-N and 7-P of the paper, and one that is just within the limit."""
    return (
        column("8-N", (0.0, 0.0), 32.1, 17.3, 13_914.0),
        column("7-P", (6.0, 0.0), 37.3, -11.9, 14_069.0),
        column("6-Q", (6.0, 3.0), -34.8, 0.0, 14_000.0),
    )


def deflection():
    sags = (0.0, 0.1, 9.5, 8.0, -0.2, 0.1)
    rows = tuple(
        Sag(node=f"N{n:03d}", place_m=np.array(place), sag_mm=sag, sigma_mm=0.4, support=abs(sag) < 1)
        for n, (place, sag) in enumerate(zip(CORNERS, sags, strict=True), 1)
    )
    return Deflection(
        nodes=rows, supports=("N001", "N002", "N005", "N006"), span_m=6.0, limit_mm=24.0, worst="N003",
        worst_mm=9.5, worst_sigma_mm=0.4, ratio=631.6, over=False, over_probability=0.0,
    )  # fmt: skip


def fusion():
    return Fusion(
        placement=Placement(scale=1.25, rotation=np.eye(3), translation=np.array([1.0, 2.0, 3.0])),
        centre=np.zeros(3),
        covariance=np.diag([1e-8] * 6 + [4e-8]),
        start=Start.FEATURES,
        pairs=(
            FusedPair(
                name="sphere 1", photo=np.zeros(3), site=np.zeros(3), residual_mm=np.array([3.0, 4, 0])
            ),
        ),
        directions=(
            Direction(motion=np.zeros(7), sigma_mm=np.inf, held_by="", words="a turn about the axis"),
        ),
        places=np.zeros((4, 3)),
        residuals_mm=np.array([0.5, -0.5, 1.0, -1.0]),
        overlap=0.82,
        median_mm=1.44,
        noise_mm=1.9,
        patch_mm=50.0,
        notes=("Photos of the roof alone.",),
    )


def survey(**changes):
    made = SteelSurvey(
        format=1,
        kind="steel",
        name="hall-3",
        targets=Targets(radius_mm=72.5),
        stations=tuple(ScanStation(name=name, cloud=Path(f"/clouds/{name}.e57")) for name in STATIONS),
        structure=Structure(north_deg=NORTH_DEG, span_m=6.0),
    )
    return replace(made, **changes)


def run(**changes):
    made = SteelRun(
        survey=survey(),
        options=None,
        features=(),
        registration=registration(),
        chained=chained(),
        icp=icp(),
        members=members(),
        nodes=nodes(),
        columns=columns(),
        deflection=deflection(),
        cautions=("S05 hangs on two targets alone.",),
    )
    return replace(made, **changes)


def targets_only(**changes):
    """A survey of target lists: nothing but stations."""
    bare = {"icp": None, "members": None, "nodes": (), "columns": (), "deflection": None, "cautions": ()}
    return run(**bare | changes)
