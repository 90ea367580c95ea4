"""Clients that lost their server: each attempt opens a new connection.

A channel that has failed keeps failing for a while without a new attempt, which delays the
reconnection.
"""

import asyncio
import socket
import tempfile
import threading
import unittest
from pathlib import Path

from daemon_process import DaemonProcess
from wall_frame import wall_frame

import steadymap
from steadymap import errors

TRIES = 6
TRIES_IN_VAIN = 3
WAIT_S = 60.0

# Delays of 1 ms and attempts of negligible duration; the test ends the retries.
QUICK = steadymap.BackoffOptions(0.001, 0.001, jitter=0.0, give_up_after_s=1000.0)


class _Enough(Exception):
    """Ends a client that would retry forever."""


class LostServer(unittest.TestCase):
    """A listener that closes every connection at once and counts them."""

    def setUp(self):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.accepted = 0
        thread = threading.Thread(target=self.close_whoever_connects)
        thread.start()
        self.addCleanup(thread.join)
        self.addCleanup(self.listener.shutdown, socket.SHUT_RDWR)
        self.client = steadymap.connect(f"127.0.0.1:{self.listener.getsockname()[1]}")
        self.addCleanup(self.client.close)
        self.retries = 0

    def close_whoever_connects(self):
        while True:
            try:
                connection, _ = self.listener.accept()
            except OSError:
                self.listener.close()
                return
            self.accepted += 1
            connection.close()

    def note_retry(self, error, delay_s):
        self.retries += 1
        if self.retries == TRIES:
            raise _Enough

    def test_is_looked_for_by_each_try_of_an_upload(self):
        options = steadymap.UploadOptions(backoff=QUICK, on_retry=self.note_retry)
        with self.assertRaises(_Enough):
            self.client.upload("hall", [wall_frame()], options)
        self.assertEqual(self.accepted, TRIES)

    def test_is_looked_for_by_each_try_of_a_watch(self):
        options = steadymap.WatchOptions(backoff=QUICK, on_retry=self.note_retry)
        with self.client.watch("hall", options) as watch, self.assertRaises(_Enough):
            next(watch)
        self.assertEqual(self.accepted, TRIES)

    def test_is_looked_for_by_each_try_of_an_asynchronous_watch(self):
        options = steadymap.WatchOptions(backoff=QUICK, on_retry=self.note_retry)

        async def follow():
            await self.client.watch_async("hall", options).__anext__()

        with self.assertRaises(_Enough):
            asyncio.run(follow())
        self.assertEqual(self.accepted, TRIES)

    def test_is_not_looked_for_by_a_closed_client(self):
        self.client.close()
        with self.assertRaises(errors.CancelledError):
            next(self.client.watch("hall"))
        with self.assertRaises(errors.CancelledError):
            self.client.upload("hall", [wall_frame()])
        self.assertEqual(self.accepted, 0)


class AKilledDaemon(unittest.TestCase):
    """A daemon that is restarted after a number of failed attempts."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.daemon = DaemonProcess(Path(folder.name))
        self.addCleanup(self.daemon.kill)
        self.client = steadymap.connect(self.daemon.address)
        self.addCleanup(self.client.close)
        self.client.create_map("hall")
        self.killed = threading.Event()
        self.retries = 0

    def note_retry(self, error, delay_s):
        self.assertTrue(self.killed.wait(WAIT_S))
        self.retries += 1
        if self.retries == TRIES_IN_VAIN:
            self.daemon.restart()

    def kill(self):
        self.daemon.kill()
        self.killed.set()

    def test_is_found_by_the_first_try_of_an_upload_behind_its_return(self):
        durable = threading.Event()
        options = steadymap.UploadOptions(
            backoff=QUICK,
            on_retry=self.note_retry,
            on_progress=lambda progress: progress.durable and durable.set(),
        )
        with self.client.uploader("hall", options) as uploader:
            uploader.push(wall_frame(0))
            self.assertTrue(durable.wait(WAIT_S))
            self.kill()
            uploader.push(wall_frame(1))
            summary = uploader.finish()
        self.assertEqual(summary.progress.integrated, 2)
        self.assertEqual(self.retries, TRIES_IN_VAIN)

    def test_is_found_by_the_first_try_of_a_watch_behind_its_return(self):
        options = steadymap.WatchOptions(backoff=QUICK, on_retry=self.note_retry)
        with self.client.watch("hall", options) as watch:
            while not isinstance(next(watch), steadymap.Progress):
                pass
            self.kill()
            # The watch either finds the daemon or waits forever; a frame of another client ends the
            # wait.
            bring = threading.Thread(target=self.bring_a_frame_at_last)
            bring.start()
            self.addCleanup(bring.join)
            while next(watch).revision < 1:
                pass
        self.assertEqual(self.retries, TRIES_IN_VAIN)

    def bring_a_frame_at_last(self):
        with steadymap.connect(self.daemon.address) as other:
            options = steadymap.UploadOptions(backoff=steadymap.BackoffOptions(0.05, 0.05))
            other.upload("hall", [wall_frame(0)], options)


if __name__ == "__main__":
    unittest.main()
