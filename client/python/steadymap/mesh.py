"""The surface of a map as triangles."""

import dataclasses
import re
from typing import Optional

import numpy as np

from steadymap.errors import DataLossError
from steadymap.geometry import read_only


@dataclasses.dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles in the world frame.

    Attributes:
        revision: Revision of the exported map.
        vertices: float32 (V, 3), metres.
        normals: float32 (V, 3), unit length, away from the surface.
        triangles: int32 (T, 3), indices into the vertices, counter-clockwise from the front.
        colors: uint8 (V, 3), sRGB; None if the map has no colour.
    """

    revision: int
    vertices: np.ndarray
    normals: np.ndarray
    triangles: np.ndarray
    colors: Optional[np.ndarray]


_FACE = np.dtype([("corners", "u1"), ("vertices", "<i4", 3)])
_HEADER_END = b"end_header\n"
_VERTEX_PROPERTIES = ["x", "y", "z", "nx", "ny", "nz"]
_COLOR_PROPERTIES = ["red", "green", "blue"]


def parse_ply(data: bytes, revision: int) -> Mesh:
    """Parses a PLY file written by the service (core/query/mesh_file.h).

    DataLossError for any other data.
    """
    header_bytes = data.find(_HEADER_END)
    if header_bytes < 0 or not data.startswith(b"ply\nformat binary_little_endian 1.0\n"):
        raise DataLossError("the exported mesh is no binary PLY file")
    header = data[:header_bytes].decode("ascii", "replace")
    counts = dict(re.findall(r"^element (\w+) (\d+)$", header, re.MULTILINE))
    properties = re.findall(r"^property (?:float|uchar) (\w+)$", header, re.MULTILINE)
    has_colors = properties == _VERTEX_PROPERTIES + _COLOR_PROPERTIES
    if not has_colors and properties != _VERTEX_PROPERTIES:
        raise DataLossError(f"the exported mesh has unknown properties: {properties}")
    fields = [("vertex", "<f4", 3), ("normal", "<f4", 3)]
    vertex = np.dtype(fields + [("color", "u1", 3)] if has_colors else fields)
    vertex_count, face_count = int(counts.get("vertex", 0)), int(counts.get("face", 0))
    body = memoryview(data)[header_bytes + len(_HEADER_END) :]
    if len(body) != vertex_count * vertex.itemsize + face_count * _FACE.itemsize:
        raise DataLossError(f"the exported mesh has {len(body)} bytes, contrary to its header")
    vertices = np.frombuffer(body, vertex, count=vertex_count)
    faces = np.frombuffer(body, _FACE, count=face_count, offset=vertices.nbytes)
    if not (faces["corners"] == 3).all():
        raise DataLossError("the exported mesh has faces that are no triangles")
    return Mesh(
        revision=revision,
        vertices=_own(vertices["vertex"]),
        normals=_own(vertices["normal"]),
        triangles=_own(faces["vertices"]),
        colors=_own(vertices["color"]) if has_colors else None,
    )


def _own(field: np.ndarray) -> np.ndarray:
    return read_only(np.ascontiguousarray(field).copy())
