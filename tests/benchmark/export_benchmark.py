r"""Memory and time of exports and mirrors of a large hall, of one build or of several to compare.

    cmake --build build/release --target steadymap steadymapd steadymap_python
    PYTHONPATH=build/release/client/python:tests/python \
        /usr/bin/python3 tests/benchmark/export_benchmark.py build/release [BUILD ...]

Each build's daemon maps every second frame of the simulated route `hall` (1 184 objects, 312 MiB of
volumes, about 20 s) and is restarted for each row, so that its peak memory belongs to that row.
Peaks are of resident memory and include the daemon's map; processor times are of the daemon. The
last row kills the client of a vdb export after its first bytes and shows the daemon's processor
time after that. Everything is over loopback and in a temporary folder (1 GB); no cleanup is needed.
"""

import argparse
import filecmp
import os
import subprocess
import tempfile
import time
from pathlib import Path
from typing import List, Optional, Tuple

from daemon_process import DaemonProcess

FORMATS = ("ply", "glb", "vdb")
TICKS_PER_S = os.sysconf("SC_CLK_TCK")

# No run takes this long; a run that hangs is killed.
LIMIT_S = 300.0

# A daemon without processor usage for this time is idle.
IDLE_S = 1.0


def resident_mb(process_id: int, field: str) -> float:
    """Returns a field of /proc/PID/status such as VmHWM, in 10^6 bytes."""
    for line in Path(f"/proc/{process_id}/status").read_text(encoding="ascii").splitlines():
        if line.startswith(field + ":"):
            return int(line.split()[1]) * 1024e-6
    raise RuntimeError(f"process {process_id} has no {field}")


def processor_s(process_id: int) -> float:
    """Returns the user and system time of all threads so far."""
    fields = Path(f"/proc/{process_id}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS_PER_S


def run(command: List[str]) -> Tuple[float, float]:
    """Runs a client; returns its wall time and its peak memory in 10^6 bytes."""
    start = time.monotonic()
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as client:
        while True:
            process_id, status, usage = os.wait4(client.pid, os.WNOHANG)
            if process_id != 0:
                break
            if time.monotonic() - start > LIMIT_S:
                client.kill()
            time.sleep(0.005)
        client.returncode = os.waitstatus_to_exitcode(status)
    if client.returncode != 0:
        raise RuntimeError(f"{command} ended with {client.returncode}")
    return time.monotonic() - start, usage.ru_maxrss * 1024e-6


def print_row(
    what: str,
    wall_s: Optional[float],
    daemon_s: float,
    daemon_mb: float,
    client_mb: Optional[float],
) -> None:
    """Prints one line of the table."""
    wall = f"{wall_s:9.2f}" if wall_s is not None else 9 * " "
    client = f"{client_mb:11.0f}" if client_mb is not None else 11 * " "
    print(f"{what:18}{wall}{daemon_s:15.2f}{daemon_mb:13.0f}{client}", flush=True)


class Hall:
    """A daemon of one build with a map of the hall."""

    def __init__(self, build: Path, folder: Path) -> None:
        os.environ["STEADYMAPD"] = str(build / "server/steadymapd")
        self._program = str(build / "client/cli/steadymap")
        self._folder = folder
        self.daemon = DaemonProcess(folder)
        run(self.command("map", "create", "hall", "--policy", "pocd"))
        run(self.command("simulate", "hall", "--route", "hall", "--stride", "2"))

    def command(self, *arguments: str) -> List[str]:
        """Returns the command line of the build's client."""
        return [self._program, "--server", self.daemon.address, *arguments]

    def path(self, name: str) -> Path:
        """Returns the path of an output file."""
        return self._folder / name

    def restart(self) -> None:
        """Restarts the daemon, which resets its peak memory."""
        self.daemon.terminate()
        self.daemon.restart()

    def measure(self, what: str, *arguments: str) -> None:
        """Runs a client against a restarted daemon and prints the usage of both."""
        self.restart()
        daemon = self.daemon.process_id
        before_s = processor_s(daemon)
        wall_s, client_mb = run(self.command(*arguments))
        print_row(
            what, wall_s, processor_s(daemon) - before_s, resident_mb(daemon, "VmHWM"), client_mb
        )

    def measure_killed_export(self) -> None:
        """Kills the client of an export and prints the daemon's usage afterwards."""
        self.restart()
        daemon = self.daemon.process_id
        target = str(self.path("killed.vdb"))
        with subprocess.Popen(
            self.command("export", "hall", "--format", "vdb", "--output", target)
        ) as client:
            while processor_s(daemon) < 0.1 + self._idle_s and client.poll() is None:
                time.sleep(0.001)
            client.kill()
        killed_s = processor_s(daemon)
        used_s, changed = killed_s, time.monotonic()
        while time.monotonic() - changed < IDLE_S:
            time.sleep(0.01)
            now_s = processor_s(daemon)
            if now_s > used_s + 0.02:
                used_s, changed = now_s, time.monotonic()
        print_row("killed vdb export", None, used_s - killed_s, resident_mb(daemon, "VmHWM"), None)

    def measure_all(self) -> None:
        """Prints the table of this build."""
        print(f"{'':18}   wall s   daemon cpu s   daemon MB  client MB")
        self.restart()
        self._idle_s = processor_s(self.daemon.process_id)
        print_row("start", None, self._idle_s, resident_mb(self.daemon.process_id, "VmHWM"), None)
        for name in FORMATS:
            target = str(self.path(f"hall.{name}"))
            self.measure(f"export {name}", "export", "hall", "--format", name, "--output", target)
        self.measure("mirror --once", "mirror", "hall", "--once", "--output", str(self.path("m")))
        if not filecmp.cmp(self.path("m/map.vdb"), self.path("hall.vdb"), shallow=False):
            raise RuntimeError("the mirror differs from the export")
        self.measure_killed_export()


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("builds", metavar="BUILD", nargs="+", type=Path, help="a build's folder")
    for build in parser.parse_args().builds:
        print(build)
        with tempfile.TemporaryDirectory() as folder:
            hall = Hall(build.resolve(), Path(folder))
            try:
                hall.measure_all()
            finally:
                hall.daemon.kill()


if __name__ == "__main__":
    main()
