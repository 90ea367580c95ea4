"""The pure state of an upload."""

import unittest

from steadymap import errors
from steadymap._generated.v1 import frame_pb2, ingest_service_pb2
from steadymap.checksum import extend_crc32c
from steadymap.upload_queue import UploadQueue

RECEIVED = ingest_service_pb2.ACK_LEVEL_RECEIVED
DURABLE = ingest_service_pb2.ACK_LEVEL_DURABLE
INTEGRATED = ingest_service_pb2.ACK_LEVEL_INTEGRATED


def frame(size=1000):
    return frame_pb2.Frame(depth=frame_pb2.DepthImage(data=bytes(size)))


def opened(resume=0, credit_bytes=1 << 20, credit_frames=100, max_message_bytes=0):
    message = ingest_service_pb2.UploadOpened(
        resume_client_seq=resume, max_message_bytes=max_message_bytes
    )
    message.credit.bytes, message.credit.frames = credit_bytes, credit_frames
    return message


def ack(level, client_seq, refused=(), revision=0):
    message = ingest_service_pb2.UploadAck(level=level, client_seq=client_seq, revision=revision)
    for sequence in refused:
        message.refused.add(client_seq=sequence)
    return message


def queue_of(count, max_batch_bytes=1 << 20, max_batch_frames=8, size=1000):
    queue = UploadQueue(max_batch_bytes, max_batch_frames)
    for _ in range(count):
        queue.push(frame(size))
    return queue


def take_all(queue):
    """Returns (first sequence, frame count) of every batch that the credit allows."""
    batches = []
    while (request := queue.take_batch()) is not None:
        batches.append((request.batch.first_client_seq, len(request.batch.frames)))
    return batches


class Batches(unittest.TestCase):
    def test_wait_for_the_opening(self):
        self.assertFalse(queue_of(1).can_take_batch())

    def test_hold_so_many_frames_and_bytes(self):
        queue = queue_of(10, max_batch_frames=4)
        queue.open(opened())
        self.assertEqual(take_all(queue), [(1, 4), (5, 4), (9, 2)])
        queue = queue_of(4, max_batch_bytes=2500)
        queue.open(opened())
        self.assertEqual(take_all(queue), [(1, 2), (3, 2)])

    def test_hold_one_frame_that_is_larger_than_a_batch(self):
        queue = queue_of(2, max_batch_bytes=10)
        queue.open(opened())
        self.assertEqual(take_all(queue), [(1, 1), (2, 1)])

    def test_keep_within_credit(self):
        queue = queue_of(10)
        queue.open(opened(credit_frames=3))
        self.assertEqual(take_all(queue), [(1, 3)])
        queue.grant(ingest_service_pb2.UploadCredit(bytes=0, frames=2))
        self.assertEqual(take_all(queue), [(4, 2)])
        queue = queue_of(10)
        queue.open(opened(credit_bytes=2500))
        batches = take_all(queue)
        self.assertEqual(batches, [(1, 2)])
        self.assertLessEqual(queue.progress(0).bytes_sent, 2500)

    def test_of_a_frame_beyond_the_servers_limit_are_an_error(self):
        queue = queue_of(1, size=5000)
        queue.open(opened(max_message_bytes=4096))
        self.assertTrue(queue.can_take_batch())
        with self.assertRaises(errors.ResourceExhaustedError) as raised:
            queue.take_batch()
        self.assertEqual(raised.exception.reason, "MESSAGE_TOO_LARGE")

    def test_carry_the_checksum_of_their_images(self):
        queue = UploadQueue(1 << 20, 8)
        message = frame_pb2.Frame()
        message.color.data, message.depth.data = b"c", b"a"
        message.labels.data, message.instances.data = b"b", b"i"
        queue.push(message)
        queue.push(frame(3))
        queue.open(opened())
        self.assertEqual(
            queue.take_batch().batch.images_crc32c, extend_crc32c(0, b"abic" + bytes(3))
        )


class Resuming(unittest.TestCase):
    def test_sends_again_what_is_not_durable(self):
        queue = queue_of(6, max_batch_frames=2)
        queue.open(opened())
        take_all(queue)
        queue.acknowledge(ack(DURABLE, 2))
        queue.open(opened(resume=3))
        self.assertEqual(take_all(queue), [(4, 2), (6, 1)])
        progress = queue.progress(1)
        self.assertEqual((progress.sent, progress.sent_again), (6, 3))

    def test_leaves_out_what_an_earlier_run_brought(self):
        queue = queue_of(2)
        queue.open(opened(resume=4))
        self.assertEqual((queue.buffered_bytes, queue.all_sent), (0, True))
        for _ in range(3):
            queue.push(frame())
        self.assertEqual(take_all(queue), [(5, 1)])

    def test_at_a_server_that_forgot_is_an_error(self):
        queue = queue_of(3)
        queue.open(opened())
        take_all(queue)
        queue.acknowledge(ack(DURABLE, 3))
        with self.assertRaises(errors.DataLossError):
            queue.open(opened(resume=2))


class Acknowledgements(unittest.TestCase):
    def test_free_memory_once_durable(self):
        queue = queue_of(3)
        queue.open(opened())
        take_all(queue)
        queue.acknowledge(ack(RECEIVED, 3))
        self.assertGreater(queue.buffered_bytes, 3000)
        queue.acknowledge(ack(DURABLE, 3))
        self.assertEqual(queue.buffered_bytes, 0)

    def test_count_refused_frames_once_and_nowhere_else(self):
        queue = queue_of(4)
        queue.open(opened())
        take_all(queue)
        queue.acknowledge(ack(DURABLE, 4, refused=[2, 3]))
        queue.acknowledge(ack(DURABLE, 4, refused=[3]))
        progress = queue.progress(0)
        self.assertEqual((progress.durable, progress.refused, progress.integrated), (2, 2, 0))
        queue.acknowledge(ack(INTEGRATED, 4, refused=[2], revision=9))
        progress = queue.progress(0)
        self.assertEqual((progress.integrated, progress.refused, progress.revision), (2, 2, 9))
        self.assertEqual([refused.index for refused in queue.refused], [1, 2])

    def test_never_go_back(self):
        queue = queue_of(4)
        queue.open(opened())
        take_all(queue)
        queue.acknowledge(ack(INTEGRATED, 4))
        queue.acknowledge(ack(DURABLE, 1))
        self.assertEqual(queue.progress(0).durable, 4)

    def test_of_frames_never_sent_are_an_error(self):
        queue = queue_of(4)
        queue.open(opened(credit_frames=2))
        take_all(queue)
        with self.assertRaises(errors.InternalError):
            queue.acknowledge(ack(DURABLE, 3))

    def test_keep_a_bounded_number_of_refusals(self):
        queue = queue_of(1500, size=1)
        queue.open(opened(credit_frames=2000))
        take_all(queue)
        queue.acknowledge(ack(DURABLE, 1500, refused=range(1, 1501)))
        self.assertEqual((len(queue.refused), queue.progress(0).refused), (1000, 1500))


if __name__ == "__main__":
    unittest.main()
