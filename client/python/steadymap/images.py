"""Image encodings of the wire format."""

import struct
import warnings
import zlib
from typing import Any, Union

import numpy as np

from steadymap._generated.v1 import frame_pb2
from steadymap.choices import Choice

try:
    import zstandard
except ImportError:  # Required for PixelEncoding.ZSTD only.
    zstandard = None

_PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_JPEG_SIGNATURE = b"\xff\xd8\xff"
_NO_RETURN = 0
_MAX_DEPTH_UNITS = 65534  # 65535 also means no return.

# The fastest level of each: higher levels save a tenth of the bytes for several times the time.
_ZLIB_LEVEL = 1
_ZSTD_LEVEL = 1


class PixelEncoding(Choice):
    """Wire encoding of depth and label arrays. Encoded files are sent unchanged.

    ZSTD takes about a quarter of the bytes of RAW and is the fastest overall, since every byte also
    passes through the daemon's log; it requires the package zstandard. PNG takes the fewest bytes
    and the most time.
    """

    RAW = "raw"
    ZSTD = "zstd"
    PNG = "png"


class DepthSensor(Choice):
    """Principle by which a camera measures depth. It determines the noise that the map assumes."""

    UNSPECIFIED = "unspecified"
    STRUCTURED_LIGHT = "structured_light"
    STEREO = "stereo"
    TIME_OF_FLIGHT = "time_of_flight"
    LIDAR = "lidar"


def default_encoding() -> PixelEncoding:
    """Returns the fastest available encoding."""
    return PixelEncoding.RAW if zstandard is None else PixelEncoding.ZSTD


def check_image(value: Any, name: str, height_px: int, width_px: int, channels: int = 1) -> None:
    """Raises ValueError or TypeError unless the value is bytes, or the image `name` of a frame in
    this size."""
    if isinstance(value, bytes):
        return
    if not isinstance(value, np.ndarray):
        raise TypeError(f"{name}: expected a numpy array or the bytes of a file, got {type(value)}")
    expected = (height_px, width_px) if channels == 1 else (height_px, width_px, channels)
    if value.shape != expected:
        raise ValueError(
            f"{name}: expected shape {expected} (rows, columns) as the intrinsics say, "
            f"got {value.shape}"
        )
    _check_pixel_type(value.dtype, name)


def _check_pixel_type(dtype: Any, name: str) -> None:
    """Raises ValueError unless the pixels of the image `name` may be of this type."""
    if name == "depth":
        expected = "uint16 or floating point metres"
        is_valid = dtype.kind == "f" or (dtype.kind == "u" and dtype.itemsize == 2)
    elif name == "color":
        expected = "uint8"
        is_valid = dtype == np.uint8
    else:
        expected = "integers"
        is_valid = dtype.kind in "ui"
    if not is_valid:
        raise ValueError(f"{name}: expected {expected}, got {dtype}")


def depth_in_units(depth: np.ndarray, metres_per_unit: float) -> np.ndarray:
    """Converts depth, uint16 or floating point, to little-endian uint16.

    Floats are metres: values that are not finite, not above 0 or too large for 16 bits become 0,
    which means no return. Warns if all that are finite and above 0 are too large.
    """
    if depth.dtype.kind == "u":
        return np.ascontiguousarray(depth, dtype="<u2")
    units = depth * np.float32(1.0 / metres_per_unit) + np.float32(0.5)
    with np.errstate(invalid="ignore"):
        is_return = (units >= 1.0) & (units < _MAX_DEPTH_UNITS + 1.0)
        if not is_return.any():
            too_far = depth[np.isfinite(depth) & (units >= 1.0)]
            if too_far.size > 0:
                warnings.warn(
                    f"depth: floats are metres, at most {_MAX_DEPTH_UNITS * metres_per_unit:g} in "
                    f"units of {metres_per_unit:g} m; the least of this frame is {too_far.min():g}"
                )
    return np.where(is_return, units, _NO_RETURN).astype("<u2")


def labels_as_unsigned(labels: np.ndarray, name: str) -> np.ndarray:
    """Converts class or instance ids to uint8, or to little-endian uint16 if needed."""
    if labels.dtype == np.uint8:
        return np.ascontiguousarray(labels)
    low, high = int(labels.min()), int(labels.max())
    if low < 0 or high > 65535:
        raise ValueError(f"{name}: expected ids in [0, 65535], got {low} to {high}")
    return np.ascontiguousarray(labels, dtype=np.uint8 if high < 256 else "<u2")


