"""A video that OpenCV reads back: every frame, the right colours, little loss."""

import cv2
import numpy as np
import pytest

from synth.video import write_video


@pytest.fixture(scope="module")
def frames():
    rng = np.random.default_rng(4)
    wide = cv2.GaussianBlur(rng.uniform(0, 255, (96, 400, 3)).astype(np.float32), (0, 0), 2.0)
    wide = 128.0 + 6.0 * (wide - wide.mean())
    wide[..., 2] *= 0.8  # a warm tint: swapped channels or a wrong matrix would show
    wide = np.clip(wide, 10, 245).astype(np.uint8)
    return [np.ascontiguousarray(wide[:, 12 * k : 12 * k + 160]) for k in range(9)]


def read(path):
    capture = cv2.VideoCapture(str(path))
    pictures = []
    while (grabbed := capture.read())[0]:
        pictures.append(cv2.cvtColor(grabbed[1], cv2.COLOR_BGR2RGB))
    return pictures


def grey(picture):
    return picture.astype(float) @ [0.2126, 0.7152, 0.0722]


def test_every_frame_comes_back_in_order_and_close(frames, tmp_path):
    path = tmp_path / "block1.mp4"
    write_video(iter(frames), path, crf=12, frames_per_second=10)
    back = read(path)
    assert len(back) == 9
    for sent, got in zip(frames, back, strict=True):
        psnr = 10.0 * np.log10(255.0**2 / np.mean((grey(sent) - grey(got)) ** 2))
        assert 36.0 < psnr < 70.0
        assert np.abs((sent.astype(float) - got).mean(axis=(0, 1))).max() < 2.5
    assert [file.name for file in tmp_path.iterdir()] == ["block1.mp4"]


def test_a_lower_crf_keeps_more(frames, tmp_path):
    """In brightness: colour is stored at half the resolution whatever the quality."""
    loss = []
    for crf in (5, 35):
        write_video(iter(frames), tmp_path / f"{crf}.mp4", crf=crf, frames_per_second=10)
        back = read(tmp_path / f"{crf}.mp4")
        loss.append(np.mean([(grey(a) - grey(b)) ** 2 for a, b in zip(frames, back, strict=True)]))
    assert loss[0] < 0.3 * loss[1]


def test_a_failed_video_leaves_the_old_one(frames, tmp_path):
    path = tmp_path / "block1.mp4"
    path.write_bytes(b"old")

    def broken():
        yield frames[0]
        raise OSError("disk")

    with pytest.raises(OSError, match="disk"):
        write_video(broken(), path, crf=12, frames_per_second=10)
    assert path.read_bytes() == b"old"


def test_a_bit_rate_is_held(tmp_path):
    rng = np.random.default_rng(5)
    noise = [rng.integers(60, 200, (96, 160, 3)).astype(np.uint8) for _ in range(24)]  # wants far more
    bits = []
    for rate in (200_000, 400_000):
        write_video(iter(noise), tmp_path / "v.mp4", crf=5, frames_per_second=10, bits_per_second=rate)
        bits.append(8 * (tmp_path / "v.mp4").stat().st_size / 2.4)
    assert bits[0] == pytest.approx(200_000, rel=0.5)
    assert bits[1] / bits[0] == pytest.approx(2.0, rel=0.25)
