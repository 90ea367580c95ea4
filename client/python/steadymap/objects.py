"""Objects of a map, what is believed of them, and what happened to them."""

import dataclasses
import enum
from typing import Dict, Optional

import numpy as np

from steadymap._generated.v1 import event_pb2, object_pb2
from steadymap.geometry import read_only, vector_from_proto
from steadymap.timestamps import time_ns_from_proto


class ObjectStanding(str, enum.Enum):
    """What an object is to its map: TENTATIVE was seen too seldom to be believed, PRESENT is part
    of the map, ARCHIVED is gone from its place and kept for history."""

    UNSPECIFIED = "unspecified"
    TENTATIVE = "tentative"
    PRESENT = "present"
    ARCHIVED = "archived"


class EventType(str, enum.Enum):
    """What happened. The last two concern robots, all others objects. UNSPECIFIED is what a newer
    server sends and this package does not know."""

    UNSPECIFIED = "unspecified"
    CREATED = "created"
    UPDATED = "updated"
    MOVED = "moved"
    REMOVED = "removed"
    RETURNED = "returned"
    MERGED = "merged"
    SPLIT = "split"
    ROBOT_LOST = "robot_lost"
    ROBOT_FOUND = "robot_found"


class EventReason(str, enum.Enum):
    """Why the map decided so; see `EventReason` in proto/steadymap/v1/event.proto."""

    UNSPECIFIED = "unspecified"
    NEW_SURFACE = "new_surface"
    SEEN_THROUGH = "seen_through"
    DISPLACED = "displaced"
    REPLACED = "replaced"
    SHAPE_MATCHED = "shape_matched"
    CONNECTED = "connected"
    DISCONNECTED = "disconnected"
    DISAGREEMENT = "disagreement"
    AGREEMENT = "agreement"


@dataclasses.dataclass(frozen=True)
class Belief:
    """The Gaussian-Beta state of an object.

    Attributes:
        change_mean_m: expected change, metres: how far its surface has moved since it was mapped.
        change_std_m: standard deviation of the change, metres, above 0.
        alpha: weight of what spoke for the object standing where it stood, above 0.
        beta: weight of what spoke against it, above 0.
    """

    change_mean_m: float
    change_std_m: float
    alpha: float
    beta: float

    @property
    def stationarity(self) -> float:
        """Expected stationarity in [0, 1]: how probably the object stands where it stood."""
        return self.alpha / (self.alpha + self.beta)


@dataclasses.dataclass(frozen=True, eq=False)
class Cuboid:
    """A box that stands upright: turned about the world's z axis only.

    Attributes:
        center_m: float64 (3,), world frame, metres.
        size_m: float64 (3,), full side lengths along the box's own axes, metres.
        yaw_rad: from the world's x axis to the box's, counter-clockwise from above, radians.
    """

    center_m: np.ndarray
    size_m: np.ndarray
    yaw_rad: float

    def corners_m(self) -> np.ndarray:
        """The corners, float64 (8, 3), world frame, metres: the bottom four, then the top four,
        each counter-clockwise from above."""
        signs = np.array([(x, y, z) for z in (-1, 1) for x, y in _CORNERS_FROM_ABOVE])
        cosine, sine = np.cos(self.yaw_rad), np.sin(self.yaw_rad)
        rotation = np.array(((cosine, -sine, 0.0), (sine, cosine, 0.0), (0.0, 0.0, 1.0)))
        return (signs * self.size_m / 2) @ rotation.T + self.center_m


_CORNERS_FROM_ABOVE = ((-1, -1), (1, -1), (1, 1), (-1, 1))


@dataclasses.dataclass(frozen=True, eq=False)
class Object:
    """What is known of an object besides its volume, at one revision.

    Attributes:
        id: unique in its map, never used again, above 0.
        standing: what it is to its map.
        class_id: the class with the most votes; 0 where the frames had no labels.
        class_confidence: share of the votes for that class, in [0, 1].
        votes: weight of the votes by class.
        cuboid: around its surface; of an archived object, where it stood last.
        T_world_object: float64 (4, 4), the frame of its volume in the world, metres.
        belief: whether it still stands where it stood.
        stationarity: expected stationarity in [0, 1].
        first_seen_ns, last_seen_ns: capture times of the first and the last frame that agreed with
            it, nanoseconds since 1970.
        views: frames that agreed with it.
        absences: times that the evidence spoke against it.
        revision: of the last frame that changed it.
        leaves: size of its volume, 8 x 8 x 8 blocks of voxels.
    """

    id: int
    standing: ObjectStanding
    class_id: int
    class_confidence: float
    votes: Dict[int, float]
    cuboid: Cuboid
    T_world_object: np.ndarray
    belief: Belief
    stationarity: float
    first_seen_ns: Optional[int]
    last_seen_ns: Optional[int]
    views: int
    absences: int
    revision: int
    leaves: int


