"""The order of things: texture, scene, every frame of every block, videos, truth, survey.  Needs bpy.

Resumes: frames that an interrupted run left are kept as long as specification and renderer are the same.
What the survey claims is no part of the pictures: changed claims rewrite survey.toml and truth.json alone.
"""

import json
import math
import shutil
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from pipeline.core.errors import StageError
from pipeline.core.events import Emit, Event
from pipeline.core.vocabulary import Lens
from synth.files import read_png, write_depth, write_png, write_text
from synth.lens import block_lenses
from synth.motion import block_poses, ring_motion
from synth.scene import Scene, build_scene, lamps_in_ring
from synth.sensor import develop
from synth.shutter import Exposure, exposures
from synth.spec import Output, Spec
from synth.stamps import CLAIMS, PICTURES, WORK, claims_stamp, pictures_stamp
from synth.texture import encode, surface_texture
from synth.tracer import Moment, Picture, trace
from synth.truth import source_name, survey_toml, truth_of
from synth.video import write_video


def render_survey(spec: Spec, out: Path, emit: Emit) -> Path:
    """Render a whole survey.

    Args:
        spec: what to render.
        out: folder of the products; made if missing.
        emit: progress, one event a frame.

    Returns:
        The survey.toml, which is there only where the product is whole.

    Raises:
        StageError: the folder cannot be written, or a frame was not traced as specified.
        Cancelled: from ``emit``.
    """
    work = _open_folder(spec, out)
    survey, claims = out / "survey.toml", out / CLAIMS
    told = claims.exists() and claims.read_text() == claims_stamp(spec)
    if survey.exists():
        return survey if told else _tell(spec, out)
    job = _Job(spec=spec, work=work)
    total = len(spec.blocks) * spec.robot.frames
    for block in range(len(spec.blocks)):
        for frame in range(spec.robot.frames):
            _frame(job, out, block, frame)
            done = block * spec.robot.frames + frame + 1
            emit(Event(stage="render", done=done, total=total, block=spec.blocks[block]))
        _deliver(job, out, block)
    _tell(spec, out)
    shutil.rmtree(work / "frames", ignore_errors=True)
    return survey


def _tell(spec: Spec, out: Path) -> Path:
    """Write what was really there and what the survey claims; the stamp last, so that it stands for both."""
    write_text(out / "truth.json", json.dumps(truth_of(spec)))
    write_text(out / "survey.toml", survey_toml(spec))
    write_text(out / CLAIMS, claims_stamp(spec))
    return out / "survey.toml"


@dataclass(frozen=True, kw_only=True)
class _Job:
    """What all frames share, built only when the first frame asks for it."""

    spec: Spec
    work: Path

    @cached_property
    def scene(self) -> Scene:
        texture = self.work / "texture.png"
        painted = encode(surface_texture(self.spec.cable, self.spec.robot, self.spec.seed))
        write_png(texture, painted[::-1])  # Blender counts rows from the bottom
        return build_scene(self.spec, texture)

    @cached_property
    def lenses(self) -> tuple[Lens, ...]:
        return block_lenses(self.spec)


def _frame(job: _Job, out: Path, block: int, frame: int) -> None:
    """Render one frame, unless it is there."""
    spec = job.spec
    picture = _frame_file(job, out, block, frame)
    depth_file = out / "depth" / f"{spec.blocks[block].lower()}_{frame:04d}.exr"
    wants_depth = frame in spec.depth_frames
    if _delivered(job, out, block) or (picture.exists() and (not wants_depth or depth_file.exists())):
        return
    light, depth = _expose(job, block, frame, exposures(spec), 0)
    grey = develop(light.astype(np.float64), job.lenses[block], spec.sensor, (spec.seed, 51, block, frame))
    if wants_depth:
        if spec.sensor.motion_blur_mm > 0.0:
            depth = _expose(job, block, frame, exposures(spec, blurred=False), len(exposures(spec)))[1]
        write_depth(depth_file, depth)
    write_png(picture, grey)


