"""What a watch yields."""

import dataclasses
from typing import Optional, Tuple, Union

from steadymap._generated.v1 import watch_service_pb2
from steadymap.timestamps import time_ns_from_proto
from steadymap.objects import Event, Object, event_from_proto, object_from_proto
from steadymap.volumes import Leaf, leaf_from_proto


@dataclasses.dataclass(frozen=True)
class Created:
    """The watch begins, or begins anew with nothing to resume from: forget what you have.

    Attributes:
        revision: what the watcher has, or is about to get as a snapshot.
        voxel_size_m, truncation_m: of the map, metres.
        incarnation: another one than before means that the map's history was replaced.
    """

    revision: int
    voxel_size_m: float
    truncation_m: float
    incarnation: str


@dataclasses.dataclass(frozen=True)
class Snapshot:
    """Part of what the filter shows at one revision; whole with the next Progress."""

    revision: int
    objects: Tuple[Object, ...]
    leaves: Tuple[Leaf, ...]


@dataclasses.dataclass(frozen=True)
class Delta:
    """Part of what changed, as states: apply the removals, then the objects, then the leaves.

    Attributes:
        revision: the map after the step.
        previous_revision: the map before it, as the Progress before said.
        commits: that the step covers; more than one: this watcher was slower than the map.
        removed_object_ids: no longer shown; nothing of them is to be kept.
        objects: new states.
        leaves: new leaves, and patches of known ones if WatchOptions.takes_patches; an empty one is
            gone.
    """

    revision: int
    previous_revision: int
    commits: int
    removed_object_ids: Tuple[int, ...]
    objects: Tuple[Object, ...]
    leaves: Tuple[Leaf, ...]


@dataclasses.dataclass(frozen=True)
class Events:
    """Part of what happened up to `revision`, by rising number, no number twice."""

    revision: int
    events: Tuple[Event, ...]


@dataclasses.dataclass(frozen=True)
class Progress:
    """You have everything up to `revision` that passes the filter; `resume_token` goes on from
    here, whenever and in whatever process.

    Attributes:
        last_capture_time_ns: of the newest frame in the map, nanoseconds since 1970; None: none yet.
    """

    revision: int
    resume_token: bytes
    last_capture_time_ns: Optional[int]


@dataclasses.dataclass(frozen=True)
class Resync:
    """The history in between is gone: forget what you have, a snapshot of `revision` follows.

    Attributes:
        revision: of the snapshot.
        reason: REVISION_COMPACTED, REVISION_IN_FUTURE or BAD_RESUME_TOKEN. Events in between are
            lost to the watch; `Client.events` may still have them.
    """

    revision: int
    reason: str


WatchItem = Union[Created, Snapshot, Delta, Events, Progress, Resync]


def item_from_proto(response: watch_service_pb2.WatchMapResponse) -> Optional[WatchItem]:
    """The item of a message; None for `goodbye`, and for a kind that only a newer server knows."""
    kind = response.WhichOneof("kind")
    if kind == "created":
        message = response.created
        return Created(
            message.revision, message.voxel_size_m, message.truncation_m, message.incarnation
        )
    if kind == "snapshot":
        message = response.snapshot
        return Snapshot(message.revision, _objects(message), _leaves(message))
    if kind == "delta":
        message = response.delta
        return Delta(
            revision=message.revision,
            previous_revision=message.previous_revision,
            commits=message.commits,
            removed_object_ids=tuple(message.removed_object_ids),
            objects=_objects(message),
            leaves=_leaves(message),
        )
    if kind == "events":
        message = response.events
        return Events(message.revision, tuple(event_from_proto(event) for event in message.events))
    if kind == "progress":
        message = response.progress
        time_ns = time_ns_from_proto(message, "last_capture_time")
        return Progress(message.revision, message.resume_token, time_ns)
    if kind == "resync":
        return Resync(response.resync.revision, response.resync.reason)
    return None


def _objects(message: object) -> Tuple[Object, ...]:
    return tuple(object_from_proto(entry) for entry in message.objects)


def _leaves(message: object) -> Tuple[Leaf, ...]:
    return tuple(leaf_from_proto(entry) for entry in message.leaves)
