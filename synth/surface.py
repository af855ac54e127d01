"""The true surface of the cable: its radius as a function of azimuth and position; pure, from the spec only.

Leaves out what the surface looks like (:mod:`synth.texture`) and how it is meshed (:mod:`synth.mesh`).
"""

import math

import numpy as np

from pipeline.core.vocabulary import Array
from synth.spec import Cable, Defect, DefectKind


def mean_radius_m(cable: Cable, y_m: Array) -> Array:
    """Radius averaged over the azimuth, without fillets.

    Between stations the fifth-degree smoothstep 6 s^5 - 15 s^4 + 10 s^3: first and second derivative vanish
    at the stations, so the profile is C2, and constant beyond the first and last one.

    Args:
        cable: the cable.
        y_m: positions along the axis, any shape, metres.

    Returns:
        Radii in metres, same shape.
    """
    y = np.asarray(y_m, dtype=np.float64)
    stations = [s for s in cable.station if s.diameter_mm is not None]
    if not stations:
        return np.full(y.shape, cable.diameter_mm / 2000.0)
    places = np.array([s.position_m for s in stations])
    radii = np.array([float(s.diameter_mm or 0.0) / 2000.0 for s in stations])
    if len(stations) == 1:
        return np.full(y.shape, radii[0])
    i = np.clip(np.searchsorted(places, y, side="right") - 1, 0, len(places) - 2)
    s = np.clip((y - places[i]) / (places[i + 1] - places[i]), 0.0, 1.0)
    return radii[i] + (radii[i + 1] - radii[i]) * s**3 * (10.0 + s * (6.0 * s - 15.0))


def radius_m(cable: Cable, azimuth_rad: Array, y_m: Array) -> Array:
    """Radius of the surface about the local axis, in the plane across y; see :func:`axis_m`.

    The ovality term (w / 4) cos 2(a - a0) makes the diameter 2 r swing by w between its largest and smallest
    value and leaves its mean alone.

    Args:
        cable: the cable.
        azimuth_rad, y_m: places, broadcast against each other; azimuth a is (cos a, 0, -sin a), seen from
            the local axis.

    Returns:
        Radii in metres, of the broadcast shape.
    """
    azimuth, y = np.broadcast_arrays(np.asarray(azimuth_rad, float), np.asarray(y_m, float))
    swing = np.cos(2.0 * (azimuth - math.radians(cable.ovality_angle_deg)))
    radius: Array = mean_radius_m(cable, y) + cable.ovality_mm / 4000.0 * swing
    if cable.fillet is not None:
        radius = radius + fillet_height_m(cable, azimuth, y)
    for defect in cable.defect:
        radius = radius + defect_height_m(cable, defect, azimuth, y)
    return radius


def fillet_height_m(cable: Cable, azimuth_rad: Array, y_m: Array) -> Array:
    """Height of the two helical ribs over the sheath: h cos^2(pi s / w) within |s| < w / 2, else 0.

    Args:
        cable: a cable with a fillet.
        azimuth_rad, y_m: places on the surface, same shape.

    Returns:
        Heights in metres; s is the arc to the nearer rib on the nominal radius.
    """
    fillet = cable.fillet
    if fillet is None:
        return np.zeros(np.shape(azimuth_rad))
    turned = azimuth_rad - math.radians(fillet.angle_deg) - 2.0 * math.pi * y_m / fillet.pitch_m
    to_rib = (
        turned + math.pi / 2.0
    ) % math.pi - math.pi / 2.0  # two ribs: the pattern repeats every half turn
    arc_over_width = to_rib * base_radius_m(cable) * 1000.0 / fillet.width_mm
    bump = np.cos(math.pi * np.clip(arc_over_width, -0.5, 0.5)) ** 2
    return np.asarray(fillet.height_mm / 1000.0 * bump, dtype=np.float64)


def defect_height_m(cable: Cable, defect: Defect, azimuth_rad: Array, y_m: Array) -> Array:
    """Height of one defect over the sheath: h (1 - s^2)^3 within the ellipse s < 1, negative for a dent.

    Args:
        cable: the cable it is on.
        defect: one of its defects.
        azimuth_rad, y_m: places on the surface, same shape.

    Returns:
        Heights in metres.
    """
    turned = azimuth_rad - math.radians(defect.azimuth_deg)
    arc_m = ((turned + math.pi) % (2.0 * math.pi) - math.pi) * base_radius_m(cable)
    along = (y_m - defect.position_m) / (defect.length_mm / 2000.0)
    around = arc_m / (defect.width_mm / 2000.0)
    rise_m = defect.height_mm / 1000.0 * (1.0 if defect.kind == DefectKind.BULGE else -1.0)
    return np.asarray(rise_m * np.clip(1.0 - along**2 - around**2, 0.0, None) ** 3, dtype=np.float64)


def axis_m(cable: Cable, travel_m: float, y_m: Array) -> tuple[Array, Array]:
    """The cable's axis: a parabola 4 b s (1 - s), s = y / travel, whose rise b points to the bow's azimuth.

    Args:
        cable: the cable.
        travel_m: length over which it bows by ``bow_mm``.
        y_m: positions along the straight y axis, any shape.

    Returns:
        x and z of the axis in metres, same shape.
    """
    s = np.asarray(y_m, float) / travel_m
    rise_m = cable.bow_mm / 1000.0 * 4.0 * s * (1.0 - s)
    azimuth = math.radians(cable.bow_azimuth_deg)
    return rise_m * math.cos(azimuth), -rise_m * math.sin(azimuth)


def base_radius_m(cable: Cable) -> float:
    """One nominal radius for the whole cable, which texture and fillet widths refer to."""
    given = [s.diameter_mm for s in cable.station if s.diameter_mm is not None]
    return float(np.mean(given)) / 2000.0 if given else cable.diameter_mm / 2000.0


def largest_radius_m(cable: Cable) -> float:
    """Largest radius anywhere on the cable."""
    diameters = [s.diameter_mm for s in cable.station if s.diameter_mm is not None] or [cable.diameter_mm]
    height_mm = cable.fillet.height_mm if cable.fillet is not None else 0.0
    height_mm += sum(d.height_mm for d in cable.defect if d.kind == DefectKind.BULGE)
    return max(diameters) / 2000.0 + cable.ovality_mm / 4000.0 + height_mm / 1000.0


def mean_diameter_mm(cable: Cable, y_m: float, steps: int = 3600) -> float:
    """Mean over the azimuth of 2 r at one position, fillets and defects included, in mm."""
    azimuth = np.arange(steps, dtype=np.float64) * (2.0 * math.pi / steps)
    return float(2000.0 * radius_m(cable, azimuth, np.full(steps, y_m, np.float64)).mean())
