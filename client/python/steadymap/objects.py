"""Objects of a map, their beliefs and their events."""

import dataclasses
from typing import Dict, Optional, Tuple

import numpy as np

from steadymap._generated.v1 import event_pb2, object_pb2
from steadymap.choices import Choice
from steadymap.geometry import read_only, vector_from_proto
from steadymap.timestamps import time_ns_from_proto


class ObjectStanding(Choice):
    """Status of an object.

    TENTATIVE: too few observations to be confirmed. PRESENT: part of the map. ARCHIVED: removed
    from the map and kept for history.
    """

    UNSPECIFIED = "unspecified"
    TENTATIVE = "tentative"
    PRESENT = "present"
    ARCHIVED = "archived"


class EventType(Choice):
    """Type of an event. ROBOT_LOST and ROBOT_FOUND concern robots, all others objects.

    UNSPECIFIED: a type of a newer server, unknown to this package.
    """

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
    CONTRADICTED = "contradicted"


class EventReason(Choice):
    """Reason of an event; see `EventReason` in proto/steadymap/v1/event.proto."""

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
    """The Gaussian-Beta belief of an object.

    Attributes:
        change_mean_m: Expected displacement of the object's surface since it was mapped, metres.
        change_std_m: Standard deviation of the change, metres, above 0.
        alpha: Weight of the evidence for stationarity, above 0.
        beta: Weight of the evidence against stationarity, above 0.
    """

    change_mean_m: float
    change_std_m: float
    alpha: float
    beta: float

    @property
    def stationarity(self) -> float:
        """Expected stationarity in [0, 1]: alpha / (alpha + beta)."""
        return self.alpha / (self.alpha + self.beta)


@dataclasses.dataclass(frozen=True, eq=False)
class Cuboid:
    """An upright box: rotated about the world's z axis only.

    Attributes:
        center_m: float64 (3,), world frame, metres.
        size_m: float64 (3,), full side lengths along the box's own axes, metres.
        yaw_rad: Angle from the world's x axis to the box's, counter-clockwise from above, radians.
    """

    center_m: np.ndarray
    size_m: np.ndarray
    yaw_rad: float

    def corners_m(self) -> np.ndarray:
        """Returns the corners, float64 (8, 3), world frame, metres.

        The bottom four come first, then the top four, each counter-clockwise as seen from above.
        """
        signs = np.array([(x, y, z) for z in (-1, 1) for x, y in _CORNERS_FROM_ABOVE])
        cosine, sine = np.cos(self.yaw_rad), np.sin(self.yaw_rad)
        rotation = np.array(((cosine, -sine, 0.0), (sine, cosine, 0.0), (0.0, 0.0, 1.0)))
        return (signs * self.size_m / 2) @ rotation.T + self.center_m


_CORNERS_FROM_ABOVE = ((-1, -1), (1, -1), (1, 1), (-1, 1))


@dataclasses.dataclass(frozen=True)
class Contradiction:
    """Two sensors that disagree about an object, which stays in the map.

    Attributes:
        present: (robot, sensor) that saw the object.
        absent: (robot, sensor) that finds it gone, shortly after the other one has seen it.
        since_ns, last_ns: Capture times of the first and the last look that found it gone,
            nanoseconds since 1970.
        sessions: Number of sessions that found it gone, at least 2.
    """

    present: Tuple[str, str]
    absent: Tuple[str, str]
    since_ns: int
    last_ns: int
    sessions: int


@dataclasses.dataclass(frozen=True, eq=False)
class Object:
    """State of an object, except its volume, at one revision.

    Attributes:
        id: Unique in its map, never reused, above 0.
        standing: Status of the object.
        class_id: Class with the most votes; 0 if the frames had no labels.
        class_confidence: Share of the votes for that class, in [0, 1].
        votes: Weight of the votes by class.
        cuboid: Bounding box of its surface; for an archived object at its last position.
        T_world_object: float64 (4, 4), frame of its volume in the world, metres.
        belief: Belief that the object is still in place.
        stationarity: Expected stationarity in [0, 1].
        first_seen_ns, last_seen_ns: Capture times of the first and the last supporting frame,
            nanoseconds since 1970.
        views: Number of supporting frames.
        absences: Number of updates with evidence of absence.
        revision: Revision of the last frame that changed it.
        leaves: Size of its volume, 8 x 8 x 8 blocks of voxels.
        contradictions: Sensors that disagree about the object.
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
    contradictions: Tuple[Contradiction, ...]


@dataclasses.dataclass(frozen=True, eq=False)
class Event:
    """One immutable entry of a map's history.

    Attributes:
        number: Position in the history, without gaps from 1.
        type: Type of the event.
        reason: Reason of the event.
        object_id: 0 for events of robots.
        class_id: Class of the object at the time of the event.
        capture_time_ns: Capture time of the frame that caused the event, nanoseconds since 1970.
        revision: First revision that includes the event.
        center_m: float64 (3,), centre of the cuboid after the event, world frame, metres.
        old_center_m: float64 (3,), for moves: centre before the event, world frame, metres; else
            None.
        T_world_object_before, T_world_object_after: float64 (4, 4), for moves recognised by shape:
            the pose of the object's frame before and after the move; else None.
        confidence: For moves: confidence in [0, 1] that it is the same object; else None.
        before, after: Beliefs before and after the event; None for events of robots.
        related_object_id: The other object of a move, merge or split, or that of which a removed
            part was no object of its own; None: none.
        views: Number of supporting frames at the time of the event.
        absences: Number of updates with evidence of absence at the time of the event.
        robot, sensor: For events of robots: ids of the robot and its sensor. CONTRADICTED: of those
            that find the object gone. Else "".
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
    """Returns the wire number of an EventType or its name, such as "removed"."""
    return list(EventType).index(EventType(value))


def belief_from_proto(message: object_pb2.Belief) -> Belief:
    """Converts a belief from the service."""
    return Belief(message.change_mean_m, message.change_std_m, message.alpha, message.beta)


def _contradiction_from_proto(message: object_pb2.Contradiction) -> Contradiction:
    return Contradiction(
        present=(message.present_robot, message.present_sensor),
        absent=(message.absent_robot, message.absent_sensor),
        since_ns=time_ns_from_proto(message, "since"),
        last_ns=time_ns_from_proto(message, "last"),
        sessions=message.sessions,
    )


def object_from_proto(message: object_pb2.Object) -> Object:
    """Converts an object from the service."""
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
        contradictions=tuple(map(_contradiction_from_proto, message.contradictions)),
    )


def event_from_proto(message: event_pb2.ObjectEvent) -> Event:
    """Converts an event from the service."""
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
