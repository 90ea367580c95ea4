"""Maps and their configuration."""

import dataclasses
from typing import Mapping, Optional, Sequence, Tuple, Union

from steadymap._generated.v1 import map_pb2
from steadymap.choices import Choice
from steadymap.timestamps import time_ns_from_proto


class UpdatePolicy(Choice):
    """Policy that updates a map from frames. Fixed when the map is created.

    STATIC fuses every frame; surface that rays pass through disappears gradually. POCD keeps a
    belief for each object whether it is still in place. The others are baselines for comparison.
    """

    STATIC = "static"
    VOXEL_CHANGE = "voxel_change"
    SUBMAP_CHANGE = "submap_change"
    TRACKING = "tracking"
    POCD = "pocd"
    POCD_PAPER = "pocd_paper"


class ClassMotion(Choice):
    """Motion of the objects of a class.

    STATIC: only moved by a reconstruction of the place. SEMI_STATIC: moved within hours or days.
    DYNAMIC: moves during observation; its pixels are never fused.
    """

    STATIC = "static"
    SEMI_STATIC = "semi_static"
    DYNAMIC = "dynamic"


@dataclasses.dataclass(frozen=True)
class SemanticClass:
    """One row of a map's class table.

    Attributes:
        id: Value in label images, in [0, 65535].
        name: Name for display, 1 to 64 characters.
        motion: Motion of the objects of the class.
        in_background: True if surfaces of the class belong to the background instead of forming
            objects.
    """

    id: int
    name: str
    motion: Union[ClassMotion, str] = ClassMotion.STATIC
    in_background: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "motion", ClassMotion(self.motion))


class MapCondition(Choice):
    """Condition of a map, independent of other maps.

    OPENING: is being read from disk. READY: accepts frames and answers queries. READ_ONLY: answers
    queries, accepts no frames for now. QUARANTINED: answers queries, accepts no frames until an
    operator has intervened. DAMAGED: its stored data is unreadable. UNKNOWN: the server does not
    report it or reports a newer value.
    """

    UNKNOWN = "unknown"
    OPENING = "opening"
    READY = "ready"
    READ_ONLY = "read_only"
    QUARANTINED = "quarantined"
    DAMAGED = "damaged"


@dataclasses.dataclass(frozen=True)
class GeoAnchor:
    """Position of a world frame on the Earth, WGS 84.

    Attributes:
        latitude_deg, longitude_deg: Origin, degrees, in [-90, 90] and [-180, 180].
        altitude_m: Height of the origin above the ellipsoid, metres, in [-1000, 10000].
        heading_deg: Direction of the x axis, degrees clockwise from true north, in [0, 360).
    """

    latitude_deg: float
    longitude_deg: float
    altitude_m: float = 0.0
    heading_deg: float = 0.0


@dataclasses.dataclass(frozen=True)
class WorldFrame:
    """Description of a map's world frame (z up, right-handed, metres).

    Attributes:
        description: Text about origin and x axis, at most 512 bytes.
        floor: Floor of the building at z = 0, at most 64 bytes.
        anchor: Position on the Earth; None: unknown.
    """

    description: str = ""
    floor: str = ""
    anchor: Optional[GeoAnchor] = None


