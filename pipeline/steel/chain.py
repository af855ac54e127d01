"""One steel survey through the stages: builds on the stations' stages, asks for each stage's products.

What is made from what stands here and in :mod:`pipeline.steel.station_stages`; the order is in ``run.py``.
"""

from dataclasses import dataclass
from typing import Any

from pipeline.core.errors import StageError
from pipeline.core.events import Event, part
from pipeline.core.runfolder import Product
from pipeline.core.store import stamp_file
from pipeline.steel.columns import Column, measure_columns
from pipeline.steel.deflection import Deflection, measure_deflection
from pipeline.steel.fuse import fuse
from pipeline.steel.fuse_records import Fusion
from pipeline.steel.member_records import Members, NominalSizes, ball_features
from pipeline.steel.members import find_members
from pipeline.steel.nodes import Node, measure_nodes
from pipeline.steel.photo_model import PhotoModel, photo_model
from pipeline.steel.photo_sparse import pictures_in
from pipeline.steel.records import chosen_poses
from pipeline.steel.registration_records import Registration
from pipeline.steel.scan_cloud import scan_cloud
from pipeline.steel.station_stages import StationStages, told_as
from pipeline.steel.steel_run import SteelRun
from pipeline.steel.tile_records import Tiles
from pipeline.steel.tiles import build_tiles

UNLEVELLED = (
    "No station is levelled and there are no control targets: columns are judged against the base station's "
    "z, which may be off plumb; level the scanner and say scanner.levelled = true."
)


@dataclass(frozen=True, kw_only=True)
class Measured:
    """What was measured on the members, and what stood in the way of measuring more."""

    nodes: tuple[Node, ...]
    columns: tuple[Column, ...]
    deflection: Deflection | None
    cautions: tuple[str, ...]


class SteelChain(StationStages):
    """Runs stages by name and gathers what they found."""

    def run(self, name: str) -> None:
        """Make one stage's products; a stage that this survey gives nothing to work on makes none."""
        self.made[name] = getattr(self, f"_{name}")()
        self._close(Event(stage=name, done=1, total=1))

    def result(self) -> SteelRun:
        """Everything found, from the finished products."""
        measured = self._value("measure", Measured(nodes=(), columns=(), deflection=None, cautions=()))
        registered, compared = self._value("register"), self._value("compare")
        model: PhotoModel | None = self._value("photos")
        return SteelRun(
            survey=self._survey,
            options=self._options,
            features=registered.features,
            registration=registered.registration,
            chained=compared.chained,
            icp=compared.icp,
            tiles=self._value("tiles"),
            members=self._value("members"),
            nodes=measured.nodes,
            columns=measured.columns,
            deflection=measured.deflection,
            photos=None if model is None else model.photos,
            photo_cloud=None if model is None else model.cloud,
            fusion=self._value("fuse"),
            cautions=measured.cautions,
        )

    def _tiles(self) -> list[Product[Any]]:
        registration: Registration = self._value("register").registration
        if not self._scanned:
            return []
        poses = chosen_poses(registration.poses, [station.name for station in self._scanned])
        clouds = [product.value.path for product in self.made["clouds"]]
        stations = [(pose.name, path, pose) for pose, path in zip(poses, clouds, strict=True)]

        def make() -> Tiles:
            emit = told_as("tiles", self._emit)
            return build_tiles(stations, self._options.tiles, self._folder.path / "tiles", emit)

        needs = (*self.made["clouds"], *self.made["register"], self._options.tiles)
        return [self._folder.product("tiles", Tiles, make, *needs)]

    def _members(self) -> list[Product[Any]]:
        if not self.made["tiles"]:
            return []
        structure = self._survey.structure
        nominal = NominalSizes(
            rods_mm=structure.rod_diameters_mm,
            balls_mm=structure.ball_diameters_mm,
            columns_mm=structure.column_diameters_mm,
        )

        def make() -> Members:
            return find_members(self._value("tiles"), nominal, self._options.members, self._emit)

        needs = (*self.made["tiles"], nominal, self._options.members)
        return [self._folder.product("members", Members, make, *needs)]

    def _measure(self) -> list[Product[Any]]:
        if not self.made["members"]:
            return []
        survey, options = self._survey, self._options

        def make() -> Measured:
            members: Members = self._value("members")
            plumb = self._value("register").registration.plumb
            nodes = measure_nodes(members, options.nodes)
            columns = measure_columns(members, survey.columns, options.columns, plumb)
            deflection: Deflection | None = None
            cautions = (UNLEVELLED,) if columns and plumb is None and not survey.control else ()
            if survey.structure.span_m is not None:
                try:
                    span_m = survey.structure.span_m
                    deflection = measure_deflection(
                        nodes, columns, members, span_m, options.deflection, plumb
                    )
                except StageError as error:  # nodes and columns are worth having without it
                    cautions = (*cautions, str(error))
            return Measured(nodes=nodes, columns=columns, deflection=deflection, cautions=cautions)

        needs = (*self.made["members"], *self.made["register"], survey.columns, survey.structure.span_m)
        stages = (options.nodes, options.columns, options.deflection)
        return [self._folder.product("measure", Measured, make, *needs, *stages)]

    def _photos(self) -> list[Product[Any]]:
        photos, options = self._survey.photos, self._options.photos
        if photos is None:
            return []
        scratch = self._folder.path / "scratch"
        files = [(file.name, stamp_file(file)) for file in pictures_in(photos.source)]

        def make() -> PhotoModel:
            emit = told_as("photos", self._emit)
            return photo_model(photos.source, photos.focal_px, scratch, options, emit)

        return [self._folder.product("photos", PhotoModel, make, files, photos.focal_px, options)]

    def _fuse(self) -> list[Product[Any]]:
        """Photos into the site frame: by targets and ball nodes first, then by the surfaces."""
        if not self.made["photos"] or not self.made["tiles"]:
            return []

        def make() -> Fusion:
            emit = told_as("fuse", self._emit)
            read, fused = part(emit, 0.0, 0.2), part(emit, 0.2, 1.0)
            scan = scan_cloud(self._value("tiles"), read)
            spheres = (*self._value("register").registration.features, *ball_features(self._value("members")))
            return fuse(self._value("photos").cloud, scan, spheres, self._options.fuse, fused)

        needs = (*self.made["photos"], *self.made["tiles"], *self.made["members"], *self.made["register"])
        return [self._folder.product("fuse", Fusion, make, *needs, self._options.fuse)]