@dataclasses.dataclass(frozen=True, eq=False)
class Event:
    """One entry of a map's history, which never changes once it is there.

    Attributes:
        number: place in the history, gap-free from 1.
        type: what happened.
        reason: why the map decided so.
        object_id: 0 for events of robots.
        class_id: of the object when it happened.
        capture_time_ns: of the frame that decided, nanoseconds since 1970.
        revision: the first that shows what the event tells.
        center_m: float64 (3,), centre of the cuboid after the event, world frame, metres.
        old_center_m: for moves the centre before, likewise; else None.
        T_world_object_before, T_world_object_after: for moves recognised by the shape, float64
            (4, 4): where the object's frame stood, and where the same frame stands now; else None.
        confidence: for moves how sure the map is that it is the same thing, in [0, 1]; else None.
        before, after: beliefs before and after the event; None for events of robots.
        related_object_id: the other object of a move, merge or split; None: there is none.
        views: frames that had agreed with the object by then.
        absences: times that the evidence had spoken against it by then.
        robot, sensor: for events of robots, the ids of the robot and of its sensor; else "".
    """

    number: int
    type: EventType
    reason: EventReason
    object_id: int
    class_id: int
    capture_time_ns: Optional[int]
    revision: int
    center_m: np.ndarray
    old_center_m: Optional[np.ndarray]
    T_world_object_before: Optional[np.ndarray]
    T_world_object_after: Optional[np.ndarray]
    confidence: Optional[float]
    before: Optional[Belief]
    after: Optional[Belief]
    related_object_id: Optional[int]
    views: int
    absences: int
    robot: str
    sensor: str


_STANDINGS = dict(enumerate(ObjectStanding))
_TYPES = dict(enumerate(EventType))
_REASONS = dict(enumerate(EventReason))


def event_type_to_proto(value: object) -> int:
    """The wire's number for an EventType or its name, such as "removed"."""
    return list(EventType).index(EventType(value))


def belief_from_proto(message: object_pb2.Belief) -> Belief:
    """A belief that the service sent."""
    return Belief(message.change_mean_m, message.change_std_m, message.alpha, message.beta)


def object_from_proto(message: object_pb2.Object) -> Object:
    """An object that the service sent."""
    cuboid = message.cuboid
    return Object(
        id=message.id,
        standing=_STANDINGS.get(message.standing, ObjectStanding.UNSPECIFIED),
        class_id=message.class_id,
        class_confidence=message.class_confidence,
        votes={vote.class_id: vote.weight for vote in message.votes},
        cuboid=Cuboid(
            vector_from_proto(cuboid.center_m), vector_from_proto(cuboid.size_m), cuboid.yaw_rad
        ),
        T_world_object=_upright_matrix(message.world_from_object),
        belief=belief_from_proto(message.belief),
        stationarity=message.stationarity,
        first_seen_ns=time_ns_from_proto(message, "first_seen"),
        last_seen_ns=time_ns_from_proto(message, "last_seen"),
        views=message.views,
        absences=message.absences,
        revision=message.revision,
        leaves=message.leaves,
    )


def event_from_proto(message: event_pb2.ObjectEvent) -> Event:
    """An event that the service sent."""
    has = message.HasField
    return Event(
        number=message.number,
        type=_TYPES.get(message.type, EventType.UNSPECIFIED),
        reason=_REASONS.get(message.reason, EventReason.UNSPECIFIED),
        object_id=message.object_id,
        class_id=message.class_id,
        capture_time_ns=time_ns_from_proto(message, "capture_time"),
        revision=message.revision,
        center_m=vector_from_proto(message.center_m),
        old_center_m=vector_from_proto(message.old_center_m) if has("old_center_m") else None,
        T_world_object_before=(
            _upright_matrix(message.world_from_object_before)
            if has("world_from_object_before")
            else None
        ),
        T_world_object_after=(
            _upright_matrix(message.world_from_object_after)
            if has("world_from_object_after")
            else None
        ),
        confidence=message.confidence if has("confidence") else None,
        before=belief_from_proto(message.before) if has("before") else None,
        after=belief_from_proto(message.after) if has("after") else None,
        related_object_id=message.related_object_id or None,
        views=message.views,
        absences=message.absences,
        robot=message.robot,
        sensor=message.sensor,
    )


def _upright_matrix(message: object_pb2.UprightPose) -> np.ndarray:
    matrix = np.eye(4)
    cosine, sine = np.cos(message.yaw_rad), np.sin(message.yaw_rad)
    matrix[:2, :2] = ((cosine, -sine), (sine, cosine))
    matrix[:3, 3] = vector_from_proto(message.position_m)
    return read_only(matrix)