@dataclasses.dataclass(frozen=True)
class MapOptions:
    """Options of a new map. Fixed at creation, except those that `Client.update_map` changes.

    Attributes:
        voxel_size_m: Edge of a voxel, metres, in [0.001, 1]. 0: the server's default, 0.05.
        truncation_m: Half width of the truncation band, metres, in [2, 16] voxels. 0: three voxels.
        max_depth_m: Depth beyond this is not fused, metres, in [0.1, 100]. 0: 3.
        policy: Policy that updates the map.
        classes: Classes of label images. Empty: the server's default, the TorWIC table.
        display_name: Name for display, at most 128 characters.
        byte_budget: Memory limit of the map in bytes. 0: no limit.
        labels: Labels to organise many maps: at most 64; keys match `[a-z][a-z0-9-]{0,62}`, values
            have at most 256 bytes.
        world_frame: Description of the world frame.
        parameters: Values of the policy's parameters that differ from their defaults, by name;
            `steadymap map create --help` lists them.
    """

    voxel_size_m: float = 0.0
    truncation_m: float = 0.0
    max_depth_m: float = 0.0
    policy: Union[UpdatePolicy, str] = UpdatePolicy.STATIC
    classes: Sequence[SemanticClass] = ()
    display_name: str = ""
    byte_budget: int = 0
    labels: Mapping[str, str] = dataclasses.field(default_factory=dict, hash=False)
    world_frame: WorldFrame = WorldFrame()
    parameters: Mapping[str, float] = dataclasses.field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "policy", UpdatePolicy(self.policy))
        object.__setattr__(self, "classes", tuple(self.classes))
        object.__setattr__(self, "labels", dict(self.labels))
        object.__setattr__(self, "parameters", dict(self.parameters))


@dataclasses.dataclass(frozen=True)
class Map:
    """State of a map at the time of the request.

    Attributes:
        name: `tenants/{tenant}/maps/{map}`.
        options: Options of the map with the server's defaults filled in. Unknown, and equal to
            `MapOptions()`, if the map is OPENING or DAMAGED and its configuration was not read.
        create_time_ns: Creation time by the server's clock, nanoseconds since 1970.
        etag: Changes with every change of the map except its content; see `update_map`.
        incarnation: Changes when the map's history can no longer be continued.
        condition: Condition of the map.
        condition_reason: Text for humans: reason of a condition other than READY.
        revision: Newest revision; 0: nothing committed yet.
        durable_map_seq: Sequence number of the newest durable entry of the map's log, a frame or
            added classes; 0: none yet.
        integrated_map_seq: Sequence number of the newest entry in the newest revision; 0: none yet.
        lag_frames: Durable entries that wait for integration.
        refused_frames: Frames refused since the start of the server.
        leaves: 8 x 8 x 8 blocks with at least one observed voxel, background and present objects.
        voxels: Observed voxels of background and present objects.
        memory_bytes: Bytes of the map in memory: volumes, surfaces and free space.
        last_capture_time_ns: Capture time of the newest frame in the map; None: none yet.
        present_objects: Objects that are part of the map.
        archived_objects: Objects that were part of the map, kept for history.
    """

    name: str
    options: MapOptions
    create_time_ns: Optional[int]
    etag: str
    incarnation: str
    condition: MapCondition
    condition_reason: str
    revision: int
    durable_map_seq: int
    integrated_map_seq: int
    lag_frames: int
    refused_frames: int
    leaves: int
    voxels: int
    memory_bytes: int
    last_capture_time_ns: Optional[int]
    present_objects: int
    archived_objects: int


def full_map_name(name: str) -> str:
    """Expands `hall` to `tenants/default/maps/hall`; returns a name with a slash unchanged."""
    if not isinstance(name, str):
        raise TypeError(f"map: expected a map's name, got {type(name)}")
    return name if "/" in name else f"tenants/default/maps/{name}"


def split_map_name(name: str) -> Tuple[str, str]:
    """Returns the parent `tenants/{tenant}` and the map's id. ValueError for any other form."""
    parts = full_map_name(name).split("/")
    if len(parts) != 4 or parts[0] != "tenants" or parts[2] != "maps":
        raise ValueError(f"map: expected an id or tenants/TENANT/maps/MAP, got {name!r}")
    return f"tenants/{parts[1]}", parts[3]


