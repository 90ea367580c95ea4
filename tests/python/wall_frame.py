"""A small frame of a flat wall, like tests/support/wall_frame.h."""

import dataclasses

import numpy as np

import steadymap

WALL_CLASS = 4

# The camera's z axis along world x, its x axis along -y, its y axis down.
LOOK_ALONG_X = np.array(
    ((0.0, 0.0, 1.0, 0.0), (-1.0, 0.0, 0.0, 0.0), (0.0, -1.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
)


def wall_frame(
    number: int = 0,
    *,
    distance_m: float = 2.0,
    eye_m: tuple = (0.0, 0.0, 0.0),
    width_px: int = 64,
    height_px: int = 48,
    **changes: object,
) -> steadymap.Frame:
    """Returns a frame of the wall x = eye + distance: every pixel has this distance.

    `number` sets the capture time, ten frames per second from 100 s.
    """
    T_world_camera = LOOK_ALONG_X.copy()
    T_world_camera[:3, 3] = eye_m
    frame = steadymap.Frame(
        depth=np.full((height_px, width_px), round(distance_m * 1000), np.uint16),
        labels=np.full((height_px, width_px), WALL_CLASS, np.uint8),
        intrinsics=steadymap.Intrinsics(
            width_px=width_px,
            height_px=height_px,
            fx=1.0 * width_px,
            fy=1.0 * width_px,
            cx=(width_px - 1) / 2,
            cy=(height_px - 1) / 2,
        ),
        T_world_camera=T_world_camera,
        capture_time_ns=100_000_000_000 + number * 100_000_000,
    )
    return dataclasses.replace(frame, **changes)
