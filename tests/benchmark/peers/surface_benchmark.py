#!/usr/bin/python3
"""Compares the surface of our maps with Open3D's, fused from the same frames.

    tests/benchmark/peers/surface_benchmark.py build/release/client/cli/steadymap KITCHEN_FOLDER

Maps of the policy `static` and Open3D's TSDF, both from the whole images up to 4 m, are compared
with a reference that Open3D fuses at 1 cm from the same frames. Takes a minute. Needs Debian's
`python3-open3d`.
"""

import argparse
import pathlib
import subprocess
import tempfile

import open3d_fusion
import surface_score
from recordings import FORMATS

FORMAT = "seven-scenes"
MAX_DEPTH_M = 4.0
REFERENCE_VOXEL_M = 0.01
REFERENCE_TRUNCATION_M = 0.04


def fuse_with_open3d(folder, voxel_m, truncation_m, stride_px, path):
    frames = FORMATS[FORMAT](folder)
    open3d_fusion.write(
        open3d_fusion.fuse(frames, voxel_m, truncation_m, MAX_DEPTH_M, stride_px), path
    )


def map_with_steadymap(program, folder, voxel_m, out):
    subprocess.run(
        [
            *(program, "evaluate", "--format", FORMAT, "--sequence", folder),
            *("--policy", "static", "--map-voxel", str(voxel_m)),
            *("--max-depth", str(MAX_DEPTH_M), "--meshes", out),
        ],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    return out / f"{FORMAT}-static.ply"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", help="the command `steadymap`")
    parser.add_argument("folder", type=pathlib.Path, help="the 7-Scenes sequence")
    parser.add_argument("--voxels", type=float, nargs="+", default=[0.05, 0.02], help="metres")
    parser.add_argument("--out", type=pathlib.Path, help="keep the meshes in this folder")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        out = arguments.out or pathlib.Path(temporary)
        out.mkdir(parents=True, exist_ok=True)
        reference = out / "reference.ply"
        fuse_with_open3d(arguments.folder, REFERENCE_VOXEL_M, REFERENCE_TRUNCATION_M, 1, reference)
        surfaces = []
        for voxel_m in arguments.voxels:
            name = f"{100 * voxel_m:g}cm"
            ours = map_with_steadymap(arguments.program, arguments.folder, voxel_m, out / name)
            surfaces.append(ours.rename(out / f"steadymap-{name}.ply"))
            surfaces.append(out / f"open3d-{name}.ply")
            fuse_with_open3d(
                arguments.folder,
                voxel_m,
                open3d_fusion.TRUNCATION_VOXELS * voxel_m,
                2,
                surfaces[-1],
            )
        surface_score.print_scores(reference, surfaces, 0.02)


if __name__ == "__main__":
    main()
