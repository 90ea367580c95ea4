"""Object-level maps of places that do not stand still: a client of steadymapd, numpy in and out.

    import steadymap

    with steadymap.connect("localhost:7443") as client:
        client.create_map("hall", steadymap.MapOptions(policy="pocd"))
        client.upload("hall", frames)
        for thing in client.objects("hall"):
            print(thing.id, thing.cuboid.center_m, thing.stationarity)

Frames: `world` (z up, right-handed, metres) and `camera` (optical: x right, y down, z forward).
Times are integers, nanoseconds since 1970. Arrays in answers are read-only.
"""

from steadymap import errors
from steadymap.answers import DistanceSamples, Listing, RayHits
from steadymap.backoff import BackoffOptions
from steadymap.client import Client, ExportFormat, ExportSummary, connect
from steadymap.frame import Frame, Intrinsics
from steadymap.geometry import Pose
from steadymap.images import PixelEncoding
from steadymap.maps import ClassMotion, Map, MapOptions, SemanticClass, UpdatePolicy
from steadymap.mesh import Mesh
from steadymap.objects import (
    Belief,
    Cuboid,
    Event,
    EventReason,
    EventType,
    Object,
    ObjectStanding,
)
from steadymap.upload import Uploader
from steadymap.upload_options import AckLevel, UploadOptions, UploadSummary
from steadymap.upload_queue import RefusedFrame, UploadProgress

__all__ = [
    "AckLevel",
    "BackoffOptions",
    "Belief",
    "ClassMotion",
    "Client",
    "Cuboid",
    "DistanceSamples",
    "Event",
    "EventReason",
    "EventType",
    "ExportFormat",
    "ExportSummary",
    "Frame",
    "Intrinsics",
    "Listing",
    "Map",
    "MapOptions",
    "Mesh",
    "Object",
    "ObjectStanding",
    "PixelEncoding",
    "Pose",
    "RayHits",
    "RefusedFrame",
    "SemanticClass",
    "UpdatePolicy",
    "UploadOptions",
    "UploadProgress",
    "UploadSummary",
    "Uploader",
    "connect",
    "errors",
]
