"""Poses, boxes and arrays of points.

Frames are those of the service: `world` (z up, right-handed, metres) and `camera` (optical: x
right, y down, z forward). `T_world_camera` transforms points from the camera frame to the world
frame: `p_world = T_world_camera @ p_camera`.
"""

import dataclasses
from typing import Any, Optional, Union

import numpy as np

from steadymap._generated.v1 import geometry_pb2

# Largest deviation of the entries of a 4x4 matrix from a rigid transform. Same tolerance as the
# service's for the norm of quaternions.
_RIGID_TOLERANCE = 1e-3


def read_only(array: np.ndarray) -> np.ndarray:
    """Makes the array read-only and returns it."""
    array.flags.writeable = False
    return array


def as_points(value: Any, name: str) -> np.ndarray:
    """Returns an N x 3 float64 array, or raises ValueError naming `name`. (3,) means N = 1."""
    array = np.asarray(value, dtype=np.float64)
    if array.shape == (3,):
        array = array.reshape(1, 3)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"{name}: expected an array of shape (N, 3), got {array.shape}")
    return array


def vector_from_proto(message: geometry_pb2.Vector3) -> np.ndarray:
    """Returns a read-only float64 array of shape (3,)."""
    return read_only(np.array((message.x, message.y, message.z)))


def box_to_proto(box: Any) -> Optional[geometry_pb2.Box]:
    """Converts `((x, y, z), (x, y, z))`: lowest and highest corner, world frame, metres."""
    if box is None:
        return None
    corners = np.asarray(box, dtype=np.float64)
    if corners.shape != (2, 3):
        raise ValueError(
            "box: expected its lowest and its highest corner, an array of shape (2, 3), "
            f"got shape {corners.shape}"
        )
    low, high = corners.tolist()
    return geometry_pb2.Box(
        min_m=geometry_pb2.Vector3(x=low[0], y=low[1], z=low[2]),
        max_m=geometry_pb2.Vector3(x=high[0], y=high[1], z=high[2]),
    )


@dataclasses.dataclass(frozen=True, eq=False)
class Pose:
    """A rigid transform `T_destination_source`.

    Attributes:
        position_m: float64 (3,), origin of the source frame in the destination frame, metres.
        quaternion_xyzw: float64 (4,), rotation from the source to the destination frame, unit
            length, the real part last.
    """

    position_m: np.ndarray
    quaternion_xyzw: np.ndarray

    def __post_init__(self) -> None:
        for name, length in (("position_m", 3), ("quaternion_xyzw", 4)):
            array = np.array(getattr(self, name), dtype=np.float64)
            if array.shape != (length,):
                raise ValueError(f"{name}: expected shape ({length},), got {array.shape}")
            object.__setattr__(self, name, read_only(array))

    @staticmethod
    def from_matrix(matrix: Any) -> "Pose":
        """Converts a 4x4 homogeneous matrix; ValueError if it is not a rigid transform.

        NaN and infinity are accepted: the service refuses them and names the frame.
        """
        T = np.array(matrix, dtype=np.float64)
        if T.shape != (4, 4):
            raise ValueError(f"pose: expected a 4x4 matrix, got shape {T.shape}")
        if not np.isfinite(T).all():
            # Keeps a non-finite component, so that the service refuses the frame.
            return Pose(
                T[:3, 3], np.full(4, np.nan) if np.isfinite(T[:3, 3]).all() else [0, 0, 0, 1]
            )
        R = T[:3, :3]
        off_rigid = max(
            float(np.abs(R @ R.T - np.eye(3)).max()),
            float(np.abs(T[3] - (0, 0, 0, 1)).max()),
            abs(float(np.linalg.det(R)) - 1.0),
        )
        if off_rigid > _RIGID_TOLERANCE:
            raise ValueError(
                "pose: expected a rigid transform (a rotation, a translation and the row 0 0 0 1), "
                f"got a 4x4 matrix that is off by {off_rigid:.3g}"
            )
        return Pose(T[:3, 3], _quaternion_of_rotation(R))

    def matrix(self) -> np.ndarray:
        """Returns the 4x4 homogeneous matrix, float64."""
        x, y, z, w = self.quaternion_xyzw / np.linalg.norm(self.quaternion_xyzw)
        T = np.eye(4)
        T[:3, 3] = self.position_m
        T[:3, :3] = (
            (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
            (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
            (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
        )
        return T


def as_pose(value: Union[Pose, Any]) -> Pose:
    """Returns a Pose unchanged and converts anything else as a 4x4 matrix."""
    return value if isinstance(value, Pose) else Pose.from_matrix(value)


def pose_to_proto(pose: Pose) -> geometry_pb2.Pose:
    """Converts a pose without checks; NaN is kept."""
    px, py, pz = pose.position_m.tolist()
    x, y, z, w = pose.quaternion_xyzw.tolist()
    return geometry_pb2.Pose(
        position_m=geometry_pb2.Vector3(x=px, y=py, z=pz),
        orientation=geometry_pb2.Quaternion(x=x, y=y, z=z, w=w),
    )


def pose_from_proto(message: geometry_pb2.Pose) -> Pose:
    """Converts a pose from the service."""
    q = message.orientation
    return Pose(vector_from_proto(message.position_m), np.array((q.x, q.y, q.z, q.w)))


def _quaternion_of_rotation(R: np.ndarray) -> np.ndarray:
    # The eigenvector of the largest eigenvalue of Bar-Itzhack's symmetric matrix is the quaternion
    # (x, y, z, w) of the rotation nearest to R. It needs no case distinctions and averages out
    # small errors of R.
    K = np.array(
        (
            (R[0, 0] - R[1, 1] - R[2, 2], R[1, 0] + R[0, 1], R[2, 0] + R[0, 2], R[2, 1] - R[1, 2]),
            (R[1, 0] + R[0, 1], R[1, 1] - R[0, 0] - R[2, 2], R[2, 1] + R[1, 2], R[0, 2] - R[2, 0]),
            (R[2, 0] + R[0, 2], R[2, 1] + R[1, 2], R[2, 2] - R[0, 0] - R[1, 1], R[1, 0] - R[0, 1]),
            (R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], R[0, 0] + R[1, 1] + R[2, 2]),
        )
    )
    _, vectors = np.linalg.eigh(K)
    return vectors[:, 3]
