#!/usr/bin/env python3
"""Uploads a recording from disk and draws the objects' expected stationarity over time.

    steadymapd --listen localhost:7443 --data-dir /tmp/maps &
    steadymap simulate --write /tmp/route --route 1-5
    python3 client/python/examples/upload_folder.py depot /tmp/route --picture objects.png

The folder contains one recording, or several that are uploaded in the order of their names. Each
has the layout of TorWIC-Mapping (poses.txt, calibration.txt, Depth/, Segmentation/, Instances/,
RGB/) or of 7-Scenes (frame-000000.depth.png and so on). Images are uploaded as the files they are.
--picture requires matplotlib.
"""

import argparse
import collections
import itertools
import sys
from pathlib import Path
from typing import Dict, Iterator, List, Tuple

import numpy as np

import steadymap

# 7-Scenes contains no calibration and no times: use the published camera at 30 frames per second,
# from an arbitrary fixed day on. Its world frame has y down.
SEVEN_SCENES_CAMERA = steadymap.Intrinsics(640, 480, 585.0, 585.0, 320.0, 240.0)
SEVEN_SCENES_PERIOD_NS = 33_333_333
SEVEN_SCENES_START_NS = 1_356_998_400_000_000_000
SEVEN_SCENES_T_WORLD_DATASET = np.array(
    ((1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, -1.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
)

Beliefs = Dict[int, List[Tuple[int, float]]]


def read_calibration(file: Path) -> Tuple[steadymap.Intrinsics, np.ndarray, float]:
    """Reads the intrinsics, T_base_camera and the metres per depth unit from a calibration.txt."""
    lines = [line for line in file.read_text().splitlines() if line and not line.startswith("#")]
    camera = dict(part.split("=") for part in lines[0].split())
    numbers = np.array(lines[1].split(), float)
    intrinsics = steadymap.Intrinsics(
        width_px=int(camera["w"]),
        height_px=int(camera["h"]),
        **{name: float(camera[name]) for name in ("fx", "fy", "cx", "cy")},
    )
    return (intrinsics, steadymap.Pose(numbers[:3], numbers[3:]).matrix(), float(lines[2]))


def torwic_frames(folder: Path) -> Iterator[steadymap.Frame]:
    """Yields the frames of a recording in the TorWIC layout."""
    intrinsics, T_base_camera, metres_per_unit = read_calibration(folder / "calibration.txt")
    kinds = {"depth": "Depth", "labels": "Segmentation", "instances": "Instances", "color": "RGB"}
    files = {kind: sorted((folder / name).glob("*.*g")) for kind, name in kinds.items()}
    for i, line in enumerate((folder / "poses.txt").read_text().splitlines()):
        _, seconds, nanoseconds, *numbers = line.split()
        T_world_base = steadymap.Pose(numbers[:3], numbers[3:]).matrix()
        yield steadymap.Frame(
            intrinsics=intrinsics,
            T_world_camera=T_world_base @ T_base_camera,
            capture_time_ns=int(seconds) * 1_000_000_000 + int(nanoseconds),
            metres_per_unit=metres_per_unit,
            **{kind: images[i].read_bytes() for kind, images in files.items() if images},
        )


def seven_scenes_frames(folder: Path) -> Iterator[steadymap.Frame]:
    """Yields the frames with a pose of a recording in the 7-Scenes layout."""
    intrinsics = SEVEN_SCENES_CAMERA
    camera_file = folder / "camera-intrinsics.txt"
    if camera_file.exists():
        K = np.loadtxt(camera_file)
        size = (intrinsics.width_px, intrinsics.height_px)
        intrinsics = steadymap.Intrinsics(*size, K[0, 0], K[1, 1], K[0, 2], K[1, 2])
    for file in sorted(folder.glob("frame-*.depth.png")):
        stem = file.name.split(".")[0]
        T_dataset_camera = np.loadtxt(folder / f"{stem}.pose.txt")
        if not np.isfinite(T_dataset_camera).all():
            continue
        colors = [*folder.glob(f"{stem}.color.png"), *folder.glob(f"{stem}.color.jp*g")]
        number = int(stem.split("-")[1])
        yield steadymap.Frame(
            depth=file.read_bytes(),
            color=colors[0].read_bytes() if colors else None,
            intrinsics=intrinsics,
            T_world_camera=SEVEN_SCENES_T_WORLD_DATASET @ T_dataset_camera,
            capture_time_ns=SEVEN_SCENES_START_NS + number * SEVEN_SCENES_PERIOD_NS,
        )


def read_folder(folder: Path) -> Iterator[steadymap.Frame]:
    """Yields the frames of the recording in `folder`, or of all its subfolders in order of name."""
    if (folder / "poses.txt").exists():
        yield from torwic_frames(folder)
    elif any(folder.glob("frame-*.depth.png")):
        yield from seven_scenes_frames(folder)
    else:
        folders = sorted(entry for entry in folder.iterdir() if entry.is_dir())
        if not folders:
            raise SystemExit(f"{folder}: found neither a TorWIC nor a 7-Scenes recording")
        for entry in folders:
            yield from read_folder(entry)


def upload(
    client: steadymap.Client, name: str, frames: Iterator[steadymap.Frame], step: int
) -> Beliefs:
    """Uploads frames and records the expected stationarity after every `step` frames.

    Returns:
        Lists of (capture time in nanoseconds, E[v]) by object id.
    """
    beliefs: Beliefs = collections.defaultdict(list)
    frame_count = 0
    while chunk := list(itertools.islice(frames, step)):
        summary = client.upload(name, chunk)
        frame_count += len(chunk)
        for refused in summary.refused:
            print(f"frame {frame_count - len(chunk) + refused.index} was refused: {refused.error}")
        for thing in client.objects(name):
            beliefs[thing.id].append((chunk[-1].capture_time_ns, thing.stationarity))
    print(f"{frame_count} frames uploaded, {len(beliefs)} objects observed")
    return beliefs


def draw(client: steadymap.Client, name: str, beliefs: Beliefs, picture: Path) -> None:
    """Draws E[v] over time, one line per object, and marks its moves, removals and returns."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    start_ns = min((line[0][0] for line in beliefs.values()), default=0)
    standing = {thing.id for thing in client.objects(name)}
    figure, axes = pyplot.subplots(figsize=(9, 5), constrained_layout=True)
    for object_id, line in sorted(beliefs.items()):
        times_s = [(time_ns - start_ns) * 1e-9 for time_ns, _ in line]
        color = "tab:blue" if object_id in standing else "tab:orange"
        values = [value for _, value in line]
        axes.plot(times_s, values, color=color, alpha=0.6, drawstyle="steps-post")
    marks = {"moved": "s", "removed": "x", "returned": "o"}
    for event in client.events(name, types=list(marks)):
        position = ((event.capture_time_ns - start_ns) * 1e-9, event.after.stationarity)
        axes.plot(*position, "k" + marks[event.type.value])
        axes.annotate(f" {event.object_id}", position, fontsize="small", rotation=60)
    for label, style in (("present at the end", "tab:blue"), ("removed", "tab:orange")):
        axes.plot([], [], color=style, label=label)
    for label, mark in marks.items():
        axes.plot([], [], "k" + mark, label=f"{label}, with the object's id")
    axes.set(xlabel="capture time (s)", ylabel="expected stationarity E[v]", ylim=(0, 1.02))
    axes.set_title(f"Objects of {name}")
    axes.legend(loc="lower left", fontsize="small")
    figure.savefig(picture)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("map", help="the map to create and upload to")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--server", default="localhost:7443", metavar="HOST:PORT")
    parser.add_argument("--policy", default="pocd", help="update policy of the map")
    parser.add_argument("--step", type=int, default=10, help="frames between two queries")
    parser.add_argument("--picture", type=Path, metavar="FILE")
    arguments = parser.parse_args()
    with steadymap.connect(arguments.server) as client:
        client.create_map(arguments.map, steadymap.MapOptions(policy=arguments.policy))
        beliefs = upload(client, arguments.map, read_folder(arguments.folder), arguments.step)
        for event in client.events(arguments.map):
            if event.type is not steadymap.EventType.CREATED:
                subject = f"object {event.object_id}" if event.object_id else event.robot
                print(f"{event.capture_time_ns * 1e-9:.2f} s: {subject} {event.type.value}")
        if arguments.picture is not None:
            draw(client, arguments.map, beliefs, arguments.picture)


if __name__ == "__main__":
    try:
        main()
    except steadymap.errors.SteadymapError as error:
        sys.exit(f"upload_folder.py: {error}")
