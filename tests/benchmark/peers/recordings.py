"""Reads recorded depth frames in the layouts that `steadymap upload` reads."""

import dataclasses

import numpy
import open3d


@dataclasses.dataclass
class DepthFrame:
    """A depth image with its camera."""

    depth_m: numpy.ndarray  # height x width, 0: no return.
    fx: float
    fy: float
    cx: float
    cy: float
    T_world_camera: numpy.ndarray  # 4 x 4.


def _depth_units(path):
    return numpy.asarray(open3d.io.read_image(str(path)))


def seven_scenes(folder):
    """Yields the frames of a 7-Scenes sequence in the z-up world of our loader."""
    T_world_dataset = numpy.array(
        [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
    )
    for path in sorted(folder.glob("frame-*.depth.png")):
        units = _depth_units(path)
        pose_file = path.with_name(path.name.replace("depth.png", "pose.txt"))
        pose = numpy.loadtxt(pose_file).reshape(4, 4)
        # The rotation is rounded to the digits of the file.
        u, _, v = numpy.linalg.svd(pose[:3, :3])
        pose[:3, :3] = u @ v
        depth_m = numpy.where(units == 65535, 0, units) * 1e-3
        yield DepthFrame(depth_m, 585.0, 585.0, 320.0, 240.0, T_world_dataset @ pose)


def _rotation(x, y, z, w):
    return open3d.geometry.get_rotation_matrix_from_quaternion(numpy.array([w, x, y, z]))


def _pose(values):
    """Returns the matrix of `tx ty tz qx qy qz qw`."""
    matrix = numpy.eye(4)
    matrix[:3, 3] = values[:3]
    matrix[:3, :3] = _rotation(*values[3:])
    return matrix


def torwic(folder):
    """Yields the frames of a sequence in the TorWIC layout with `calibration.txt`."""
    lines = [
        line
        for line in (folder / "calibration.txt").read_text().splitlines()
        if line.strip() and not line.startswith("#")
    ]
    camera = dict(field.split("=") for field in lines[0].split())
    T_base_camera = _pose([float(word) for word in lines[1].split()])
    metres_per_unit = float(lines[2])
    depth_folder = next(p for p in (folder / "Depth", folder / "depth") if p.is_dir())
    images = sorted(depth_folder.glob("*.png"), key=lambda path: int(path.stem))
    poses = [line.split() for line in (folder / "poses.txt").read_text().splitlines() if line]
    for path, words in zip(images, poses):
        T_world_base = _pose([float(word) for word in words[3:10]])
        yield DepthFrame(
            _depth_units(path) * metres_per_unit,
            float(camera["fx"]),
            float(camera["fy"]),
            float(camera["cx"]),
            float(camera["cy"]),
            T_world_base @ T_base_camera,
        )


FORMATS = {"seven-scenes": seven_scenes, "torwic": torwic}
