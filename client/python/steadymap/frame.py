"""One observation of a robot: images, pose and capture time."""

import dataclasses
from typing import Any, Optional, Union

import numpy as np

from steadymap._generated.v1 import frame_pb2
from steadymap.geometry import Pose, as_pose, pose_to_proto
from steadymap.images import (
    DepthSensor,
    PixelEncoding,
    check_image,
    encode_color,
    encode_depth,
    encode_labels,
)
from steadymap.timestamps import timestamp_to_proto

_MAX_SIDE_PX = 4096  # Upper bound of the service's own limit.


@dataclasses.dataclass(frozen=True)
class Intrinsics:
    """A pinhole camera without distortion: rectify images before the upload.

    A camera-frame point (x, y, z) projects to the pixel (fx x / z + cx, fy y / z + cy); integer
    coordinates are pixel centres.

    Attributes:
        width_px, height_px: Size of every image of the frame, pixels, in [1, 4096].
        fx, fy: Focal lengths, pixels, above 0.
        cx, cy: Principal point, pixels.
    """

    width_px: int
    height_px: int
    fx: float
    fy: float
    cx: float
    cy: float

    def __post_init__(self) -> None:
        for name in ("width_px", "height_px"):
            side_px = getattr(self, name)
            if not 1 <= side_px <= _MAX_SIDE_PX:
                raise ValueError(f"{name}: expected a value in [1, {_MAX_SIDE_PX}], got {side_px}")


@dataclasses.dataclass(frozen=True, eq=False)
class Frame:
    """A frame to upload. ValueError for images of another size than the intrinsics say, or of a
    wrong type.

    All other errors (e.g. a non-finite pose or a label without a class) are detected by the
    service: it refuses that frame alone, and the upload's summary names it.

    Attributes:
        depth: Distance along the camera's z axis: (H, W) uint16 in units of `metres_per_unit`, 0
            and 65535 mean no return; or (H, W) floating point in metres, non-finite values and
            values <= 0 mean no return; or the bytes of a 16-bit greyscale PNG file.
        intrinsics: Camera of every image of the frame.
        T_world_camera: A Pose, or a 4x4 homogeneous matrix, from the camera's optical frame (x
            right, y down, z forward) to the world (z up), metres. Stored as a Pose.
        capture_time_ns: Capture time, nanoseconds since 1970, as from `time.time_ns()`.
        labels: Class of each pixel, (H, W) integers of the map's class table, or the bytes of a PNG
            file. None: class 0.
        instances: Instance of each pixel, 0 for none, (H, W) integers or the bytes of a PNG file.
            None: unknown.
        color: (H, W, 3) uint8 RGB, or the bytes of a JPEG or PNG file. Packing an array costs about
            20 ms. None: the map's surface keeps its colour.
        metres_per_unit: Metres per unit of depth, in [1e-6, 0.1].
        depth_sensor: A `DepthSensor` or its value.
    """

    depth: Union[np.ndarray, bytes]
    intrinsics: Intrinsics
    T_world_camera: Union[Pose, Any]
    capture_time_ns: int
    labels: Optional[Union[np.ndarray, bytes]] = None
    instances: Optional[Union[np.ndarray, bytes]] = None
    color: Optional[Union[np.ndarray, bytes]] = None
    metres_per_unit: float = 0.001
    depth_sensor: Union[DepthSensor, str] = DepthSensor.UNSPECIFIED

    def __post_init__(self) -> None:
        size = (self.intrinsics.height_px, self.intrinsics.width_px)
        check_image(self.depth, "depth", *size)
        for name in ("labels", "instances"):
            if getattr(self, name) is not None:
                check_image(getattr(self, name), name, *size)
        if self.color is not None:
            check_image(self.color, "color", *size, channels=3)
        if not 1e-6 <= self.metres_per_unit <= 0.1:
            raise ValueError(
                f"metres_per_unit: expected a value in [1e-6, 0.1], got {self.metres_per_unit}"
            )
        object.__setattr__(self, "T_world_camera", as_pose(self.T_world_camera))
        object.__setattr__(self, "depth_sensor", DepthSensor(self.depth_sensor))


def frame_to_proto(frame: Frame, encoding: PixelEncoding) -> frame_pb2.Frame:
    """Converts a frame; copies its images, so the arrays may change afterwards."""
    camera = frame.intrinsics
    message = frame_pb2.Frame(
        capture_time=timestamp_to_proto(frame.capture_time_ns),
        intrinsics=frame_pb2.CameraIntrinsics(
            width_px=camera.width_px,
            height_px=camera.height_px,
            fx=camera.fx,
            fy=camera.fy,
            cx=camera.cx,
            cy=camera.cy,
        ),
        world_from_camera=pose_to_proto(frame.T_world_camera),
        depth=encode_depth(frame.depth, frame.metres_per_unit, encoding),
    )
    message.depth.sensor = frame_pb2.DepthSensor.Value(f"DEPTH_SENSOR_{frame.depth_sensor.name}")
    if frame.labels is not None:
        message.labels.CopyFrom(encode_labels(frame.labels, "labels", encoding))
    if frame.instances is not None:
        message.instances.CopyFrom(encode_labels(frame.instances, "instances", encoding))
    if frame.color is not None:
        message.color.CopyFrom(encode_color(frame.color))
    return message
