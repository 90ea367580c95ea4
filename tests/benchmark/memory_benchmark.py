r"""Memory of the daemon under load and after it, of one build or of several to compare.

    cmake --build build/release --target steadymap steadymapd steadymap_python
    PYTHONPATH=build/release/client/python:tests/python \
        /usr/bin/python3 tests/benchmark/memory_benchmark.py --minutes 60 build/release [BUILD ...]

The load: the simulated route 1-5 is uploaded to one map after another, four at a time. Each map is
exported, meshed and listed, and every second one is deleted; one map of the `hall` remains. Rows
show the resident memory of the daemon, MB of 10^6 bytes, after 5 s without load: without maps;
after the load; after all maps were deleted. `maps MB` is the sum of the reported sizes of the maps.
Everything is over loopback and in a temporary folder (some GB); no cleanup is needed.
"""

import argparse
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from daemon_process import DaemonProcess
from export_benchmark import resident_mb

import steadymap

AT_ONCE = 4
IDLE_S = 5.0
KEPT_MAPS = 20


class Load:
    """Produces load on a daemon of one build for a given time."""

    def __init__(self, build: Path, folder: Path) -> None:
        self._folder = folder
        self._client_program = build / "client/cli/steadymap"
        self.daemon = DaemonProcess(folder, build / "server/steadymapd")
        self._client = steadymap.connect(self.daemon.address)

    def run(self, *arguments: str) -> None:
        """Runs the build's client."""
        self.daemon.run_client(self._client_program, *arguments)

    def _drive(self, number: int) -> None:
        """Creates a map, reads it in every way, and deletes it if its number is odd."""
        name = f"map-{number}"
        self.run("map", "create", name, "--policy", "pocd")
        self.run("simulate", name, "--route", "1-5", "--stride", "2")
        for kind in ("vdb", "glb"):
            output = str(self._folder / f"{name}.{kind}")
            self.run("export", name, "--format", kind, "--output", output)
            Path(output).unlink()
        self._client.mesh(name)
        list(self._client.objects(name))
        list(self._client.events(name))
        if number % 2 or number > 2 * KEPT_MAPS:
            self.run("map", "delete", name)

    def work(self, minutes: float) -> int:
        """Runs the load; returns the number of maps created."""
        self.run("map", "create", "hall", "--policy", "pocd")
        self.run("simulate", "hall", "--route", "hall", "--stride", "2")
        deadline = time.monotonic() + 60.0 * minutes
        made = 0
        with ThreadPoolExecutor(AT_ONCE) as drives:
            while made < AT_ONCE or time.monotonic() < deadline:
                list(drives.map(self._drive, range(made, made + AT_ONCE)))
                made += AT_ONCE
        return made

    def print_row(self, what: str) -> None:
        """Prints one line of the table once the daemon is idle."""
        time.sleep(IDLE_S)
        maps = self._client.list_maps()
        accounted_mb = sum(each.memory_bytes for each in maps) * 1e-6
        resident = resident_mb(self.daemon.process_id, "VmRSS")
        print(f"{what:28}{len(maps):6}{accounted_mb:11.0f}{resident:11.0f}", flush=True)

    def delete_all(self) -> None:
        """Deletes every map."""
        for each in self._client.list_maps():
            self._client.delete_map(each.name)


def main() -> None:
    """Prints one table per build."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=60.0, help="duration (default 60)")
    parser.add_argument("builds", nargs="+", type=Path, metavar="BUILD")
    arguments = parser.parse_args()
    for build in arguments.builds:
        print(f"{str(build):28}{'maps':>6}{'maps MB':>11}{'RSS MB':>11}", flush=True)
        with tempfile.TemporaryDirectory() as folder:
            load = Load(build.resolve(), Path(folder))
            try:
                load.print_row("without maps")
                made = load.work(arguments.minutes)
                load.print_row(f"after {made + 1} maps")
                load.delete_all()
                load.print_row("after all are deleted")
            finally:
                load.daemon.kill()


if __name__ == "__main__":
    main()
