"""What belongs together: balls with the rods that end in them, and joints whose ball was not seen.

Takes fitted spheres, rods and columns; gives named balls and joints.  Leaves out the fits.
"""

from dataclasses import replace

import numpy as np

from pipeline.steel.fitting import Fitted
from pipeline.steel.meeting import meeting_places
from pipeline.steel.member_records import Ball, Joint, Rod
from pipeline.steel.rods import ends_at
from pipeline.steel.segments import Pieces


def balls_with_rods(
    spheres: list[Fitted], rods: tuple[Rod, ...], columns: tuple[Rod, ...]
) -> tuple[Ball, ...]:
    """Balls with their rods; a ball needs two members, or it is something else."""
    centres, radii = (
        np.array([b.place for b in spheres]).reshape(-1, 3),
        np.array([b.radius_m for b in spheres]),
    )
    at_rods = np.array([ends_at(r, centres, radii) for r in rods]).reshape(len(rods), len(spheres))
    at_columns = np.array([ends_at(c, centres, radii, 0.3) for c in columns]).reshape(
        len(columns), len(spheres)
    )
    balls = []
    for k, sphere in enumerate(spheres):
        names = tuple(r.name for r, at in zip(rods, at_rods[:, k], strict=True) if at)
        below = [c.name for c, at in zip(columns, at_columns[:, k], strict=True) if at]
        if len(names) + len(below) < 2:
            continue
        balls.append(
            Ball(
                name="",
                centre=sphere.place,
                radius_m=sphere.radius_m,
                noise_covariance=sphere.noise_covariance,
                share=sphere.share,
                covariance=sphere.covariance,
                rods=names,
                column=below[0] if below else "",
                points=len(sphere.used),
                rms_m=sphere.rms_m,
            )
        )
    balls.sort(key=lambda b: tuple(np.round(b.centre[::-1], 1).tolist()))
    digits = max(len(str(len(balls))), 2)
    return tuple(replace(b, name=f"N{k + 1:0{digits}d}") for k, b in enumerate(balls))


def joints_without_balls(
    rods: tuple[Rod, ...], columns: tuple[Rod, ...], balls: tuple[Ball, ...]
) -> tuple[Joint, ...]:
    """The places where three or more rods meet without a ball that was seen."""
    pieces = Pieces(
        starts=np.array([r.start for r in rods]).reshape(-1, 3),
        ends=np.array([r.end for r in rods]).reshape(-1, 3),
        radii_m=np.array([r.radius_m for r in rods]),
        seeds=np.ones(len(rods)),
    )
    found = []
    for place in sorted(meeting_places(pieces), key=lambda p: tuple(np.round(p[::-1], 1).tolist())):
        if any(np.linalg.norm(ball.centre - place) < 0.25 for ball in balls):
            continue
        here, small = place[None], np.array([0.1])
        names = tuple(r.name for r in rods if ends_at(r, here, small).any())
        below = [c.name for c in columns if ends_at(c, here, small, 0.3).any()]
        if len(names) >= 3:
            found.append((place, names, below[0] if below else ""))
    return tuple(
        Joint(name=f"J{k + 1:02d}", place=place, rods=names, column=column)
        for k, (place, names, column) in enumerate(found)
    )
