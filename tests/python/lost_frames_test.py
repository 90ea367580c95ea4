"""Uploads to a service that has lost frames that it had acknowledged as durable."""

import shutil
import tempfile
import unittest
from pathlib import Path

from daemon_process import DaemonProcess
from upload_queue_test import DURABLE, INTEGRATED, ack, frame, opened
from wall_frame import wall_frame

import steadymap
from steadymap import errors
from steadymap.upload_queue import LossRecovery, UploadQueue

FRAMES = 30
BACKOFF = steadymap.BackoffOptions(first_delay_s=0.01, max_delay_s=0.05, give_up_after_s=60.0)


class AQueue(unittest.TestCase):
    """A queue whose service lost frames.

    Frames 1 to 6 are durable, 3 was refused, 5 are integrated, and frame 7 is unsent when the
    service returns with the frames up to 2.
    """

    def queue_of_six(self, recovery):
        queue = UploadQueue(1 << 20, 3, recovery)
        for number in range(1, 8):
            queue.push(frame(number))
        queue.open(opened(credit_frames=6))
        while queue.take_batch() is not None:
            pass
        queue.acknowledge(ack(DURABLE, 6, refused=[3]))
        queue.acknowledge(ack(INTEGRATED, 5))
        return queue

    def take(self, queue):
        """Sends all frames, which become durable; returns their depth bytes by client sequence."""
        sent = {}
        while not queue.all_sent:
            while (index := queue.frame_to_read_again()) is not None:
                queue.fill_in(index, frame(index + 1))
            batch = queue.take_batch().batch
            for i, message in enumerate(batch.frames):
                sent[batch.first_client_seq + i] = len(message.depth.data)
        return sent

    def test_sends_them_again_in_their_order(self):
        queue = self.queue_of_six(LossRecovery.SEND_AGAIN)
        self.assertEqual(queue.open(opened(resume=2)), steadymap.LostFrames(2, 5))
        self.assertEqual((queue.durable, queue.integrated), (2, 2))
        self.assertFalse(queue.can_take_batch())
        self.assertEqual(self.take(queue), {number: number for number in range(3, 8)})
        queue.acknowledge(ack(INTEGRATED, 7, refused=[3]))
        progress = queue.progress(1)
        self.assertEqual((progress.integrated, progress.refused, progress.lost), (6, 1, 0))
        self.assertEqual(progress.sent_again, 4)
        self.assertEqual((queue.buffered_bytes, queue.lost), (0, []))

    def test_gives_them_up_and_counts_them(self):
        queue = self.queue_of_six(LossRecovery.GO_ON)
        lost = steadymap.LostFrames(2, 5)
        self.assertEqual(queue.open(opened(resume=2)), lost)
        self.assertIsNone(queue.open(opened(resume=2)))
        self.assertEqual(self.take(queue), {7: 7})
        queue.acknowledge(ack(INTEGRATED, 1))
        self.assertEqual(queue.progress(1).integrated, 2)
        queue.acknowledge(ack(INTEGRATED, 7))
        progress = queue.progress(1)
        self.assertEqual((progress.durable, progress.integrated), (3, 3))
        self.assertEqual((progress.lost, progress.refused), (3, 1))
        self.assertEqual(queue.lost, [lost])

    def test_that_has_nothing_else_is_done(self):
        queue = self.queue_of_six(LossRecovery.GO_ON)
        queue.open(opened(resume=0))
        self.take(queue)
        queue.acknowledge(ack(DURABLE, 7))
        self.assertEqual(queue.open(opened(resume=0)), steadymap.LostFrames(0, 6))
        self.assertEqual(queue.lost, [steadymap.LostFrames(0, 6)])
        queue.acknowledge(ack(INTEGRATED, 0))
        self.assertEqual(queue.integrated, 7)
        progress = queue.progress(1)
        self.assertEqual((progress.lost, progress.integrated, progress.refused), (6, 0, 1))


class AnUploadToARestoredDaemon(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.daemon = DaemonProcess(self.folder)
        self.addCleanup(self.daemon.kill)
        self.client = steadymap.connect(self.daemon.address)
        self.addCleanup(self.client.close)
        self.client.create_map("hall")
        self.frames = [wall_frame(i) for i in range(FRAMES)]
        self.lost = []

    def options(self, **more):
        """Returns options that restore an older store during the upload.

        They copy the store when a third of the frames is durable, and restore the copy when two
        thirds are.
        """
        stops = []

        def note_progress(progress):
            if not stops and progress.durable >= FRAMES // 3:
                stops.append(self.replace("data", "copy"))
            elif len(stops) == 1 and progress.durable >= 2 * FRAMES // 3:
                stops.append(self.replace("copy", "data"))

        return steadymap.UploadOptions(
            backoff=BACKOFF,
            max_batch_frames=2,
            max_buffered_bytes=1,
            on_progress=note_progress,
            **more,
        )

    def replace(self, source, target):
        self.daemon.kill()
        shutil.rmtree(self.folder / target, ignore_errors=True)
        shutil.copytree(self.folder / source, self.folder / target)
        self.daemon.restart()

    def test_sends_a_sequence_again_and_the_map_is_as_if_nothing_had_happened(self):
        summary = self.client.upload("hall", self.frames, self.options(on_lost=self.lost.append))
        self.assertEqual(len(self.lost), 1)
        self.assertEqual((summary.progress.integrated, summary.lost), (FRAMES, []))
        self.assertEqual(self.client.get_map("hall").integrated_map_seq, FRAMES)
        self.client.create_map("undisturbed")
        self.client.upload("undisturbed", self.frames)
        expected, found = self.client.mesh("undisturbed"), self.client.mesh("hall")
        self.assertGreater(len(expected.vertices), 0)
        self.assertEqual(found.vertices.tobytes(), expected.vertices.tobytes())

    def test_goes_on_behind_what_an_iterator_no_longer_has(self):
        options = self.options(on_lost=self.lost.append)
        summary = self.client.upload("hall", iter(self.frames), options)
        (lost,) = self.lost
        self.assertEqual(summary.lost, [lost])
        count = lost.last + 1 - lost.first
        self.assertEqual(summary.progress.lost, count)
        self.assertEqual(summary.progress.integrated, FRAMES - count)
        self.assertEqual(self.client.get_map("hall").integrated_map_seq, FRAMES - count)

    def test_fails_where_nobody_says_what_to_do(self):
        with self.assertRaisesRegex(errors.DataLossError, "as durable"):
            self.client.upload("hall", iter(self.frames), self.options())

    def test_fails_where_a_frame_cannot_be_read_again(self):
        def read_again(index):
            raise OSError(f"{index}.png is gone")

        with self.assertRaisesRegex(errors.DataLossError, "png is gone") as raised:
            self.client.upload("hall", iter(self.frames), self.options(read_again=read_again))
        self.assertIsInstance(raised.exception.__cause__, OSError)


if __name__ == "__main__":
    unittest.main()
