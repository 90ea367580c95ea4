"""A disk that is filled at random times: reads work, uploads resume, no frame is lost.

The disk is a tmpfs of the test, which requires a user namespace (`unshare`); the test is skipped if
the system does not allow one. STEADYMAP_FULL_DISK_ROUNDS makes it longer.
"""

import errno
import os
import random
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path

import numpy as np
from daemon_process import DaemonProcess
from wall_frame import wall_frame

import steadymap
from steadymap import errors

ROUNDS = int(os.environ.get("STEADYMAP_FULL_DISK_ROUNDS", "6"))
WAIT_S = 60.0
OWN_MOUNTS = "STEADYMAP_OWN_MOUNTS"

DISK_BYTES = 96 << 20
CONFIG = """
[store]
write_buffer_bytes = 4194304
min_free_disk_bytes = 12582912
"""


class FullDisk(unittest.TestCase):
    """Runs the other class in a namespace with permission to mount a disk."""

    @unittest.skipIf(OWN_MOUNTS in os.environ, "runs in the namespace already")
    def test_in_a_namespace_of_its_own(self):
        unshare = ["unshare", "--mount", "--map-root-user"]
        with tempfile.TemporaryDirectory() as folder:
            mount = [*unshare, "mount", "-t", "tmpfs", "none", folder]
            if subprocess.run(mount, check=False, stderr=subprocess.DEVNULL).returncode:
                self.skipTest("no disks may be mounted here")
        subprocess.run(
            [*unshare, sys.executable, "-m", "unittest", "-v", f"{__name__}.OnSmallDisk"],
            check=True,
            env={**os.environ, OWN_MOUNTS: "1"},
        )


class Feeder:
    """Pushes frames from its own thread until it is stopped."""

    def __init__(self, uploader):
        self._uploader = uploader
        self._stop = threading.Event()
        self.pushed = 0
        self._thread = threading.Thread(target=self._feed)
        self._thread.start()

    def _feed(self):
        noise = np.random.default_rng(1)
        while not self._stop.is_set():
            # Incompressible depth, so that the disk fills up.
            depth = noise.integers(1990, 2010, (240, 320), np.uint16)
            frame = wall_frame(self.pushed, width_px=320, height_px=240, depth=depth)
            self._uploader.push(frame)
            self.pushed += 1

    def stop(self):
        """Stops and returns the number of frames pushed."""
        self._stop.set()
        self._thread.join()
        return self.pushed


@unittest.skipUnless(OWN_MOUNTS in os.environ, "runs in a namespace of its own")
class OnSmallDisk(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.disk = Path(folder.name) / "data"
        self.disk.mkdir()
        self.mount("-t", "tmpfs", "-o", f"size={DISK_BYTES}", "none", str(self.disk))
        self.addCleanup(subprocess.run, ["umount", str(self.disk)], check=True)
        config = Path(folder.name) / "steadymap.toml"
        config.write_text(CONFIG, encoding="ascii")
        self.log = Path(folder.name) / "steadymapd.log"
        self.daemon = DaemonProcess(Path(folder.name), options=["--config", config])
        self.addCleanup(self.daemon.kill)
        self.client = steadymap.connect(self.daemon.address)
        self.addCleanup(self.client.close)
        self.client.create_map("hall")
        self.durable = 0
        self.has_progressed = threading.Condition()

    @staticmethod
    def mount(*arguments):
        subprocess.run(["mount", *arguments], check=True)

    def note_progress(self, progress):
        with self.has_progressed:
            self.durable = progress.durable
            self.has_progressed.notify_all()

    def await_durable(self, count):
        with self.has_progressed:
            if not self.has_progressed.wait_for(lambda: self.durable >= count, WAIT_S):
                self.fail(f"{self.durable} frames are durable, not {count}: {self.log.read_text()}")

    def fill(self):
        """Uses up all free space, like another program."""
        with open(self.disk / "filler", "ab", buffering=0) as filler:
            try:
                while True:
                    filler.write(bytes(1 << 16))
            except OSError as error:
                self.assertEqual(error.errno, errno.ENOSPC)

    def free(self):
        (self.disk / "filler").unlink(missing_ok=True)

    def check_reads(self, least_revision):
        """Waits until the map is open and the channel is connected, and checks its content."""
        deadline = time.monotonic() + WAIT_S
        while True:
            try:
                state = self.client.get_map("hall")
                triangles = self.client.mesh("hall").triangles
                break
            except errors.UnavailableError:
                if time.monotonic() > deadline:
                    raise
                time.sleep(0.01)
        self.assertGreaterEqual(state.revision, least_revision)
        self.assertGreater(len(triangles), 0)
        return state.revision

    def test_filled_at_random_moments(self):
        options = steadymap.UploadOptions(
            session="long",
            backoff=steadymap.BackoffOptions(0.01, 0.2, give_up_after_s=2 * WAIT_S),
            on_progress=self.note_progress,
        )
        moments = random.Random(1)
        revision = 0
        with self.client.uploader("hall", options) as uploader:
            feeder = Feeder(uploader)
            try:
                self.await_durable(40)
                for round_ in range(ROUNDS):
                    self.await_durable(self.durable + moments.randrange(1, 60))
                    self.fill()
                    revision = self.check_reads(revision)
                    if round_ % 3 == 1:
                        self.assertEqual(self.daemon.terminate(), 0)
                        self.daemon.restart()
                    elif round_ % 3 == 2:
                        self.daemon.kill()
                        self.daemon.restart()
                    if round_ % 3:
                        self.fill()
                        revision = self.check_reads(revision)
                    self.free()
                    self.await_durable(self.durable + 1)
            finally:
                pushed = feeder.stop()
            summary = uploader.finish()
        self.assertEqual(summary.refused, [])
        state = self.client.get_map("hall")
        self.assertEqual((state.durable_map_seq, state.lag_frames), (pushed, 0))
        self.assertEqual(self.daemon.terminate(), 0)
