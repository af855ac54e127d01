"""How the stages of the stations hang together: what each is made from, so when it is made again.

Takes the survey, the options and the run folder; gives products, by station, and all stations registered.
Holds no algorithm and no order.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from pipeline.core.events import Emit, Event, part
from pipeline.core.parallel import side_by_side, workers_for
from pipeline.core.runfolder import Product, RunFolder
from pipeline.core.store import stamp_file
from pipeline.steel.chained import compare_chained
from pipeline.steel.clouds import StationCloud, import_cloud
from pipeline.steel.figure_register import register_with_figures
from pipeline.steel.icp import compare_icp
from pipeline.steel.naming import name_features
from pipeline.steel.options import SteelOptions
from pipeline.steel.records import StationFeatures
from pipeline.steel.registration_records import ChainedRegistration, IcpRegistration, Registration
from pipeline.steel.station_features import station_features
from pipeline.steel.survey_records import ScanStation, SteelSurvey

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


def told_as(stage: str, emit: Emit) -> Emit:
    """An ``emit`` for a step that tells of itself by another name than the stage it is part of."""
    return lambda event: emit(replace(event, stage=stage))


def _unclosed(emit: Emit, event: Event) -> None:
    """Pass an event on; that a stage is at its end only the chain can tell."""
    emit(replace(event, total=event.done + 1) if event.done >= event.total and not event.block else event)


class StationStages:
    """The products so far; ``made["targets"][2]`` is the third station's."""

    def __init__(self, survey: SteelSurvey, options: SteelOptions, folder: RunFolder, emit: Emit) -> None:
        self._survey, self._options, self._folder = survey, options, folder
        self._close, self._emit = emit, partial(_unclosed, emit)
        self._scanned = tuple(s for s in survey.stations if s.cloud is not None)
        self.made: dict[str, list[Product[Any]]] = {}

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
        survey, options = self._survey, self._options.targets

        def found(station: ScanStation, emit: Emit) -> Product[StationFeatures]:
            cloud = self._cloud_of(station)

            def make() -> StationFeatures:
                points = None if cloud is None else cloud.value
                return station_features(station, points, survey, options, self._folder.path, emit)

            table = None if station.targets is None else stamp_file(station.targets)
            names = () if station.names is None else (stamp_file(station.names),)
            needs = (table, cloud, survey.scanner, survey.targets, survey.structure, options, *names)
            return self._folder.product("targets", StationFeatures, make, *needs, block=station.name)

        return self._station_by_station("targets", found, survey.stations)

    def _register(self) -> list[Product[Any]]:
        survey, options = self._survey, self._options

        def make() -> Registered:
            found = [p.value for p in self.made["targets"]]
            told = told_as("register", part(self._emit, 0.0, 0.3))
            named = name_features(found, survey.base.name, survey.scanner.levelled, options.targets, told)
            features, registration = register_with_figures(
                survey, named, options.register, part(self._emit, 0.3, 1.0)
            )
            return Registered(features=tuple(features), registration=registration)

        needs = (*self.made["targets"], survey.scanner, survey.control, survey.base.name)
        return [self._folder.product("register", Registered, make, *needs, options.targets, options.register)]

    def _compare(self) -> list[Product[Any]]:
        registered: Registered = self._value("register")
        clouds = {p.value.station: p.value.path for p in self.made["clouds"]}
        icp = self._options.icp

        def make() -> Comparison:
            first, second = (told_as("compare", part(self._emit, *span)) for span in ((0.0, 0.2), (0.2, 1.0)))
            chained = compare_chained(self._survey, registered.features, registered.registration, first)
            pairs = compare_icp(registered.registration, clouds, icp, second) if len(clouds) > 1 else None
            return Comparison(chained=chained, icp=pairs)

        needs = (*self.made["register"], *self.made["clouds"], self._survey.scanner, icp)
        return [self._folder.product("compare", Comparison, make, *needs)]
