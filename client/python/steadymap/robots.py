"""Robots as a map knows them."""

import dataclasses
import enum
from typing import Optional, Tuple

import numpy as np

from steadymap._generated.v1 import robot_pb2
from steadymap.geometry import Pose, read_only, vector_from_proto
from steadymap.timestamps import time_ns_from_proto


class RobotTrust(str, enum.Enum):
    """Trust of a map in the poses of a robot.

    TRUSTED: its frames are used. DOUBTED: its pose jumped; its frames are ignored until they agree
    with the map, or it is lost. LOST: its frames disagree with the map and are ignored.
    UNSPECIFIED: a state of a newer server, unknown to this package.
    """

    UNSPECIFIED = "unspecified"
    TRUSTED = "trusted"
    DOUBTED = "doubted"
    LOST = "lost"


@dataclasses.dataclass(frozen=True, eq=False)
class PoseOffset:
    """Error of the poses of a session, by the known objects that the robot saw in place.

    Attributes:
        time_ns: Capture time of the last frame of the session, nanoseconds since 1970.
        T_map_robot: float64 (4, 4), moves points in the world frame of the robot's poses to where
            they are in the map, metres.
        center_m: float64 (3,), centre of the observed surface of these objects, metres.
        shift_m: float64 (3,), shift of the centre, metres.
        yaw_rad: Rotation about the z axis, counter-clockwise from above, radians.
        covariance: float64 (4, 4), of shift x, y, z and yaw; metres and radians.
        anchors: Number of known objects that agree with the offset, at least 1.
    """

    time_ns: int
    T_map_robot: np.ndarray
    center_m: np.ndarray
    shift_m: np.ndarray
    yaw_rad: float
    covariance: np.ndarray
    anchors: int


@dataclasses.dataclass(frozen=True, eq=False)
class PoseError:
    """Error of the pose of a frame, as the correction that its registration to the map found.

    Attributes:
        time_ns: Capture time of the frame, nanoseconds since 1970.
        shift_m: float64 (3,), shift of the camera that corrects its pose, world frame, metres.
        rotation_rad: float64 (3,), rotation about the camera, axis times angle, world frame.
        covariance: float64 (6, 6), of shift and rotation; metres and radians.
    """

    time_ns: int
    shift_m: np.ndarray
    rotation_rad: np.ndarray
    covariance: np.ndarray


@dataclasses.dataclass(frozen=True)
class SensorContradiction:
    """A sensor that disagrees with another one about present objects.

    Attributes:
        robot, sensor: Ids of the sensor that disagrees.
        objects: Number of objects that one of both sees and the other one finds gone.
        since_ns: Capture time since which they disagree, nanoseconds since 1970.
    """

    robot: str
    sensor: str
    objects: int
    since_ns: int


@dataclasses.dataclass(frozen=True, eq=False)
class Robot:
    """A sensor of a robot, as a map knows it.

    Attributes:
        robot: Id of the robot.
        sensor: Id of the sensor.
        trust: Trust in its poses.
        last_capture_time_ns: Capture time of its last integrated frame, nanoseconds since 1970.
        T_world_camera: float64 (4, 4), camera pose of that frame, as the robot stated it, metres.
        session_start_ns: Capture time of the first frame of its open session; None if no session is
            open.
        pose_error: Error of the pose of its last used frame; None if no frame was used yet, or the
            map does not register frames (`pose_error_m` = 0).
        offset: Error of the poses of its last session that ended, at its end; None if that showed
            no known object in place, or none has ended yet.
        contradictions: Sensors that disagree with this one.
    """

    robot: str
    sensor: str
    trust: RobotTrust
    last_capture_time_ns: int
    T_world_camera: np.ndarray
    session_start_ns: Optional[int]
    pose_error: Optional[PoseError]
    offset: Optional[PoseOffset]
    contradictions: Tuple[SensorContradiction, ...]


_TRUSTS = dict(enumerate(RobotTrust))


def _offset_from_proto(message: robot_pb2.PoseOffset) -> PoseOffset:
    center_m, shift_m = vector_from_proto(message.center_m), vector_from_proto(message.shift_m)
    cosine, sine = np.cos(message.yaw_rad), np.sin(message.yaw_rad)
    T_map_robot = np.eye(4)
    T_map_robot[:2, :2] = ((cosine, -sine), (sine, cosine))
    T_map_robot[:3, 3] = center_m + shift_m - T_map_robot[:3, :3] @ center_m
    return PoseOffset(
        time_ns=time_ns_from_proto(message, "time"),
        T_map_robot=read_only(T_map_robot),
        center_m=center_m,
        shift_m=shift_m,
        yaw_rad=message.yaw_rad,
        covariance=read_only(np.array(message.covariance).reshape(4, 4)),
        anchors=message.anchors,
    )


def _error_from_proto(message: robot_pb2.PoseError) -> PoseError:
    return PoseError(
        time_ns=time_ns_from_proto(message, "time"),
        shift_m=vector_from_proto(message.shift_m),
        rotation_rad=vector_from_proto(message.rotation_rad),
        covariance=read_only(np.array(message.covariance).reshape(6, 6)),
    )


def robot_from_proto(message: robot_pb2.Robot) -> Robot:
    """Converts a robot from the service."""
    pose = message.world_from_camera
    turn = pose.orientation
    return Robot(
        robot=message.robot,
        sensor=message.sensor,
        trust=_TRUSTS.get(message.trust, RobotTrust.UNSPECIFIED),
        last_capture_time_ns=time_ns_from_proto(message, "last_capture_time"),
        T_world_camera=read_only(
            Pose(vector_from_proto(pose.position_m), (turn.x, turn.y, turn.z, turn.w)).matrix()
        ),
        session_start_ns=time_ns_from_proto(message, "session_start"),
        pose_error=_error_from_proto(message.pose_error)
        if message.HasField("pose_error")
        else None,
        offset=_offset_from_proto(message.pose_offset) if message.HasField("pose_offset") else None,
        contradictions=tuple(
            SensorContradiction(
                other.robot, other.sensor, other.objects, time_ns_from_proto(other, "since")
            )
            for other in message.contradictions
        ),
    )
