"""Frames to one H.264 video: PyAV and libx264, BT.709, written under a temporary name and renamed."""

from collections.abc import Iterable
from pathlib import Path

import av
import numpy as np
from av.video.reformatter import ColorRange, Colorspace
from numpy.typing import NDArray

BT709 = 1  # the number of primaries, transfer and matrix in H.264's colour description


def write_video(
    frames: Iterable[NDArray[np.uint8]],
    path: Path,
    *,
    crf: float,
    frames_per_second: int,
    bits_per_second: int = 0,
) -> None:
    """Encode a video.

    Args:
        frames: (height, width, 3) uint8 pictures in red, green, blue, all of one even size.
        path: the .mp4 to write; replaced only when the new one is whole.
        crf: libx264's quality, 0 to 51; not used where a bit rate is given.
        frames_per_second: play-back speed.
        bits_per_second: mean and largest rate of the encoder, buffered over half a second; 0 is none.
    """
    temporary = path.with_name(path.stem + ".part" + path.suffix)
    with av.open(str(temporary), "w") as container:
        stream = container.add_stream("libx264", rate=frames_per_second)
        stream.pix_fmt = "yuv420p"
        stream.options = {"preset": "medium"} | _quality(crf, bits_per_second)
        context = stream.codec_context
        context.thread_count = 2
        context.color_range = ColorRange.MPEG
        context.colorspace = context.color_primaries = context.color_trc = BT709
        for picture in frames:
            if not context.is_open:
                stream.height, stream.width = picture.shape[:2]
            frame = av.VideoFrame.from_ndarray(picture, format="rgb24")
            coded = frame.reformat(
                format="yuv420p", dst_colorspace=Colorspace.ITU709, dst_color_range=ColorRange.MPEG
            )
            container.mux(stream.encode(coded))
        container.mux(stream.encode())
    temporary.replace(path)


def _quality(crf: float, bits_per_second: int) -> dict[str, str]:
    """Options of libx264: constant quality, or a rate held as a camera's encoder holds it."""
    if not bits_per_second:
        return {"crf": f"{crf:g}"}
    rate = str(bits_per_second)
    return {"b": rate, "maxrate": rate, "bufsize": str(bits_per_second // 2)}
