"""Fuses recorded depth frames with Open3D's TSDF and writes the mesh as PLY.

    python3 open3d_fusion.py seven-scenes FOLDER --voxel 0.05 --max-depth 4 --out open3d.ply

Needs Debian's `python3-open3d`. The frames are those that `steadymap` reads from the same folder,
in the same world frame, so the mesh can be compared with an exported map: see `surface_score.py`.
"""

import argparse
import pathlib

import numpy
import open3d

from recordings import FORMATS

TRUNCATION_VOXELS = 3.0


def fuse(frames, voxel_m, truncation_m, max_depth_m, stride_px):
    """Returns the mesh of a `ScalableTSDFVolume` of the frames."""
    volume = open3d.pipelines.integration.ScalableTSDFVolume(
        voxel_length=voxel_m,
        sdf_trunc=truncation_m,
        color_type=open3d.pipelines.integration.TSDFVolumeColorType.NoColor,
        depth_sampling_stride=stride_px,
    )
    for frame in frames:
        depth_m = numpy.where(frame.depth_m <= max_depth_m, frame.depth_m, 0.0)
        image = open3d.geometry.RGBDImage()
        image.depth = open3d.geometry.Image(depth_m.astype(numpy.float32))
        image.color = open3d.geometry.Image(numpy.zeros((*depth_m.shape, 3), numpy.uint8))
        camera = open3d.camera.PinholeCameraIntrinsic(
            depth_m.shape[1], depth_m.shape[0], frame.fx, frame.fy, frame.cx, frame.cy
        )
        volume.integrate(image, camera, numpy.linalg.inv(frame.T_world_camera))
    return volume.extract_triangle_mesh()


def write(mesh, path):
    """Writes a mesh as PLY."""
    if not open3d.io.write_triangle_mesh(str(path), mesh):
        raise SystemExit(f"cannot write {path}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("format", choices=sorted(FORMATS))
    parser.add_argument("folders", nargs="+", type=pathlib.Path)
    parser.add_argument("--voxel", type=float, required=True, help="metres")
    parser.add_argument("--truncation", type=float, help="metres; default: 3 voxels")
    parser.add_argument("--max-depth", type=float, default=4.0, help="metres")
    parser.add_argument("--stride", type=int, default=2, help="pixels between sampled rays")
    parser.add_argument("--out", type=pathlib.Path, required=True, help="the PLY file")
    arguments = parser.parse_args()
    truncation_m = arguments.truncation or TRUNCATION_VOXELS * arguments.voxel
    frames = (frame for folder in arguments.folders for frame in FORMATS[arguments.format](folder))
    mesh = fuse(frames, arguments.voxel, truncation_m, arguments.max_depth, arguments.stride)
    write(mesh, arguments.out)


if __name__ == "__main__":
    main()