def _expose(
    job: _Job, block: int, frame: int, parts: tuple[Exposure, ...], first: int
) -> tuple[Picture, Picture]:
    """Add up exposures, numbered from ``first``; the depth is theirs too if no two share a row."""
    lens = job.lenses[block]
    light = np.zeros((lens.height_px, lens.width_px, 3), np.float32)
    depth = np.zeros(light.shape[:2], np.float32)
    for index, part in enumerate(parts, start=first):
        its_light, its_depth = _trace(job, block, frame, part, index)
        light, depth = light + np.float32(part.weight) * its_light, depth + its_depth
    if not np.any(depth):
        name = f"{job.spec.blocks[block]} frame {frame}"
        raise StageError("render", f"{name} shows no cable", "check robot.standoff_m and the lens")
    return light, depth


def _trace(job: _Job, block: int, frame: int, part: Exposure, index: int) -> tuple[Picture, Picture]:
    spec = job.spec
    poses = block_poses(spec, part.shift)[block]
    run = 0 if spec.robot.synchronised else block
    moment = np.array([(frame + part.shift) / (spec.robot.frames - 1)])
    rotation, origin = ring_motion(spec, moment, run)
    seed = int(np.random.SeedSequence([spec.seed, 61, block, frame, index]).generate_state(1)[0] >> 1)
    return trace(
        job.scene,
        Moment(
            lens=job.lenses[block],
            rotation=poses.rotations[frame],
            translation=poses.translations[frame],
            lamps_in_world=lamps_in_ring(spec) @ rotation[0].T + origin[0],
            seed=seed,
            samples=math.ceil(spec.sensor.samples * part.weight),
            name=f"{spec.blocks[block]} frame {frame}",
            rows=part.rows,
        ),
        job.work,
    )


def _deliver(job: _Job, out: Path, block: int) -> None:
    """Encode a block's video; images are in their place already."""
    spec = job.spec
    if spec.sensor.output == Output.VIDEO and not _delivered(job, out, block):
        files = [_frame_file(job, out, block, frame) for frame in range(spec.robot.frames)]
        write_video(
            (read_png(file) for file in files),
            out / source_name(spec, block),
            crf=spec.sensor.video_crf,
            bits_per_second=round(1e6 * spec.sensor.video_mbit_per_s),
            frames_per_second=spec.sensor.frames_per_second,
        )


def _delivered(job: _Job, out: Path, block: int) -> bool:
    return job.spec.sensor.output == Output.VIDEO and (out / source_name(job.spec, block)).exists()


def _frame_file(job: _Job, out: Path, block: int, frame: int) -> Path:
    folder = out if job.spec.sensor.output == Output.IMAGES else job.work / "frames"
    return folder / job.spec.blocks[block].lower() / f"{frame:04d}.png"


def _open_folder(spec: Spec, out: Path) -> Path:
    """Make the folder and its stamp; clear what another specification left.

    Raises:
        StageError: it cannot be made or written, or holds what synth did not write.
    """
    work = out / WORK
    stamp, stamp_file = pictures_stamp(spec), out / PICTURES
    try:
        out.mkdir(parents=True, exist_ok=True)
        if stamp_file.exists() and stamp_file.read_text() != stamp:
            _clear(out)
        elif not stamp_file.exists() and (out / "survey.toml").exists():
            raise StageError(
                "render", f"{out} holds a survey that synth did not write", "name another folder"
            )
        work.mkdir(exist_ok=True)
        write_text(stamp_file, stamp)
    except OSError as error:
        raise StageError(
            "render", f"{out} cannot be written ({error})", "name a folder you may write"
        ) from error
    return work


def _clear(out: Path) -> None:
    """Remove the products of another specification, and nothing else."""
    for file in [
        out / "survey.toml",
        out / "truth.json",
        *out.glob("block*.mp4"),
        *out.glob("depth/block*.exr"),
    ]:
        file.unlink(missing_ok=True)
    for file in out.glob("block*/[0-9][0-9][0-9][0-9].png"):
        file.unlink()
    shutil.rmtree(out / WORK)
