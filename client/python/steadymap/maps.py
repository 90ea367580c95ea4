"""Maps, and how they are built."""

import dataclasses
import enum
from typing import Optional, Sequence, Tuple, Union

from steadymap._generated.v1 import map_pb2
from steadymap.moments import time_ns_from_proto


class UpdatePolicy(str, enum.Enum):
    """How a map decides what to believe. Fixed when the map is created.

    STATIC fuses every frame and removes nothing. POCD keeps objects with a belief each, whether
    they still stand where they stood. The others are there to compare with.
    """

    STATIC = "static"
    VOXEL_CHANGE = "voxel_change"
    SUBMAP_CHANGE = "submap_change"
    TRACKING = "tracking"
    POCD = "pocd"
    POCD_PAPER = "pocd_paper"


class ClassMotion(str, enum.Enum):
    """Whether things of a class move: STATIC not until somebody rebuilds the place, SEMI_STATIC
    within hours or days, DYNAMIC while they are looked at (their pixels are never fused).
    """

    STATIC = "static"
    SEMI_STATIC = "semi_static"
    DYNAMIC = "dynamic"


@dataclasses.dataclass(frozen=True)
class SemanticClass:
    """One row of a map's class table.

    Attributes:
        id: the value in label images, in [0, 65535].
        name: for people, 1 to 64 characters.
        motion: whether things of the class move on their own.
        in_background: whether its surfaces belong to the background instead of forming objects.
    """

    id: int
    name: str
    motion: Union[ClassMotion, str] = ClassMotion.STATIC
    in_background: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "motion", ClassMotion(self.motion))


@dataclasses.dataclass(frozen=True)
class MapOptions:
    """How a map is built; fixed when it is created.

    Attributes:
        voxel_size_m: edge of a voxel, metres, in [0.001, 1]. 0: the server's default, 0.05.
        truncation_m: distances are kept within this of a surface, metres, in [2, 16] voxels.
            0: three voxels.
        max_depth_m: depth beyond this is not fused, metres, in [0.1, 100]. 0: 3.
        policy: how the map decides what to believe.
        classes: that label images may hold. Empty: the server's default, the TorWIC table.
        display_name: for people, at most 128 characters.
        byte_budget: most bytes of the map's volumes in memory. 0: no limit.
    """

    voxel_size_m: float = 0.0
    truncation_m: float = 0.0
    max_depth_m: float = 0.0
    policy: Union[UpdatePolicy, str] = UpdatePolicy.STATIC
    classes: Sequence[SemanticClass] = ()
    display_name: str = ""
    byte_budget: int = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "policy", UpdatePolicy(self.policy))
        object.__setattr__(self, "classes", tuple(self.classes))


@dataclasses.dataclass(frozen=True)
class Map:
    """A map as it was when it was asked for.

    Attributes:
        name: `tenants/{tenant}/maps/{map}`.
        options: how it is built, the server's defaults filled in.
        create_time_ns: when it was created, nanoseconds since 1970, by the server's clock.
        incarnation: changes when the map's history can no longer be continued.
        revision: newest revision; 0: nothing committed yet.
        durable_map_seq: sequence number of the newest durable frame; 0: none yet.
        lag_frames: durable frames that wait for integration.
        refused_frames: frames refused since the server started.
        leaves: 8 x 8 x 8 blocks with at least one observed voxel, background and present objects.
        voxels: observed voxels of background and present objects.
        memory_bytes: bytes of all the map's volumes in memory.
        last_capture_time_ns: of the newest frame in the map; None: none yet.
        present_objects: objects that are part of the map.
        archived_objects: objects that were, kept for history.
    """

    name: str
    options: MapOptions
    create_time_ns: Optional[int]
    incarnation: str
    revision: int
    durable_map_seq: int
    lag_frames: int
    refused_frames: int
    leaves: int
    voxels: int
    memory_bytes: int
    last_capture_time_ns: Optional[int]
    present_objects: int
    archived_objects: int


def full_map_name(name: str) -> str:
    """`hall` is `tenants/default/maps/hall`; what has a slash stays as it is."""
    if not isinstance(name, str):
        raise TypeError(f"map: expected a map's name, got {type(name)}")
    return name if "/" in name else f"tenants/default/maps/{name}"


def split_map_name(name: str) -> Tuple[str, str]:
    """The parent `tenants/{tenant}` and the id of the map. ValueError for any other form."""
    parts = full_map_name(name).split("/")
    if len(parts) != 4 or parts[0] != "tenants" or parts[2] != "maps":
        raise ValueError(f"map: expected an id or tenants/TENANT/maps/MAP, got {name!r}")
    return f"tenants/{parts[1]}", parts[3]


def map_to_proto(options: MapOptions) -> map_pb2.Map:
    """The map to create."""
    message = map_pb2.Map(display_name=options.display_name, byte_budget=options.byte_budget)
    config = message.config
    config.voxel_size_m = options.voxel_size_m
    config.truncation_m = options.truncation_m
    config.max_depth_m = options.max_depth_m
    config.policy = map_pb2.UpdatePolicy.Value(f"UPDATE_POLICY_{options.policy.name}")
    for row in options.classes:
        config.classes.add(
            id=row.id,
            name=row.name,
            motion=map_pb2.ClassMotion.Value(f"CLASS_MOTION_{row.motion.name}"),
            in_background=row.in_background,
        )
    return message


def map_from_proto(message: map_pb2.Map) -> Map:
    """A map that the service described."""
    config, state = message.config, message.state
    policy = map_pb2.UpdatePolicy.Name(config.policy).replace("UPDATE_POLICY_", "")
    return Map(
        name=message.name,
        options=MapOptions(
            voxel_size_m=config.voxel_size_m,
            truncation_m=config.truncation_m,
            max_depth_m=config.max_depth_m,
            policy=UpdatePolicy[policy],
            classes=[_class_from_proto(row) for row in config.classes],
            display_name=message.display_name,
            byte_budget=message.byte_budget,
        ),
        create_time_ns=time_ns_from_proto(message, "create_time"),
        incarnation=message.incarnation,
        revision=state.revision,
        durable_map_seq=state.durable_map_seq,
        lag_frames=state.lag_frames,
        refused_frames=state.refused_frames,
        leaves=state.leaves,
        voxels=state.voxels,
        memory_bytes=state.memory_bytes,
        last_capture_time_ns=time_ns_from_proto(state, "last_capture_time"),
        present_objects=state.present_objects,
        archived_objects=state.archived_objects,
    )


def _class_from_proto(row: map_pb2.SemanticClass) -> SemanticClass:
    motion = map_pb2.ClassMotion.Name(row.motion).replace("CLASS_MOTION_", "")
    return SemanticClass(
        id=row.id, name=row.name, motion=ClassMotion[motion], in_background=row.in_background
    )
