"""Exports of a map to a file."""

import dataclasses
import os
from pathlib import Path
from typing import Any, Callable, Optional, Sequence, Union

from steadymap._generated.v1 import query_service_pb2
from steadymap.checksum import extend_crc32c
from steadymap.choices import Choice
from steadymap.errors import DataLossError
from steadymap.geometry import box_to_proto


class ExportFormat(Choice):
    """File formats: PLY and GLB contain the surface, VDB the volumes."""

    PLY = "ply"
    VDB = "vdb"
    GLB = "glb"


@dataclasses.dataclass(frozen=True)
class ExportSummary:
    """Result of an export.

    Attributes:
        revision: Revision of the exported map.
        file_bytes: Length of the file.
        triangles: Number of triangles of the surface; 0 for volumes.
    """

    revision: int
    file_bytes: int
    triangles: int


def export_request(
    map_name: str, file_format: ExportFormat, box: Any, object_ids: Sequence[int]
) -> query_service_pb2.ExportMapRequest:
    """Builds the request for a part of a map as a file."""
    return query_service_pb2.ExportMapRequest(
        map=map_name,
        format=query_service_pb2.ExportFormat.Value(f"EXPORT_FORMAT_{file_format.name}"),
        box=box_to_proto(box),
        object_ids=object_ids,
    )


def choose_format(path: Path, file_format: Optional[Union[ExportFormat, str]]) -> ExportFormat:
    """Returns the requested format, or the one of the extension. ValueError if it is unknown."""
    return ExportFormat(file_format if file_format is not None else path.suffix.lstrip(".").lower())


def take_export(messages: Any, take_chunk: Callable[[bytes], Any]) -> ExportSummary:
    """Reads an export to its end.

    DataLossError if the file is incomplete or its checksum differs.
    """
    header = trailer = None
    file_bytes, crc32c = 0, 0
    for message in messages:
        kind = message.WhichOneof("kind")
        if kind == "header":
            header = message.header
        elif kind == "trailer":
            trailer = message.trailer
        elif kind == "chunk":
            take_chunk(message.chunk)
            file_bytes += len(message.chunk)
            crc32c = extend_crc32c(crc32c, message.chunk)
    if header is None or trailer is None:
        raise DataLossError(
            f"the file is incomplete: {file_bytes} bytes received, no header or no trailer",
            reason="CHECKSUM",
        )
    if (trailer.file_bytes, trailer.crc32c) != (file_bytes, crc32c):
        raise DataLossError(
            f"the received file differs from the server's: expected {trailer.file_bytes} bytes, "
            f"received {file_bytes}, or the checksum differs",
            reason="CHECKSUM",
        )
    return ExportSummary(header.revision, file_bytes, header.triangles)


def write_export(messages: Any, path: Path) -> ExportSummary:
    """Writes an export to a file, which appears once it is complete."""
    partial = path.with_name(path.name + ".partial")
    try:
        with open(partial, "wb") as file:
            summary = take_export(messages, file.write)
        os.replace(partial, path)
    finally:
        partial.unlink(missing_ok=True)
    return summary
