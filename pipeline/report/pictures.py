"""Encoding pictures: reduced to what a viewer or a page can bear, as JPEG bytes, as data addresses."""

import base64
import io

from PIL import Image

from pipeline.report.types import Picture

# Beyond this side a JPEG cannot be written at all (the format stores 16 bits).
_JPEG_LIMIT_PX = 65_500


def reduced(picture: Picture, max_side_px: int, max_pixels: int | None = None) -> Image.Image:
    """The picture as a Pillow image, made smaller (never larger) until it keeps both limits."""
    image = Image.fromarray(picture)
    factor = min(1.0, max_side_px / max(image.size))
    if max_pixels is not None:
        factor = min(factor, (max_pixels / (image.width * image.height)) ** 0.5)
    if factor < 1.0:
        size = (max(1, int(image.width * factor)), max(1, int(image.height * factor)))
        image = image.resize(size, Image.Resampling.LANCZOS)
    return image


def jpeg_bytes(image: Image.Image, quality: int = 88) -> bytes:
    """JPEG file of an image, full colour resolution from quality 90 on."""
    if max(image.size) > _JPEG_LIMIT_PX:
        image = image.copy()
        image.thumbnail((_JPEG_LIMIT_PX, _JPEG_LIMIT_PX))
    stream = io.BytesIO()
    image.save(stream, "JPEG", quality=quality, subsampling=0 if quality >= 90 else 2, optimize=True)
    return stream.getvalue()


def data_address(payload: bytes, media_type: str) -> str:
    """The payload as a ``data:`` address, which a page carries in itself."""
    return f"data:{media_type};base64,{base64.b64encode(payload).decode('ascii')}"
