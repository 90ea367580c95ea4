"""Items yielded by a watch."""

import dataclasses
from typing import Optional, Tuple, Union

from steadymap._generated.v1 import watch_service_pb2
from steadymap.timestamps import time_ns_from_proto
from steadymap.objects import Event, Object, event_from_proto, object_from_proto
from steadymap.volumes import Leaf, leaf_from_proto


@dataclasses.dataclass(frozen=True)
class Created:
    """The watch starts, or restarts without a resume position: drop the previous state.

    Attributes:
        revision: Revision of the watcher, or of the snapshot that follows.
        voxel_size_m, truncation_m: Scale of the map, metres.
        incarnation: A new value means that the map's history was replaced.
    """

    revision: int
    voxel_size_m: float
    truncation_m: float
    incarnation: str


@dataclasses.dataclass(frozen=True)
class Snapshot:
    """Part of the filtered map at one revision; complete with the next Progress."""

    revision: int
    objects: Tuple[Object, ...]
    leaves: Tuple[Leaf, ...]


@dataclasses.dataclass(frozen=True)
class Delta:
    """Part of a change: apply the removals first, then the objects, then the leaves.

    Attributes:
        revision: Revision of the map after the step.
        previous_revision: Revision before the step, that of the last Progress.
        commits: Commits covered by the step; more than one if this watcher was slower than the map.
        removed_object_ids: Objects to remove completely.
        objects: New states.
        leaves: New leaves, and patches of known ones if WatchOptions.takes_patches; an empty leaf
            is removed.
    """

    revision: int
    previous_revision: int
    commits: int
    removed_object_ids: Tuple[int, ...]
    objects: Tuple[Object, ...]
    leaves: Tuple[Leaf, ...]


@dataclasses.dataclass(frozen=True)
class Events:
    """Part of the events up to `revision`, in ascending order of number, each once."""

    revision: int
    events: Tuple[Event, ...]


@dataclasses.dataclass(frozen=True)
class Progress:
    """Everything up to `revision` that passes the filter was received.

    A later watch, also in another process, can resume here with `resume_token`.

    Attributes:
        last_capture_time_ns: Capture time of the newest frame in the map, nanoseconds since 1970;
            None: none yet.
    """

    revision: int
    resume_token: bytes
    last_capture_time_ns: Optional[int]


@dataclasses.dataclass(frozen=True)
class Resync:
    """The history was compacted: drop the state; a snapshot of `revision` follows.

    Attributes:
        revision: Revision of the snapshot.
        reason: REVISION_COMPACTED, REVISION_IN_FUTURE or BAD_RESUME_TOKEN. Events in between are
            missing in the watch; `Client.events` may still return them.
    """

    revision: int
    reason: str


WatchItem = Union[Created, Snapshot, Delta, Events, Progress, Resync]


def item_from_proto(response: watch_service_pb2.WatchMapResponse) -> Optional[WatchItem]:
    """Converts a message; None for `goodbye` and for kinds of a newer server."""
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
