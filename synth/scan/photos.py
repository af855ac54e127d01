"""The photos of a flight above the frame: traced one by one, developed, written.  Needs bpy.

Takes specification and world; writes P001.png and on, each proved to be traced through its lens by the
cable's tracer.
"""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, cast

import numpy as np

from pipeline.core.events import Emit, Event
from pipeline.core.vocabulary import Array
from synth.apart import keep_apart
from synth.files import write_png
from synth.scan.flight import lens_of, shots
from synth.scan.mesh import mesh_of
from synth.scan.primitives import World
from synth.scan.spec import Photos, ScanSpec
from synth.sensor import develop
from synth.spec import Sensor

if TYPE_CHECKING:
    from synth.material import LitMaterial

SENSOR_SEED = 242


class Daylight:
    """Stands where the cable's scene has the material that knows the robot's lamps: here there are none."""

    def place_lamps(self, positions: Array) -> None:
        """Do nothing: the sun stands still."""


def take_photos(spec: ScanSpec, photos: Photos, world: World, folder: Path, emit: Emit) -> None:
    """Render all photos that are not there yet.

    Args:
        spec, photos: what to take.
        world: in the hall's frame.
        folder: for the pictures; made if missing.
        emit: progress, one event a photo.

    Raises:
        StageError: a photo was not traced through its lens.
    """
    keep_apart()
    from synth.scan.photo_scene import build_photo_scene
    from synth.scene import Scene
    from synth.tracer import Moment, trace

    lens, flight = lens_of(photos), shots(spec, photos)
    scene, camera = build_photo_scene(mesh_of(world), world.names, lens)
    built = Scene(scene=scene, camera=camera, sheath=cast("LitMaterial", Daylight()))
    sensor = Sensor(read_noise_e=photos.read_noise_e)
    with TemporaryDirectory(prefix="cabletwin-photos-") as scratch:
        for number, shot in enumerate(flight):
            emit(Event(stage="photos", done=number, total=len(flight), block=shot.name))
            if (folder / shot.name).exists():
                continue
            moment = Moment(
                lens=lens,
                rotation=shot.rotation,
                translation=-shot.rotation @ shot.centre,
                lamps_in_world=np.zeros((0, 3)),
                seed=1000 * (spec.seed % 10**6) + number,
                samples=photos.samples,
                name=shot.name,
            )
            light, _ = trace(built, moment, Path(scratch))
            seed = (spec.seed, SENSOR_SEED, number)
            write_png(folder / shot.name, develop(light.astype(np.float64), lens, sensor, seed))
    emit(Event(stage="photos", done=len(flight), total=len(flight)))
