"""The steadymapd of this build as a child process, like tests/support/daemon_process.h."""

import os
import select
import signal
import socket
import subprocess
import tempfile
import time
import unittest
from pathlib import Path
from typing import Optional, Sequence

import steadymap

# Much more than any start takes; reached only if a daemon hangs.
_START_LIMIT_S = 30.0


def program(variable: str) -> str:
    """Returns the path of a program, which CMake sets in an environment variable."""
    path = os.environ.get(variable)
    if not path:
        raise RuntimeError(f"{variable} must name a program of this build: run the tests by ctest")
    return path


class DaemonProcess:
    """A steadymapd on loopback, on a free port, with its store in its own folder.

    `executable` replaces the steadymapd of this build; `options` precede the usual ones.
    """

    def __init__(
        self, folder: Path, executable: Optional[Path] = None, options: Sequence[object] = ()
    ) -> None:
        self._folder = folder
        self._command = [str(executable or program("STEADYMAPD")), *map(str, options)]
        self._process: Optional[subprocess.Popen] = None
        self._start("127.0.0.1:0")
        self.address = "127.0.0.1:" + (folder / "port").read_text(encoding="ascii").strip()

    @property
    def process_id(self) -> int:
        """Id of the running process."""
        return self._process.pid

    def kill(self) -> None:
        """Sends SIGKILL; returns when the process has ended."""
        if self._process is not None:
            self._process.send_signal(signal.SIGKILL)
            self._process.wait()
            self._process = None

    def terminate(self) -> int:
        """Sends SIGTERM; returns the exit code."""
        self._process.terminate()
        code = self._process.wait()
        self._process = None
        return code

    def run_client(self, client: Path, *arguments: str) -> None:
        """Runs the command line of a build against the daemon; it must succeed."""
        subprocess.run(
            [str(client), "--server", self.address, *arguments],
            check=True,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )

    def pause(self) -> None:
        """Stops the threads of the daemon; its connections stay. Waits until all have stopped."""
        self._process.send_signal(signal.SIGSTOP)
        os.waitpid(self._process.pid, os.WUNTRACED)

    def go_on(self) -> None:
        """Lets a paused daemon run again."""
        if self._process is not None:
            self._process.send_signal(signal.SIGCONT)

    def restart(self) -> None:
        """Starts the daemon again, with the same store and port."""
        self._start(self.address)

    def _start(self, listen: str) -> None:
        (self._folder / "port").unlink(missing_ok=True)
        # The daemon notifies its service manager when it is ready, and holds the write end of the
        # life line until it ends: waiting for either needs no polling.
        life_line, inherited = os.pipe()
        with tempfile.TemporaryDirectory() as scratch, socket.socket(
            socket.AF_UNIX, socket.SOCK_DGRAM
        ) as notify:
            notify.bind(f"{scratch}/notify")
            with open(self._folder / "steadymapd.log", "ab") as log:
                self._process = subprocess.Popen(
                    [
                        *self._command,
                        *("--listen", listen),
                        *("--data-dir", str(self._folder / "data")),
                        *("--port-file", str(self._folder / "port")),
                    ],
                    stderr=log,
                    pass_fds=(inherited,),
                    env={**os.environ, "NOTIFY_SOCKET": f"{scratch}/notify"},
                )
            os.close(inherited)
            try:
                self._await_ready(notify, life_line)
            finally:
                os.close(life_line)

    def _await_ready(self, notify: socket.socket, life_line: int) -> None:
        deadline = time.monotonic() + _START_LIMIT_S
        while True:
            left_s = max(0.0, deadline - time.monotonic())
            readable, _, _ = select.select([notify, life_line], [], [], left_s)
            if notify in readable and b"READY=1" in notify.recv(4096):
                return
            if life_line in readable or not readable:
                log = (self._folder / "steadymapd.log").read_text(errors="replace")
                self.kill()
                raise RuntimeError(f"steadymapd did not start: {log}")


class DaemonTest(unittest.TestCase):
    """Tests with one daemon and one client per class; each test has its own map."""

    daemon: DaemonProcess
    client: steadymap.Client

    @classmethod
    def setUpClass(cls) -> None:
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.daemon = DaemonProcess(Path(folder.name))
        cls.addClassCleanup(cls.daemon.kill)
        cls.client = steadymap.connect(cls.daemon.address)
        cls.addClassCleanup(cls.client.close)

    def new_map(self, options: steadymap.MapOptions = steadymap.MapOptions()) -> str:
        """Creates a map named after the test."""
        name = self._testMethodName.replace("_", "-")[:60]
        self.client.create_map(name, options)
        return name
