"""Everything that a finished steel run found, as the report takes it."""

from dataclasses import dataclass

from pipeline.steel.columns import Column
from pipeline.steel.deflection import Deflection
from pipeline.steel.fuse_records import Fusion, PhotoCloud
from pipeline.steel.member_records import Members
from pipeline.steel.nodes import Node
from pipeline.steel.photo_records import OrientedPhotos
from pipeline.steel.records import StationFeatures
from pipeline.steel.registration_records import ChainedRegistration, IcpRegistration, Registration
from pipeline.steel.survey_records import SteelSurvey
from pipeline.steel.tile_records import Tiles


@dataclass(frozen=True, kw_only=True)
class SteelRun:
    """A finished run.

    Attributes:
        survey: as the user wrote it.
        options: the effective options of all stages, a frozen record.
        features: of each station, in its own frame.
        registration: all stations in the site frame.
        chained: the same station by station.
        icp: the same by pairwise ICP; None where clouds are not compared.
        tiles: the registered points; None where no station has a cloud.
        members: rods, columns and balls; None without tiles.
        nodes: eccentricities; empty without members.
        columns: inclinations; empty without members.
        deflection: of the grid; None where it is not judged.
        fusion: of photos and scans; None without photos.
        photos: the photos that were fused, in their own frame; None without.
        photo_cloud: their points, in the same frame; None without.
        cautions: sentences that the reader must know before trusting the figures.
    """

    survey: SteelSurvey
    options: object
    features: tuple[StationFeatures, ...]
    registration: Registration
    chained: ChainedRegistration
    icp: IcpRegistration | None = None
    tiles: Tiles | None = None
    members: Members | None = None
    nodes: tuple[Node, ...] = ()
    columns: tuple[Column, ...] = ()
    deflection: Deflection | None = None
    fusion: Fusion | None = None
    photos: OrientedPhotos | None = None
    photo_cloud: PhotoCloud | None = None
    cautions: tuple[str, ...] = ()
