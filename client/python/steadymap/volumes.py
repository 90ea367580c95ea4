"""The volumes of a map: leaves of 8 x 8 x 8 voxels in the format of core/volume/tsdf_codec.h."""

import dataclasses
from typing import Any, Iterable, List, Optional, Sequence, Tuple

import numpy as np

from steadymap._generated.v1 import volume_pb2
from steadymap.errors import DataLossError
from steadymap.geometry import read_only
from steadymap.objects import Object, object_from_proto

try:
    import zstandard
except ImportError:  # Required to unpack leaves only.
    zstandard = None

_SIDE = 8
_VOXELS = _SIDE**3
_MASK_BYTES = _VOXELS // 8
_VERSION = 2
_COLOR_FLAG = 0x10
_ZSTD_FLAG = 0x20
_GEOMETRY_BYTES = 4  # Per observed voxel; twice as many with colour.
_MAX_BODY_BYTES = _MASK_BYTES + _VOXELS * 2 * _GEOMETRY_BYTES
_MAX_DISTANCE_STEPS = 511  # Steps of the truncation distance.
_WEIGHT_UNIT = 1.0 / 256.0


@dataclasses.dataclass(frozen=True, eq=False)
class Leaf:
    """8 x 8 x 8 voxels of a volume.

    Attributes:
        object_id: Owner of the volume; 0 is the background, with the world frame as its grid frame.
        origin: int32 (3,), index of the lowest voxel in the volume's grid frame, multiples of 8.
            Voxel (i, j, k) has its centre at (i, j, k) times the voxel size.
        packed: The voxels, for `unpack_leaves`; empty: the leaf was removed.
        is_patch: True if `packed` contains only the changed voxels of a known leaf; the others keep
            their values. Only in a watch with `takes_patches`.
    """

    object_id: int
    origin: np.ndarray
    packed: bytes
    is_patch: bool = False


@dataclasses.dataclass(frozen=True, eq=False)
class LeafVoxels:
    """The voxels of L leaves; axes 1 to 3 are x, y and z of the grid frame.

    Attributes:
        observed: bool (L, 8, 8, 8).
        distance_m: float32 (L, 8, 8, 8), metres, positive in front of the surface; NaN if not
            observed.
        weight: float32 (L, 8, 8, 8), evidence: 1 is one observation from 1 m; 0 if not observed.
        colors: uint8 (L, 8, 8, 8, 3), sRGB; zeros without colour.
    """

    observed: np.ndarray
    distance_m: np.ndarray
    weight: np.ndarray
    colors: np.ndarray


@dataclasses.dataclass(frozen=True, eq=False)
class Section:
    """The volumes of a part of a map.

    Attributes:
        revision: Revision of the map.
        voxel_size_m, truncation_m: Scale of the map, metres.
        objects: Owners of the leaves; `T_world_object` is the pose of their grid frame.
        leaves: Leaves of background and objects.
    """

    revision: int
    voxel_size_m: float
    truncation_m: float
    objects: Tuple[Object, ...]
    leaves: Tuple[Leaf, ...]


def leaf_from_proto(entry: volume_pb2.PackedLeaf) -> Leaf:
    """Converts a leaf from the service."""
    origin = np.array((entry.origin_x, entry.origin_y, entry.origin_z), np.int32)
    return Leaf(entry.object_id, read_only(origin), entry.packed, entry.is_patch)


def take_section(messages: Iterable[Any]) -> Section:
    """Reads a GetMapSection stream to its end."""
    header, objects, leaves = None, [], []
    for message in messages:
        kind = message.WhichOneof("kind")
        if kind == "header":
            header = message.header
        elif kind == "objects":
            objects.extend(object_from_proto(entry) for entry in message.objects.objects)
        elif kind == "leaves":
            leaves.extend(leaf_from_proto(entry) for entry in message.leaves.leaves)
    if header is None:
        raise DataLossError("the server sent a section without its header")
    size_m, truncation_m = header.voxel_size_m, header.truncation_m
    return Section(header.revision, size_m, truncation_m, tuple(objects), tuple(leaves))


def unpack_leaves(leaves: Sequence[Leaf], truncation_m: float) -> LeafVoxels:
    """Unpacks leaves of a map with this truncation distance, metres.

    Takes about 0.1 s per call and some microseconds per leaf: unpack many leaves at once. Requires
    the package zstandard. DataLossError for a damaged leaf.
    """
    bodies = [_body_of(leaf.packed) for leaf in leaves]
    masks = b"".join(body[:_MASK_BYTES] or bytes(_MASK_BYTES) for body, _ in bodies)
    bits = np.unpackbits(np.frombuffer(masks, np.uint8), bitorder="little")
    observed = bits.reshape(-1, _VOXELS).astype(bool)
    planes = _planes(bodies, observed.sum(axis=1))
    steps = _undo_prediction(observed, _from_zigzag(planes[0] | planes[1] << 8))
    weight_units = _undo_differences(observed, _from_zigzag(planes[2] | planes[3] << 8), 0xFFFF)
    is_damaged = (np.abs(steps) > _MAX_DISTANCE_STEPS) | (observed & (weight_units == 0))
    if is_damaged.any():
        raise DataLossError("a packed leaf is corrupt: a voxel is out of range", reason="CHECKSUM")
    # Rounded once, as the server does: a quotient of two float32 differs in its last bit.
    step_m = np.float32(truncation_m / _MAX_DISTANCE_STEPS)
    distance_m = np.where(observed, steps.astype(np.float32) * step_m, np.float32(np.nan))
    colors = [_undo_differences(observed, _from_zigzag(plane), 0xFF) for plane in planes[4:7]]
    shape = (len(leaves), _SIDE, _SIDE, _SIDE)
    return LeafVoxels(
        observed=read_only(observed.reshape(shape)),
        distance_m=read_only(distance_m.reshape(shape)),
        weight=read_only((weight_units * np.float32(_WEIGHT_UNIT)).reshape(shape)),
        colors=read_only(np.stack(colors, axis=-1).astype(np.uint8).reshape(*shape, 3)),
    )