def encode_depth(
    depth: Union[np.ndarray, bytes], metres_per_unit: float, encoding: PixelEncoding
) -> frame_pb2.DepthImage:
    """Encodes a depth image."""
    if isinstance(depth, bytes):
        require_png(depth, "depth")
        kind, data = frame_pb2.DEPTH_ENCODING_PNG_UINT16, depth
    else:
        units = depth_in_units(depth, metres_per_unit)
        if encoding is PixelEncoding.PNG:
            kind, data = frame_pb2.DEPTH_ENCODING_PNG_UINT16, encode_png(units)
        elif encoding is PixelEncoding.ZSTD:
            kind, data = frame_pb2.DEPTH_ENCODING_ZSTD_UINT16, compress_zstd(units)
        else:
            kind, data = frame_pb2.DEPTH_ENCODING_RAW_UINT16, units.tobytes()
    return frame_pb2.DepthImage(encoding=kind, metres_per_unit=metres_per_unit, data=data)


def encode_labels(
    labels: Union[np.ndarray, bytes], name: str, encoding: PixelEncoding
) -> frame_pb2.LabelImage:
    """Encodes a label or instance image."""
    if isinstance(labels, bytes):
        require_png(labels, name)
        return frame_pb2.LabelImage(encoding=frame_pb2.LABEL_ENCODING_PNG, data=labels)
    ids = labels_as_unsigned(labels, name)
    is_small = ids.dtype == np.uint8
    if encoding is PixelEncoding.PNG:
        kind, data = frame_pb2.LABEL_ENCODING_PNG, encode_png(ids)
    elif encoding is PixelEncoding.ZSTD:
        kind = (
            frame_pb2.LABEL_ENCODING_ZSTD_UINT8
            if is_small
            else frame_pb2.LABEL_ENCODING_ZSTD_UINT16
        )
        data = compress_zstd(ids)
    else:
        kind = (
            frame_pb2.LABEL_ENCODING_RAW_UINT8 if is_small else frame_pb2.LABEL_ENCODING_RAW_UINT16
        )
        data = ids.tobytes()
    return frame_pb2.LabelImage(encoding=kind, data=data)


def encode_color(color: Union[np.ndarray, bytes]) -> frame_pb2.ColorImage:
    """Encodes a colour image; an array becomes a PNG, as the wire format has no raw colour."""
    if not isinstance(color, bytes):
        color = encode_png(color)
    if color.startswith(_JPEG_SIGNATURE):
        kind = frame_pb2.COLOR_ENCODING_JPEG
    else:
        require_png(color, "color")
        kind = frame_pb2.COLOR_ENCODING_PNG
    return frame_pb2.ColorImage(encoding=kind, data=color)


def require_png(data: bytes, name: str) -> None:
    """Raises ValueError for bytes that are not a PNG file."""
    if not data.startswith(_PNG_SIGNATURE):
        raise ValueError(f"{name}: expected the bytes of a PNG file, got {data[:8]!r}...")


def compress_zstd(pixels: np.ndarray) -> bytes:
    """Returns a zstd frame of the raw pixels."""
    if zstandard is None:
        raise RuntimeError("PixelEncoding.ZSTD needs the Python package zstandard")
    return zstandard.ZstdCompressor(level=_ZSTD_LEVEL).compress(pixels.reshape(-1).view(np.uint8))


def encode_png(pixels: np.ndarray) -> bytes:
    """Returns a PNG file: (H, W) uint8 or uint16 as greyscale, (H, W, 3) uint8 as RGB."""
    height_px, width_px = pixels.shape[:2]
    bit_depth = 8 * pixels.dtype.itemsize
    color_type = 2 if pixels.ndim == 3 else 0
    rows = np.frombuffer(pixels.astype(pixels.dtype.newbyteorder(">")).tobytes(), np.uint8)
    rows = rows.reshape(height_px, -1)
    # Filter "up" for every row: each byte minus the byte above it.
    filtered = np.full((height_px, 1 + rows.shape[1]), 2, np.uint8)
    filtered[0, 1:] = rows[0]
    np.subtract(rows[1:], rows[:-1], out=filtered[1:, 1:])
    header = struct.pack(">IIBBBBB", width_px, height_px, bit_depth, color_type, 0, 0, 0)
    return (
        _PNG_SIGNATURE
        + _png_chunk(b"IHDR", header)
        + _png_chunk(b"IDAT", zlib.compress(filtered.tobytes(), _ZLIB_LEVEL))
        + _png_chunk(b"IEND", b"")
    )


def _png_chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
