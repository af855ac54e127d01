"""truth.json of a scan: what really was, in the site frame, which is the base station's true frame.

Layout: see the module's functions; metres unless a key says mm.  East and north are the hall's x and y, which
the site frame sees turned (``north_deg``: azimuth of north, clockwise from +y, as in survey.toml).
"""

import dataclasses
import math
from typing import Any

import numpy as np

from pipeline.core.vocabulary import Array
from synth.scan.cable import read_cable, stand_cable
from synth.scan.flight import lens_of, shots
from synth.scan.frame import Column, Frame, Node
from synth.scan.layout import Layout
from synth.scan.lists import Sighting
from synth.scan.spec import ScanSpec
from synth.spec_reader import effective
from synth.surface import mean_diameter_mm

UP = np.array([0.0, 0.0, 1.0])


class Site:
    """The site frame: turns places and directions of the hall into it."""

    def __init__(self, layout: Layout) -> None:
        base = layout.stations[0]
        self._rotation, self._centre = base.rotation, base.centre

    def point(self, in_hall: Array) -> Array:
        """(..., 3) place in the site frame."""
        return np.asarray((in_hall - self._centre) @ self._rotation)

    def vector(self, in_hall: Array) -> Array:
        """(..., 3) direction in the site frame."""
        return np.asarray(in_hall @ self._rotation)

    def turn(self, hall_from_other: Array) -> Array:
        """site_from_other of a hall_from_other rotation."""
        return np.asarray(self._rotation.T @ hall_from_other)

    @property
    def north_deg(self) -> float:
        """Azimuth of the hall's +y, clockwise from the site's +y."""
        north = self.vector(np.array([0.0, 1.0, 0.0]))
        return math.degrees(math.atan2(north[0], north[1])) % 360.0


def truth_of(
    spec: ScanSpec, frame: Frame, layout: Layout, lists: tuple[tuple[Sighting, ...], ...]
) -> dict[str, Any]:
    """Everything that evaluation compares against, as plain JSON values."""
    site = Site(layout)
    return {
        "format": 1,
        "kind": "steel",
        "spec": dataclasses.asdict(spec),
        "north_deg": site.north_deg,
        "plumb": site.vector(UP).tolist(),
        "stations": [
            {
                "name": station.name,
                "rotation": site.turn(station.rotation).tolist(),
                "translation": site.point(station.centre).tolist(),
            }
            for station in layout.stations
        ],
        "targets": [
            {"name": target.name, "position_m": site.point(target.centre).tolist()}
            for target in layout.targets
        ],
        "rods": [
            {
                "name": rod.name,
                "start_m": site.point(rod.start).tolist(),
                "end_m": site.point(rod.end).tolist(),
                "radius_mm": 1000.0 * rod.radius_m,
                "nodes": list(rod.nodes),
            }
            for rod in frame.rods
        ],
        "nodes": [_node(node, frame, site) for node in frame.nodes],
        "columns": [_column(column, spec, site) for column in frame.columns],
        "deflection": [{"node": node.name, "sag_mm": 1000.0 * node.sag_m} for node in frame.nodes],
        "span_m": frame.span_m,
        "gross": _gross(spec, layout, lists, site),
        **_photos(spec, site),
        **_cable(spec, site),
    }


def _cable(spec: ScanSpec, site: Site) -> dict[str, Any]:
    """site_from_cable and what truth.json of the cable's own survey says of its stations."""
    shape = read_cable(spec)
    if shape is None:
        return {}
    rotation, origin = stand_cable(spec, shape)
    stations = [
        {
            "name": station.name,
            "position_m": station.position_m,
            "diameter_mm": mean_diameter_mm(shape.cable, station.position_m),
        }
        for station in shape.cable.station
    ]
    place = {"rotation": site.turn(rotation).tolist(), "translation": site.point(origin).tolist()}
    return {"cable": {**place, "stations": stations, "spec": effective(shape)}}


def _photos(spec: ScanSpec, site: Site) -> dict[str, Any]:
    if spec.photos is None:
        return {"photos": []}
    lens = lens_of(spec.photos)
    found = []
    for shot in shots(spec, spec.photos):
        rotation = site.turn(shot.rotation.T).T
        translation = -rotation @ site.point(shot.centre)
        found.append({"name": shot.name, "rotation": rotation.tolist(), "translation": translation.tolist()})
    return {
        "photos": found,
        "photo_lens": {
            "focal_px": lens.focal_px,
            "principal_point_px": list(lens.principal_point_px),
            "division_lambda": lens.division_lambda,
            "width_px": lens.width_px,
            "height_px": lens.height_px,
        },
    }


def _node(node: Node, frame: Frame, site: Site) -> dict[str, Any]:
    ball, rods = site.point(node.ball), site.point(node.rods)
    return {
        "name": node.name,
        "ball_m": ball.tolist(),
        "rods_m": rods.tolist(),
        "radius_mm": 1000.0 * frame.ball_radius_m,
        "eccentricity_mm": (1000.0 * site.vector(node.ball - node.rods)).tolist(),
    }


def _column(column: Column, spec: ScanSpec, site: Site) -> dict[str, Any]:
    """As judged between its bottom and top, against the true plumb line: the site's z is the base's."""
    bottom, top = site.point(column.bottom), site.point(column.top)
    north = math.radians(site.north_deg)
    up = site.vector(UP)
    across = top - bottom - (top - bottom)[2] / up[2] * up
    tilt_mm = 1000.0 * np.array(
        [
            across[0] * math.cos(north) - across[1] * math.sin(north),
            across[0] * math.sin(north) + across[1] * math.cos(north),
        ]
    )
    return {
        "name": column.name,
        "bottom_m": bottom.tolist(),
        "top_m": top.tolist(),
        "radius_mm": 1000.0 * column.radius_m,
        "tilt_mm": tilt_mm.tolist(),
        "height_m": float((top - bottom)[2]),
        "over_limit": bool(np.linalg.norm(tilt_mm) > spec.survey.column_limit_mm),
    }


def _gross(
    spec: ScanSpec, layout: Layout, lists: tuple[tuple[Sighting, ...], ...], site: Site
) -> list[dict[str, Any]]:
    places = {target.name: target.centre for target in layout.targets}
    found: list[dict[str, Any]] = []
    for moved in spec.gross.moved:
        first, by = layout.moves[moved.target]
        found.append(
            {
                "station": layout.stations[first].name,
                "target": moved.target,
                "kind": "moved",
                "by_mm": moved.by_mm,
                "moved_to_m": site.point(places[moved.target] + by).tolist(),
                "stations": [station.name for station in layout.stations[first:]],
            }
        )
    for station, sightings in zip(layout.stations, lists, strict=True):
        for sighting in sightings:
            if sighting.name != sighting.true:
                by_m = float(np.linalg.norm(places[sighting.name] - places[sighting.true]))
                found.append(
                    {
                        "station": station.name,
                        "target": sighting.true,
                        "kind": "misnamed",
                        "by_mm": 1000.0 * by_m,
                        "called": sighting.name,
                    }
                )
    return found