def _damaged(what: str) -> DataLossError:
    return DataLossError(f"a packed leaf is corrupt: {what}", reason="CHECKSUM")


def _body_of(packed: bytes) -> Tuple[bytes, bool]:
    """Returns the unpacked bytes after the format byte, and True if they contain colours."""
    if not packed:
        return b"", False
    flags = packed[0] & ~0x0F
    if packed[0] & 0x0F != _VERSION or flags & ~(_COLOR_FLAG | _ZSTD_FLAG):
        raise _damaged("its format byte is unknown")
    body = packed[1:]
    if flags & _ZSTD_FLAG:
        if zstandard is None:
            raise RuntimeError("unpack_leaves needs the Python package zstandard")
        try:
            body = zstandard.ZstdDecompressor().decompress(body, max_output_size=_MAX_BODY_BYTES)
        except zstandard.ZstdError as error:
            raise _damaged(str(error)) from None
    if len(body) < _MASK_BYTES:
        raise _damaged("it is truncated")
    return body, bool(flags & _COLOR_FLAG)


def _planes(bodies: List[Tuple[bytes, bool]], counts: np.ndarray) -> List[np.ndarray]:
    """Returns the eight bytes of every observed voxel, one plane per byte, in offset order."""
    parts: List[np.ndarray] = [np.empty((8, 0), np.uint8)]
    for (body, has_color), count in zip(bodies, counts.tolist()):
        plane_count = 2 * _GEOMETRY_BYTES if has_color else _GEOMETRY_BYTES
        if not body and not count:
            continue
        if not count or len(body) != _MASK_BYTES + plane_count * count:
            raise _damaged("its length does not fit its mask")
        part = np.zeros((8, count), np.uint8)
        part[:plane_count] = np.frombuffer(body, np.uint8, offset=_MASK_BYTES).reshape(-1, count)
        parts.append(part)
    return list(np.concatenate(parts, axis=1).astype(np.int32))


def _from_zigzag(zigzag: np.ndarray) -> np.ndarray:
    return (zigzag >> 1) ^ -(zigzag & 1)


def _undo_differences(observed: np.ndarray, residuals: np.ndarray, wrap: int) -> np.ndarray:
    """Restores values stored as differences to the previous observed voxel; 0 elsewhere."""
    differences = np.zeros(observed.shape, np.int32)
    differences[observed] = residuals
    return np.where(observed, np.cumsum(differences, axis=1, dtype=np.int32) & wrap, 0)


def _undo_prediction(observed: np.ndarray, residuals: np.ndarray) -> np.ndarray:
    """Restores distances in steps, offset by offset in all leaves at once; 0 if not observed."""
    has = np.ascontiguousarray(observed.T)
    steps = np.zeros(has.shape, np.int32)
    differences = np.zeros(observed.shape, np.int32)
    differences[observed] = residuals
    differences = np.ascontiguousarray(differences.T)
    for offset in range(_VOXELS):
        value = _predict(has, steps, offset) + differences[offset]
        wrapped = ((value + 0x8000) & 0xFFFF) - 0x8000
        steps[offset] = np.where(has[offset], wrapped, 0)
    return steps.T


def _predict(has: np.ndarray, steps: np.ndarray, offset: int) -> np.ndarray:
    """Implements PredictDistance of core/volume/tsdf_codec.cpp; the last matching rule wins."""
    x, y, z = offset - 64, offset - 8, offset - 1
    along_x, along_y, depth = offset >> 6 > 0, offset >> 3 & 7 > 0, offset & 7
    prediction = np.zeros(has.shape[1], np.int32)

    def use(condition: np.ndarray, values: Optional[np.ndarray]) -> np.ndarray:
        return np.where(condition, values, prediction)

    if along_x:
        prediction = use(has[x], steps[x])
    if along_y:
        prediction = use(has[y], steps[y])
    if depth > 0:
        prediction = use(has[z], steps[z])
    if depth > 1:
        prediction = use(has[z] & has[z - 1], 2 * steps[z] - steps[z - 1])
    if depth > 0 and along_x:
        xz = x - 1
        prediction = use(has[z] & has[x] & has[xz], steps[z] + steps[x] - steps[xz])
    if depth > 0 and along_y:
        yz = y - 1
        prediction = use(has[z] & has[y] & has[yz], steps[z] + steps[y] - steps[yz])
    if depth > 0 and along_x and along_y:
        xy, xz, yz, xyz = x - 8, x - 1, y - 1, x - 9
        near = has[x] & has[y] & has[z] & has[xy] & has[xz] & has[yz] & has[xyz]
        linear = steps[x] + steps[y] + steps[z] - steps[xy] - steps[xz] - steps[yz] + steps[xyz]
        prediction = use(near, linear)
    return prediction
