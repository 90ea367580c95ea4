r"""Seconds from the restart of a killed daemon to the reconnection of its Python clients.

    cmake --build build/release --target steadymapd steadymap_python
    PYTHONPATH=build/release/client/python:tests/python STEADYMAPD=build/release/server/steadymapd \
        /usr/bin/python3 tests/benchmark/python_return_benchmark.py

An upload of ten frames per second and a watch lose their daemon to kill -9, repeatedly. Time counts
from the moment the new daemon reports that it serves: for the upload to its next acknowledgement,
for the watch to its next item, after one frame of another client. `return_benchmark` measures the
C++ clients in the same way.
"""

import argparse
import statistics
import tempfile
import threading
import time
from pathlib import Path
from typing import List, Tuple

from daemon_process import DaemonProcess
from wall_frame import wall_frame

import steadymap

WAIT_S = 60.0


class Return:
    """Time of the reconnection of a client."""

    def __init__(self) -> None:
        self._back = threading.Event()
        self._moment = 0.0

    def expect(self) -> None:
        """Starts a new round."""
        self._back.clear()

    def note(self) -> None:
        """Records activity of the client; the first one counts."""
        if not self._back.is_set():
            self._moment = time.monotonic()
            self._back.set()

    def await_moment(self) -> float:
        """Waits for the reconnection; returns its time on the monotonic clock."""
        if not self._back.wait(WAIT_S):
            raise RuntimeError(f"a client was not back after {WAIT_S} s")
        return self._moment


def feed(uploader: steadymap.Uploader, stop: threading.Event) -> None:
    """Uploads ten frames per second."""
    number = 0
    while not stop.wait(0.1):
        uploader.push(wall_frame(number))
        number += 1


def follow(watch: steadymap.Watch, back: Return) -> None:
    """Reads a watch to its end."""
    for _ in watch:
        back.note()


def measure(daemon: DaemonProcess, rounds: int, away_s: float) -> Tuple[List[float], List[float]]:
    """Returns the seconds of each round: of the upload, of the watch."""
    client = steadymap.connect(daemon.address)
    client.create_map("fed")
    client.create_map("watched")
    uploading, watching = Return(), Return()
    uploader = client.uploader(
        "fed", steadymap.UploadOptions(on_progress=lambda progress: uploading.note())
    )
    watch = client.watch("watched")
    stop = threading.Event()
    threads = [
        threading.Thread(target=feed, args=(uploader, stop)),
        threading.Thread(target=follow, args=(watch, watching)),
    ]
    for thread in threads:
        thread.start()
    uploading.await_moment()
    watching.await_moment()
    times: Tuple[List[float], List[float]] = ([], [])
    for number in range(rounds):
        daemon.kill()
        time.sleep(away_s)
        uploading.expect()
        watching.expect()
        daemon.restart()
        served = time.monotonic()
        with steadymap.connect(daemon.address) as other:
            other.upload("watched", [wall_frame(number)])
        for back, seconds in zip((uploading, watching), times):
            seconds.append(max(0.0, back.await_moment() - served))
    stop.set()
    watch.close()
    for thread in threads:
        thread.join()
    uploader.close()
    client.close()
    return times


def main() -> None:
    parser = argparse.ArgumentParser(description="Reconnection time of the Python clients.")
    parser.add_argument("--rounds", type=int, default=20)
    parser.add_argument("--away", type=float, default=0.25, help="seconds without a daemon")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        daemon = DaemonProcess(Path(folder))
        try:
            times = measure(daemon, arguments.rounds, arguments.away)
        finally:
            daemon.kill()
    for name, seconds in zip(("Python upload", "Python watch"), times):
        print(f"{name}: median {statistics.median(seconds):.3f} s, most {max(seconds):.3f} s")


if __name__ == "__main__":
    main()
