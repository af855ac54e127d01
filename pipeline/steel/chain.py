"""How the steel stages hang together: what each is made from, so when it is made again.

Takes the survey, the options and the run folder; gives products.  Holds no algorithm; the order is in
``run.py``.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event, part
from pipeline.core.parallel import side_by_side, workers_for
from pipeline.core.runfolder import Product, RunFolder
from pipeline.core.store import stamp_file
from pipeline.steel.chained import compare_chained
from pipeline.steel.clouds import StationCloud, import_cloud, station_points
from pipeline.steel.columns import Column, measure_columns
from pipeline.steel.deflection import Deflection, measure_deflection
from pipeline.steel.fuse import fuse
from pipeline.steel.fuse_records import Fusion
from pipeline.steel.icp import compare_icp
from pipeline.steel.member_records import Members, NominalSizes, ball_features
from pipeline.steel.members import find_members
from pipeline.steel.naming import name_features
from pipeline.steel.nodes import Node, measure_nodes
from pipeline.steel.options import SteelOptions
from pipeline.steel.photo_model import PhotoModel, photo_model
from pipeline.steel.photo_sparse import pictures_in
from pipeline.steel.records import StationFeatures, chosen_poses
from pipeline.steel.register import register
from pipeline.steel.registration_records import ChainedRegistration, IcpRegistration, Registration
from pipeline.steel.scan_cloud import scan_cloud
from pipeline.steel.steel_run import SteelRun
from pipeline.steel.survey_records import ScanStation, SteelSurvey
from pipeline.steel.target_table import read_target_table
from pipeline.steel.targets import find_targets
from pipeline.steel.tile_records import Tiles
from pipeline.steel.tiles import build_tiles

type _PerStation = Callable[[ScanStation, Emit], Product[Any]]


@dataclass(frozen=True, kw_only=True)
class Registered:
    """The stations' features with their names, and all stations in the site frame."""

    features: tuple[StationFeatures, ...]
    registration: Registration


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Other ways to register the same stations; ``icp`` is None where fewer than two have clouds."""

    chained: ChainedRegistration
    icp: IcpRegistration | None


@dataclass(frozen=True, kw_only=True)
class Measured:
    """What was measured on the members, and what stood in the way of measuring more."""

    nodes: tuple[Node, ...]
    columns: tuple[Column, ...]
    deflection: Deflection | None
    cautions: tuple[str, ...]


def _named(stage: str, emit: Emit) -> Emit:
    """An ``emit`` for a step that tells of itself by another name than the stage it is part of."""
    return lambda event: emit(replace(event, stage=stage))


def _unclosed(emit: Emit, event: Event) -> None:
    """Pass an event on; that a stage is at its end only the chain can tell."""
    emit(replace(event, total=event.done + 1) if event.done >= event.total and not event.block else event)


class SteelChain:
    """The products so far; ``made["targets"][2]`` is the third station's."""

    def __init__(self, survey: SteelSurvey, options: SteelOptions, folder: RunFolder, emit: Emit) -> None:
        self._survey, self._options, self._folder = survey, options, folder
        self._close, self._emit = emit, partial(_unclosed, emit)
        self._scanned = tuple(s for s in survey.stations if s.cloud is not None)
        self.made: dict[str, list[Product[Any]]] = {}

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

    def _value(self, stage: str, otherwise: Any = None) -> Any:  # noqa: ANN401 - products of every kind
        return self.made[stage][0].value if self.made[stage] else otherwise

    def _station_by_station(
        self, stage: str, make: _PerStation, stations: tuple[ScanStation, ...]
    ) -> list[Product[Any]]:
        jobs = [partial(make, station) for station in stations]
        with self._folder.side_by_side(stage):
            return side_by_side(jobs, self._emit, workers_for(len(jobs)))

    def _clouds(self) -> list[Product[Any]]:
        def imported(station: ScanStation, emit: Emit) -> Product[StationCloud]:
            out = self._folder.path / "stations"
            source = None if station.cloud is None else stamp_file(station.cloud)
            return self._folder.product(
                "clouds",
                StationCloud,
                lambda: import_cloud(station, out, emit),
                source,
                station.unit,
                block=station.name,
            )

        return self._station_by_station("clouds", imported, self._scanned)

    def _cloud_of(self, station: ScanStation) -> Product[StationCloud] | None:
        return next((p for p in self.made["clouds"] if p.value.station == station.name), None)

    def _targets(self) -> list[Product[Any]]:
        """Targets named by hand where a table is given, else those found in the cloud."""
        survey = self._survey

        def found(station: ScanStation, emit: Emit) -> Product[StationFeatures]:
            table, cloud = station.targets, self._cloud_of(station)

            def make() -> StationFeatures:
                if table is not None:
                    return read_target_table(table, station.name, survey.scanner)
                if cloud is None:
                    raise StageError(
                        "targets",
                        f"the station {station.name} has neither cloud nor targets",
                        "give station.cloud or station.targets in the survey",
                    )
                points = station_points(cloud.value.path)
                return find_targets(points, station.name, survey, self._options.targets, emit)

            source = None if table is None else stamp_file(table)
            needs = (source, cloud, survey.scanner, survey.targets, survey.structure, self._options.targets)
            return self._folder.product("targets", StationFeatures, make, *needs, block=station.name)

        return self._station_by_station("targets", found, survey.stations)

    def _register(self) -> list[Product[Any]]:
        survey, options = self._survey, self._options

        def make() -> Registered:
            found = [p.value for p in self.made["targets"]]
            told = _named("register", part(self._emit, 0.0, 0.3))
            named = name_features(found, survey.base.name, survey.scanner.levelled, options.targets, told)
            registration = register(survey, named, options.register, part(self._emit, 0.3, 1.0))
            return Registered(features=tuple(named), registration=registration)

        needs = (*self.made["targets"], survey.scanner, survey.control, survey.base.name)
        return [self._folder.product("register", Registered, make, *needs, options.targets, options.register)]

    def _compare(self) -> list[Product[Any]]:
        registered: Registered = self._value("register")
        clouds = {p.value.station: p.value.path for p in self.made["clouds"]}
        icp = self._options.icp

        def make() -> Comparison:
            first, second = (_named("compare", part(self._emit, *span)) for span in ((0.0, 0.2), (0.2, 1.0)))
            chained = compare_chained(self._survey, registered.features, registered.registration, first)
            pairs = compare_icp(registered.registration, clouds, icp, second) if len(clouds) > 1 else None
            return Comparison(chained=chained, icp=pairs)

        needs = (*self.made["register"], *self.made["clouds"], self._survey.scanner, icp)
        return [self._folder.product("compare", Comparison, make, *needs)]

    def _tiles(self) -> list[Product[Any]]:
        registration: Registration = self._value("register").registration
        if not self._scanned:
            return []
        poses = chosen_poses(registration.poses, [station.name for station in self._scanned])
        clouds = [product.value.path for product in self.made["clouds"]]
        stations = [(pose.name, path, pose) for pose, path in zip(poses, clouds, strict=True)]

        def make() -> Tiles:
            emit = _named("tiles", self._emit)
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
            nodes = measure_nodes(members, options.nodes)
            columns = measure_columns(members, survey.columns, options.columns)
            deflection: Deflection | None = None
            cautions: tuple[str, ...] = ()
            if survey.structure.span_m is not None:
                try:
                    span_m = survey.structure.span_m
                    deflection = measure_deflection(nodes, columns, span_m, options.deflection)
                except StageError as error:  # nodes and columns are worth having without it
                    cautions = (str(error),)
            return Measured(nodes=nodes, columns=columns, deflection=deflection, cautions=cautions)

        needs = (*self.made["members"], survey.columns, survey.structure.span_m)
        stages = (options.nodes, options.columns, options.deflection)
        return [self._folder.product("measure", Measured, make, *needs, *stages)]

    def _photos(self) -> list[Product[Any]]:
        photos, options = self._survey.photos, self._options.photos
        if photos is None:
            return []
        scratch = self._folder.path / "scratch"
        files = [(file.name, stamp_file(file)) for file in pictures_in(photos.source)]

        def make() -> PhotoModel:
            emit = _named("photos", self._emit)
            return photo_model(photos.source, photos.focal_px, scratch, options, emit)

        return [self._folder.product("photos", PhotoModel, make, files, photos.focal_px, options)]

    def _fuse(self) -> list[Product[Any]]:
        """Photos into the site frame: by targets and ball nodes first, then by the surfaces."""
        if not self.made["photos"] or not self.made["tiles"]:
            return []

        def make() -> Fusion:
            emit = _named("fuse", self._emit)
            read, fused = part(emit, 0.0, 0.2), part(emit, 0.2, 1.0)
            scan = scan_cloud(self._value("tiles"), read)
            spheres = (*self._value("register").registration.features, *ball_features(self._value("members")))
            return fuse(self._value("photos").cloud, scan, spheres, self._options.fuse, fused)

        needs = (*self.made["photos"], *self.made["tiles"], *self.made["members"], *self.made["register"])
        return [self._folder.product("fuse", Fusion, make, *needs, self._options.fuse)]
