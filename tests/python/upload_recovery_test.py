"""Uploads that continue after a restart of the daemon."""

import tempfile
import threading
import unittest
from pathlib import Path

from daemon_process import DaemonProcess
from wall_frame import wall_frame

import steadymap
from steadymap import errors

FRAMES = 40
WAIT_S = 60.0
BACKOFF = steadymap.BackoffOptions(first_delay_s=0.01, max_delay_s=0.05, give_up_after_s=60.0)


class UploadOverRestarts(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.daemon = DaemonProcess(Path(folder.name))
        self.addCleanup(self.daemon.kill)
        self.client = steadymap.connect(self.daemon.address)
        self.addCleanup(self.client.close)
        self.client.create_map("hall")
        self.half_durable = threading.Event()
        self.retried = threading.Event()
        self.options = steadymap.UploadOptions(
            session="long",
            backoff=BACKOFF,
            max_batch_frames=3,
            on_progress=self.note_progress,
            on_retry=lambda error, delay_s: self.retried.set(),
        )

    def note_progress(self, progress):
        if progress.durable >= FRAMES // 2:
            self.half_durable.set()

    def push_half_and_lose_the_daemon(self, uploader, stop):
        for i in range(FRAMES // 2):
            uploader.push(wall_frame(i))
        self.assertTrue(self.half_durable.wait(WAIT_S))
        stop()
        for i in range(FRAMES // 2, FRAMES):
            uploader.push(wall_frame(i))
        self.assertTrue(self.retried.wait(WAIT_S))

    def test_a_killed_one_loses_nothing_and_counts_each_frame_once(self):
        with self.client.uploader("hall", self.options) as uploader:
            self.push_half_and_lose_the_daemon(uploader, self.daemon.kill)
            self.daemon.restart()
            summary = uploader.finish()
        self.assertEqual(summary.refused, [])
        self.assertEqual(summary.progress.integrated, FRAMES)
        self.assertGreaterEqual(summary.progress.reconnections, 1)
        self.assertEqual(self.client.get_map("hall").durable_map_seq, FRAMES)

    def test_a_stopped_one_loses_nothing_and_counts_each_frame_once(self):
        with self.client.uploader("hall", self.options) as uploader:
            self.push_half_and_lose_the_daemon(uploader, self.daemon.terminate)
            self.daemon.restart()
            summary = uploader.finish()
        self.assertEqual(summary.progress.integrated, FRAMES)
        self.assertEqual(self.client.get_map("hall").durable_map_seq, FRAMES)

    def test_killed_ones_again_and_again(self):
        with self.client.uploader("hall", self.options) as uploader:
            for i in range(FRAMES):
                uploader.push(wall_frame(i))
                if i % 10 == 9:
                    self.daemon.kill()
                    self.daemon.restart()
            summary = uploader.finish()
        self.assertEqual(summary.progress.integrated, FRAMES)
        self.assertEqual(self.client.get_map("hall").durable_map_seq, FRAMES)

    def test_a_hanging_one_counts_as_unavailable(self):
        options = steadymap.UploadOptions(
            backoff=steadymap.BackoffOptions(0.01, 0.01, give_up_after_s=0.02)
        )
        self.daemon.pause()
        self.addCleanup(self.daemon.go_on)
        with self.assertRaises(errors.UnavailableError):
            self.client.upload("hall", [wall_frame()], options)


if __name__ == "__main__":
    unittest.main()