def map_to_proto(options: MapOptions) -> map_pb2.Map:
    """Builds the message of a map to create."""
    message = map_pb2.Map(
        display_name=options.display_name, byte_budget=options.byte_budget, labels=options.labels
    )
    set_world_frame(options.world_frame, message)
    config = message.config
    config.voxel_size_m = options.voxel_size_m
    config.truncation_m = options.truncation_m
    config.max_depth_m = options.max_depth_m
    config.policy = map_pb2.UpdatePolicy.Value(f"UPDATE_POLICY_{options.policy.name}")
    config.parameters.update(options.parameters)
    for row in options.classes:
        set_class(row, config.classes.add())
    return message


def set_class(row: SemanticClass, message: map_pb2.SemanticClass) -> None:
    """Writes one row of a class table."""
    message.id = row.id
    message.name = row.name
    message.motion = map_pb2.ClassMotion.Value(f"CLASS_MOTION_{row.motion.name}")
    message.in_background = row.in_background


def set_world_frame(frame: WorldFrame, message: map_pb2.Map) -> None:
    """Writes the world frame of a map; clears the field if the frame is empty."""
    message.ClearField("world_frame")
    if frame == WorldFrame():
        return
    message.world_frame.description = frame.description
    message.world_frame.floor = frame.floor
    if frame.anchor is not None:
        message.world_frame.anchor.CopyFrom(map_pb2.GeoAnchor(**dataclasses.asdict(frame.anchor)))


def map_from_proto(message: map_pb2.Map) -> Map:
    """Converts a map from the service."""
    config, state = message.config, message.state
    return Map(
        name=message.name,
        options=MapOptions(
            voxel_size_m=config.voxel_size_m,
            truncation_m=config.truncation_m,
            max_depth_m=config.max_depth_m,
            policy=_policy_from_proto(config.policy),
            classes=[_class_from_proto(row) for row in config.classes],
            parameters=config.parameters,
            display_name=message.display_name,
            byte_budget=message.byte_budget,
            labels=message.labels,
            world_frame=_world_frame_from_proto(message.world_frame),
        ),
        create_time_ns=time_ns_from_proto(message, "create_time"),
        etag=message.etag,
        incarnation=message.incarnation,
        condition=_condition_from_proto(state.condition),
        condition_reason=state.condition_reason,
        revision=state.revision,
        durable_map_seq=state.durable_map_seq,
        integrated_map_seq=state.integrated_map_seq,
        lag_frames=state.lag_frames,
        refused_frames=state.refused_frames,
        leaves=state.leaves,
        voxels=state.voxels,
        memory_bytes=state.memory_bytes,
        last_capture_time_ns=time_ns_from_proto(state, "last_capture_time"),
        present_objects=state.present_objects,
        archived_objects=state.archived_objects,
    )


def _policy_from_proto(number: int) -> UpdatePolicy:
    """Converts a policy; for a map with unknown configuration, returns that of `MapOptions()`."""
    if number == map_pb2.UPDATE_POLICY_UNSPECIFIED:
        return UpdatePolicy.STATIC
    return UpdatePolicy[map_pb2.UpdatePolicy.Name(number).replace("UPDATE_POLICY_", "")]


def _condition_from_proto(number: int) -> MapCondition:
    known = map_pb2.MapCondition.DESCRIPTOR.values_by_number.get(number)
    name = known.name.replace("MAP_CONDITION_", "") if known else ""
    return MapCondition.__members__.get(name, MapCondition.UNKNOWN)


def _world_frame_from_proto(message: map_pb2.WorldFrame) -> WorldFrame:
    anchor = message.anchor
    return WorldFrame(
        description=message.description,
        floor=message.floor,
        anchor=GeoAnchor(
            anchor.latitude_deg, anchor.longitude_deg, anchor.altitude_m, anchor.heading_deg
        )
        if message.HasField("anchor")
        else None,
    )


def _class_from_proto(row: map_pb2.SemanticClass) -> SemanticClass:
    motion = map_pb2.ClassMotion.Name(row.motion).replace("CLASS_MOTION_", "")
    return SemanticClass(
        id=row.id, name=row.name, motion=ClassMotion[motion], in_background=row.in_background
    )
