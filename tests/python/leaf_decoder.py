"""Decodes packed leaves; written from proto/README.md. Needs the standard library and libzstd."""

import ctypes
import struct
from typing import Dict, NamedTuple, Tuple

_MASK_BYTES = 64
_MAX_BODY_BYTES = _MASK_BYTES + 512 * 8
_MAX_STEPS = 511

# Rules 1 to 7 of the prediction: terms (factor, dx, dy, dz) for s(dx,dy,dz).
_RULES = (
    ((1, 1, 0, 0), (1, 0, 1, 0), (1, 0, 0, 1), (-1, 1, 1, 0), (-1, 1, 0, 1), (-1, 0, 1, 1))
    + ((1, 1, 1, 1),),
    ((1, 0, 0, 1), (1, 0, 1, 0), (-1, 0, 1, 1)),
    ((1, 0, 0, 1), (1, 1, 0, 0), (-1, 1, 0, 1)),
    ((2, 0, 0, 1), (-1, 0, 0, 2)),
    ((1, 0, 0, 1),),
    ((1, 0, 1, 0),),
    ((1, 1, 0, 0),),
)


class Voxel(NamedTuple):
    """An observed voxel; `color` is red, green, blue and the number of colour observations."""

    distance_m: float
    weight: float
    color: Tuple[int, int, int, int]


Leaf = Dict[int, Voxel]  # The observed voxels by offset.


def unpack(packed: bytes, truncation_m: float) -> Leaf:
    """The observed voxels of a leaf or of a patch. ValueError for damaged bytes."""
    if not packed:
        return {}
    if packed[0] & 0x0F != 2 or packed[0] & 0xC0:
        raise ValueError(f"unknown format 0x{packed[0]:02x}")
    body = _decompress(packed[1:]) if packed[0] & 0x20 else packed[1:]
    mask = int.from_bytes(body[:_MASK_BYTES], "little")
    offsets = [offset for offset in range(512) if mask >> offset & 1]
    count, channels = len(offsets), 4 if packed[0] & 0x10 else 0
    if count == 0 or len(body) != _MASK_BYTES + (4 + channels) * count:
        raise ValueError(f"{len(body)} bytes for {count} voxels")
    planes = [body[start : start + count] for start in range(_MASK_BYTES, len(body), count)]
    step_m = _to_float32(truncation_m / _MAX_STEPS)
    steps, weight, color, leaf = {}, 0, [0] * 4, {}
    for i, offset in enumerate(offsets):
        value = predict(steps, offset) + _from_zigzag(planes[0][i] | planes[1][i] << 8)
        steps[offset] = ((value + 0x8000) & 0xFFFF) - 0x8000
        weight = (weight + _from_zigzag(planes[2][i] | planes[3][i] << 8)) & 0xFFFF
        for channel in range(channels):
            color[channel] = (color[channel] + _from_zigzag(planes[4 + channel][i])) & 0xFF
        if abs(steps[offset]) > _MAX_STEPS or weight == 0:
            raise ValueError(f"voxel {offset} is out of range")
        leaf[offset] = Voxel(_to_float32(steps[offset] * step_m), weight / 256, tuple(color))
    return leaf


def predict(steps: Dict[int, int], offset: int) -> int:
    """The predicted distance of a voxel from those of lower offset, in steps."""
    place = (offset >> 6, offset >> 3 & 7, offset & 7)
    for rule in _RULES:
        terms = [(factor, offset - 64 * d[0] - 8 * d[1] - d[2]) for factor, *d in rule]
        is_inside = all(at >= below for _, *d in rule for at, below in zip(place, d))
        if is_inside and all(neighbour in steps for _, neighbour in terms):
            return sum(factor * steps[neighbour] for factor, neighbour in terms)
    return 0


def apply_patch(leaf: Leaf, patch: Leaf) -> Leaf:
    """The leaf with the voxels of the patch in place of its own. ValueError for no leaf."""
    if not leaf or not patch:
        raise ValueError("a patch has voxels and belongs to a leaf that exists")
    return {**leaf, **patch}


def _from_zigzag(residual: int) -> int:
    return (residual >> 1) ^ -(residual & 1)


def _to_float32(value: float) -> float:
    return struct.unpack("<f", struct.pack("<f", value))[0]


def _decompress(frame: bytes) -> bytes:
    function = ctypes.CDLL("libzstd.so.1").ZSTD_decompress
    function.restype = ctypes.c_size_t
    function.argtypes = [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_char_p, ctypes.c_size_t]
    body = ctypes.create_string_buffer(_MAX_BODY_BYTES)
    size = function(body, _MAX_BODY_BYTES, frame, len(frame))
    if size > _MAX_BODY_BYTES:  # An error code of zstd.
        raise ValueError("the body is not a zstd frame of at most 4160 bytes")
    return body.raw[:size]
