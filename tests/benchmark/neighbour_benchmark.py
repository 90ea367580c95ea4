r"""Latency of DURABLE acknowledgements beside busy maps, of one build or of several.

    cmake --build build/release --target steadymap steadymapd steadymap_python
    PYTHONPATH=build/release/client/python:tests/python \
        /usr/bin/python3 tests/benchmark/neighbour_benchmark.py build/release [BUILD ...]

A robot uploads one small frame every 20 ms to its own map, by calls that wait for DURABLE. Rows:
alone; while another map integrates frames with 1 mm voxels, each about 100 ms of work; while that
map is deleted in the middle of a frame; after a restart, while the simulated `hall` (312 MiB of
volumes) is opened and gets its first frame. Times are milliseconds of whole calls, including about
1 ms of Python. Everything is over loopback and in a temporary folder (1 GB); no cleanup is needed.
"""

import argparse
import os
import statistics
import tempfile
import threading
import time
from pathlib import Path
from typing import Callable, List

import grpc
import numpy as np
from daemon_process import DaemonProcess

from steadymap import Frame, Intrinsics
from steadymap._generated.v1 import ingest_service_pb2, ingest_service_pb2_grpc
from steadymap.frame import frame_to_proto
from steadymap.images import PixelEncoding

CALLS = 300
INTERVAL_S = 0.02

# No call takes this long; a call that hangs ends the benchmark.
LIMIT_S = 120.0

# A hall is open within seconds; the row continues until then.
MAX_CALLS = 3000


def wall_frame(width_px: int, height_px: int, distance_m: float, index: int) -> Frame:
    """Returns a frame of a wall straight ahead, 90 degrees wide."""
    focal_px = width_px / 2
    return Frame(
        depth=np.full((height_px, width_px), round(1000 * distance_m), np.uint16),
        intrinsics=Intrinsics(
            width_px, height_px, focal_px, focal_px, (width_px - 1) / 2, (height_px - 1) / 2
        ),
        T_world_camera=np.eye(4),
        capture_time_ns=1_700_000_000_000_000_000 + index * 20_000_000,
    )


class Robot:
    """Uploads frames of one session by unary calls."""

    def __init__(self, address: str, map_id: str, session: str) -> None:
        self._stub = ingest_service_pb2_grpc.IngestServiceStub(grpc.insecure_channel(address))
        self._map = f"tenants/default/maps/{map_id}"
        self._session = session
        self._sent = 0

    def upload(self, frame: Frame) -> float:
        """Uploads a frame; returns the seconds until it is durable."""
        request = ingest_service_pb2.UploadFrameBatchRequest(
            map=self._map, robot="robot", sensor="camera", session=self._session
        )
        request.batch.first_client_seq = self._sent + 1
        request.batch.frames.append(frame_to_proto(frame, PixelEncoding.RAW))
        start = time.monotonic()
        self._stub.UploadFrameBatch(request, timeout=LIMIT_S)
        self._sent += 1
        return time.monotonic() - start

    def measure(self, is_done: Callable[[int], bool]) -> List[float]:
        """Uploads at a constant rate until `is_done(calls)`."""
        times_s: List[float] = []
        while not is_done(len(times_s)) and len(times_s) < MAX_CALLS:
            times_s.append(self.upload(wall_frame(64, 48, 2.0, self._sent)))
            time.sleep(INTERVAL_S)
        return times_s


class Feeder:
    """Keeps a map busy from its own thread until it is stopped or refused."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._feed, daemon=True)
        self._thread.start()

    def _feed(self) -> None:
        index = 0
        while not self._stop.is_set():
            try:
                self._robot.upload(wall_frame(320, 240, 1.0, index))
            except grpc.RpcError:
                return
            index += 1

    def stop(self) -> None:
        """Stops after the end of the last call."""
        self._stop.set()
        self._thread.join()


def print_row(what: str, times_s: List[float]) -> None:
    """Prints one line of the table."""
    ms = sorted(1e3 * each for each in times_s)
    p99 = ms[min(len(ms) - 1, round(0.99 * (len(ms) - 1)))]
    print(f"{what:28}{len(ms):6}{statistics.median(ms):9.1f}{p99:9.1f}{ms[-1]:9.1f}", flush=True)


class Build:
    """A daemon of one build."""

    def __init__(self, build: Path, folder: Path) -> None:
        self._client_program = build / "client/cli/steadymap"
        self.daemon = DaemonProcess(folder, build / "server/steadymapd")

    def run(self, *arguments: str) -> None:
        """Runs the build's client."""
        self.daemon.run_client(self._client_program, *arguments)

    def create(self, map_id: str, *options: str) -> None:
        """Creates a map with the policy static."""
        self.run("map", "create", map_id, "--policy", "static", *options)

    def measure(self) -> None:
        """Prints the rows of this build."""
        self.create("quick")
        robot = Robot(self.daemon.address, "quick", "first")
        enough = CALLS.__le__
        print_row("alone", robot.measure(enough))

        self.create("slow", "--voxel-size", "0.001", "--truncation", "0.004", "--max-depth", "2")
        feeder = Feeder(Robot(self.daemon.address, "slow", "slow"))
        print_row("beside a slow map", robot.measure(enough))
        deletion = threading.Thread(target=self.run, args=("map", "delete", "slow"))
        deletion.start()
        print_row("while it is deleted", robot.measure(enough))
        feeder.stop()
        deletion.join()

        self.run("map", "create", "hall", "--policy", "pocd")
        self.run("simulate", "hall", "--route", "hall", "--stride", "2")
        self.daemon.terminate()
        self.daemon.restart()
        robot = Robot(self.daemon.address, "quick", "second")
        first = threading.Thread(target=self._send_first_frame)
        first.start()
        print_row("while a hall is opened", robot.measure(lambda calls: not first.is_alive()))
        first.join()

    def _send_first_frame(self) -> None:
        """Retries until the hall is open and accepts the frame."""
        robot = Robot(self.daemon.address, "hall", "first")
        deadline = time.monotonic() + LIMIT_S
        while time.monotonic() < deadline:
            try:
                robot.upload(wall_frame(64, 48, 2.0, 0))
                return
            except grpc.RpcError as error:
                if error.code() != grpc.StatusCode.UNAVAILABLE:
                    raise
                time.sleep(INTERVAL_S)


def main() -> None:
    """Prints one table per build."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("builds", nargs="+", type=Path, metavar="BUILD")
    for build in parser.parse_args().builds:
        print(f"{str(build):28}{'calls':>6}{'median':>9}{'p99':>9}{'max':>9}")
        with tempfile.TemporaryDirectory() as folder:
            measured = Build(build.resolve(), Path(folder))
            try:
                measured.measure()
            finally:
                measured.daemon.kill()


if __name__ == "__main__":
    os.environ.setdefault("GRPC_VERBOSITY", "error")
    main()
