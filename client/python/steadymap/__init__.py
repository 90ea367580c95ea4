"""Object-level maps of changing places: a client of steadymapd, numpy in and out.

    import steadymap
    
    with steadymap.connect("localhost:7443") as client:
        client.create_map("hall", steadymap.MapOptions(policy="pocd"))
        client.upload("hall", frames)
        for thing in client.objects("hall"):
            print(thing.id, thing.cuboid.center_m, thing.stationarity)

Frames: `world` (z up, right-handed, metres) and `camera` (optical: x right, y down, z forward).
Times are integers, nanoseconds since 1970. Returned arrays are read-only.
"""

from steadymap import errors
from steadymap.responses import DistanceSamples, Listing, PointState, RayHits
from steadymap.backoff import BackoffOptions
from steadymap.client import Client, connect
from steadymap.exports import ExportFormat, ExportSummary
from steadymap.frame import Frame, Intrinsics
from steadymap.geometry import Pose
from steadymap.images import DepthSensor, PixelEncoding
from steadymap.maps import (
    ClassMotion,
    GeoAnchor,
    Map,
    MapCondition,
    MapOptions,
    SemanticClass,
    UpdatePolicy,
    WorldFrame,
)
from steadymap.mesh import Mesh
from steadymap.objects import (
    Belief,
    Contradiction,
    Cuboid,
    Event,
    EventReason,
    EventType,
    Object,
    ObjectStanding,
)
from steadymap.robots import PoseError, PoseOffset, Robot, RobotTrust, SensorContradiction
from steadymap.upload import Uploader
from steadymap.upload_options import AckLevel, UploadOptions, UploadSummary
from steadymap.upload_queue import LostFrames, RefusedFrame, UploadProgress
from steadymap.volumes import Leaf, LeafVoxels, Section, unpack_leaves
from steadymap.watch import Watch, WatchKind, WatchOptions, WatchStart
from steadymap.watch_items import Created, Delta, Events, Progress, Resync, Snapshot, WatchItem

__all__ = [
    "AckLevel",
    "BackoffOptions",
    "Belief",
    "ClassMotion",
    "Client",
    "Contradiction",
    "Created",
    "Cuboid",
    "Delta",
    "DepthSensor",
    "DistanceSamples",
    "Event",
    "EventReason",
    "EventType",
    "Events",
    "ExportFormat",
    "ExportSummary",
    "Frame",
    "GeoAnchor",
    "Intrinsics",
    "Leaf",
    "LeafVoxels",
    "Listing",
    "LostFrames",
    "Map",
    "MapCondition",
    "MapOptions",
    "Mesh",
    "Object",
    "ObjectStanding",
    "PixelEncoding",
    "PointState",
    "Pose",
    "PoseError",
    "PoseOffset",
    "Progress",
    "RayHits",
    "RefusedFrame",
    "Resync",
    "Robot",
    "RobotTrust",
    "Section",
    "SemanticClass",
    "SensorContradiction",
    "Snapshot",
    "UpdatePolicy",
    "UploadOptions",
    "UploadProgress",
    "UploadSummary",
    "Uploader",
    "Watch",
    "WatchItem",
    "WatchKind",
    "WatchOptions",
    "WatchStart",
    "WorldFrame",
    "connect",
    "errors",
    "unpack_leaves",
]
