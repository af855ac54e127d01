"""The cable's part of the specification: shape, defects and material.

Frozen records with defaults and units in the names; :mod:`synth.spec` holds the rest and the whole.
"""

from dataclasses import dataclass, field
from enum import StrEnum


class MaterialKind(StrEnum):
    """What the sheath of the cable is made of."""

    HDPE = "hdpe"
    PAINTED = "painted"


class DefectKind(StrEnum):
    """Which way a defect goes."""

    BULGE = "bulge"
    DENT = "dent"


@dataclass(frozen=True, kw_only=True)
class Station:
    """A place along the cable where the diameter is set and will be asked for.

    Attributes:
        name: unique name.
        position_m: along the axis from the first frame.
        diameter_mm: mean diameter there; None takes the cable's constant diameter (all stations or none).
    """

    name: str
    position_m: float
    diameter_mm: float | None = None


@dataclass(frozen=True, kw_only=True)
class Material:
    """What the surface looks like.  Strengths run from 0 (absent) to 1 (heavy).

    Attributes:
        kind: weathered polyethylene sheath or paint.
        grain: fine natural mottling of the material itself.
        dirt: blotches of soot and dust.
        streaks: marks of running water along the axis.
        scratches: thin scrapes from handling and stay ropes.
        speckle: small specks: lichen, splashes, dust grains.
        mottling: faint clouds, centimetres wide.
        gloss: 0 is a matt sheath with a soft sheen, 1 mirrors the lamps as glaring bands.
        speck_density: number of specks, relative to the usual 12 per square centimetre.
        drawn_out: everything but the scratches is this many times longer along the cable than around it.
        texel_mm: side of a texel of the painted-on texture.
    """

    kind: MaterialKind = MaterialKind.HDPE
    grain: float = 0.5
    dirt: float = 0.5
    streaks: float = 0.5
    scratches: float = 0.5
    speckle: float = 0.5
    mottling: float = 0.5
    gloss: float = 0.0
    speck_density: float = 1.0
    drawn_out: float = 1.0
    texel_mm: float = 0.2


@dataclass(frozen=True, kw_only=True)
class Fillet:
    """Two helical ribs, half a turn apart, that break up rain rivulets; right-handed about +y.

    Attributes:
        height_mm: rise of the crest over the sheath.
        width_mm: width of the cosine-squared rib, measured around the circumference.
        pitch_m: length of one turn along the axis.
        angle_deg: azimuth of the first rib at y = 0.
    """

    height_mm: float = 2.0
    width_mm: float = 8.0
    pitch_m: float = 0.6
    angle_deg: float = 30.0


@dataclass(frozen=True, kw_only=True)
class Defect:
    """One smooth bump or hollow: h (1 - s^2)^3 over the ellipse s < 1, twice continuously differentiable.

    Attributes:
        kind: bulge (outward) or dent (inward).
        height_mm: of the peak above, or of the bottom below the sheath; positive for both.
        position_m: of the centre, along the axis.
        azimuth_deg: of the centre.
        length_mm: the ellipse's diameter along the cable.
        width_mm: the ellipse's diameter around the girth, measured on the nominal radius.
    """

    kind: DefectKind
    height_mm: float
    position_m: float
    azimuth_deg: float
    length_mm: float = 40.0
    width_mm: float = 40.0


@dataclass(frozen=True, kw_only=True)
class Cable:
    """The body that is measured.

    Attributes:
        diameter_mm: constant mean diameter, used where no station sets one.
        station: stations in the order of position.
        ovality_mm: largest minus smallest diameter of the elliptic cross-section.
        ovality_angle_deg: azimuth of the largest diameter.
        margin_m: cable before the first and behind the last position of the robot.
        material: what it looks like.
        fillet: helical ribs, or None.
        defect: bulges and dents.
        bow_mm: rise of the axis' parabola half-way of the travel; it meets the y axis at both ends of the
            travel and goes on beyond.  The ring stays on the straight y axis.
        bow_azimuth_deg: direction of that rise.
    """

    diameter_mm: float = 110.0
    station: tuple[Station, ...] = ()
    ovality_mm: float = 0.0
    ovality_angle_deg: float = 0.0
    margin_m: float = 0.30
    material: Material = field(default_factory=Material)
    fillet: Fillet | None = None
    defect: tuple[Defect, ...] = ()
    bow_mm: float = 0.0
    bow_azimuth_deg: float = 90.0
