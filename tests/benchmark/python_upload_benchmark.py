r"""Frames per second from numpy arrays to INTEGRATED, compared with the C++ client.

    cmake --build build/release --target steadymap steadymapd steadymap_python
    PYTHONPATH=build/release/client/python:tests/python \
        STEADYMAPD=build/release/server/steadymapd STEADYMAP=build/release/client/cli/steadymap \
        /usr/bin/python3 tests/benchmark/python_upload_benchmark.py

Route 1-5 with full sensor noise, 640 x 360, depth and labels. The C++ client is `steadymap upload`,
which sends PNG files unchanged, without encoding. The Python client encodes the arrays of the same
frames. Both upload to one daemon over loopback, alternately; values are medians. Requires Pillow to
decode the PNG files.
"""

import argparse
import dataclasses
import io
import json
import statistics
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Callable, List

import numpy as np
import PIL.Image
from daemon_process import DaemonProcess, program

import steadymap

ROUTE = "1-5"


def unpack(data: bytes) -> np.ndarray:
    """Returns the pixels of a PNG file."""
    pixels = np.asarray(PIL.Image.open(io.BytesIO(data)))
    return pixels if pixels.dtype == np.uint8 else pixels.astype(np.uint16)


def read_frames(folder: Path) -> List[steadymap.Frame]:
    """Returns the frames of the route as arrays, read with the example's reader."""
    frames = []
    for frame in load_example().read_folder(folder):
        arrays = {"depth": unpack(frame.depth), "labels": unpack(frame.labels)}
        frames.append(dataclasses.replace(frame, instances=None, color=None, **arrays))
    return frames


def load_example() -> object:
    """Loads client/python/examples/upload_folder.py as a module."""
    import importlib.util

    file = Path(__file__).resolve().parents[2] / "client/python/examples/upload_folder.py"
    specification = importlib.util.spec_from_file_location("upload_folder", file)
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def rate(upload: Callable[[], int]) -> float:
    """Returns the frames per second of an upload that returns its number of integrated frames."""
    start = time.perf_counter()
    return upload() / (time.perf_counter() - start)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--policy", default="static")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--encodings", nargs="+", default=["raw", "zstd", "png"])
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder, data = Path(scratch, "route"), Path(scratch, "daemon")
        data.mkdir()
        write = [program("STEADYMAP"), "simulate", "--route", ROUTE, "--write", str(folder)]
        subprocess.run(write, check=True, capture_output=True)
        daemon = DaemonProcess(data)
        try:
            measure(arguments, folder, daemon)
        finally:
            daemon.kill()


def measure(arguments: argparse.Namespace, folder: Path, daemon: DaemonProcess) -> None:
    """Runs the uploads alternately and prints the medians."""
    frames = read_frames(folder)
    options = steadymap.MapOptions(policy=arguments.policy)
    with steadymap.connect(daemon.address) as client:

        def upload_from_command_line(name: str) -> int:
            command = [program("STEADYMAP"), "--server", daemon.address, "upload", name]
            command += ["--format", "torwic", "--json", str(folder)]
            done = subprocess.run(command, check=True, capture_output=True)
            return json.loads(done.stdout)["integrated"]

        def upload_from_numpy(name: str, encoding: str) -> int:
            upload_options = steadymap.UploadOptions(encoding=encoding)
            return client.upload(name, frames, upload_options).progress.integrated

        rates = {who: [] for who in ["steadymap upload", *arguments.encodings]}
        for turn in range(arguments.rounds):
            for who, measured in rates.items():
                name = f"round-{turn}-{who.replace(' ', '-')}"
                client.create_map(name, options)
                if who in arguments.encodings:
                    measured.append(rate(lambda: upload_from_numpy(name, who)))
                else:
                    measured.append(rate(lambda: upload_from_command_line(name)))
                client.delete_map(name)
    reference = statistics.median(rates["steadymap upload"])
    for who, measured in rates.items():
        median = statistics.median(measured)
        print(f"{who:>16}: {median:6.1f} frames/s, {100 * median / reference:4.0f} %")


if __name__ == "__main__":
    main()
