"""Uploads to a daemon."""

import socket
import threading
import unittest

import grpc
import numpy as np
from daemon_process import DaemonTest
from wall_frame import LOOK_ALONG_X, wall_frame

import steadymap
from steadymap import errors

IMPATIENT = steadymap.BackoffOptions(first_delay_s=0.01, max_delay_s=0.01, give_up_after_s=0.02)


def nan_frame(number):
    """Returns a frame with a non-finite position."""
    T_world_camera = LOOK_ALONG_X.copy()
    T_world_camera[1, 3] = np.nan
    return wall_frame(number, T_world_camera=T_world_camera)


class Upload(DaemonTest):
    def test_brings_every_frame_into_the_map(self):
        name = self.new_map()
        summary = self.client.upload(name, (wall_frame(i) for i in range(30)))
        self.assertEqual(summary.refused, [])
        self.assertEqual(summary.progress.integrated, 30)
        self.assertEqual(summary.progress.revision, 30)
        state = self.client.get_map(name)
        self.assertEqual((state.revision, state.lag_frames), (30, 0))
        self.assertEqual(state.last_capture_time_ns, wall_frame(29).capture_time_ns)

    def test_of_nothing_is_done_at_once(self):
        name = self.new_map()
        for level in steadymap.AckLevel:
            summary = self.client.upload(name, [], steadymap.UploadOptions(wait_for=level))
            self.assertEqual(summary.progress, steadymap.UploadProgress())

    def test_names_each_refused_frame_and_takes_the_others(self):
        frames = [wall_frame(i) for i in range(10)]
        frames[3] = nan_frame(3)
        frames[7] = wall_frame(7, labels=np.full((48, 64), 200, np.uint8))
        name = self.new_map()
        summary = self.client.upload(name, frames)
        self.assertEqual([refused.index for refused in summary.refused], [3, 7])
        pose, labels = (refused.error for refused in summary.refused)
        self.assertIsInstance(pose, errors.InvalidArgumentError)
        self.assertEqual(pose.reason, "NON_FINITE_POSE")
        self.assertRegex(pose.field, r"^frames\[\d\]\.world_from_camera")
        self.assertEqual(labels.reason, "LABEL_OUT_OF_RANGE")
        self.assertRegex(labels.field, r"^frames\[\d\]\.labels")
        progress = summary.progress
        self.assertEqual((progress.integrated, progress.refused), (8, 2))
        self.assertEqual(self.client.get_map(name).revision, 8)

    def test_refuses_hostile_frames_alone(self):
        hostile = [
            wall_frame(0, capture_time_ns=-1),
            wall_frame(1, intrinsics=steadymap.Intrinsics(64, 48, np.nan, 64.0, 31.5, 23.5)),
            wall_frame(2, T_world_camera=steadymap.Pose((1e9, 0, 0), (0, 0, 0, 1))),
            wall_frame(3, T_world_camera=steadymap.Pose((0, 0, 0), (0, 0, 0, 0))),
            wall_frame(4, depth=b"\x89PNG\r\n\x1a\n" + bytes(100)),
            wall_frame(5, color=b"\xff\xd8\xff" + bytes(100)),
        ]
        summary = self.client.upload(self.new_map(), [*hostile, wall_frame(6)])
        self.assertEqual([refused.index for refused in summary.refused], list(range(6)))
        for refused in summary.refused:
            self.assertIsInstance(refused.error, errors.InvalidArgumentError)
            self.assertNotEqual(refused.error.reason, "")
        self.assertEqual(summary.progress.integrated, 1)

    def test_waits_for_the_level_asked_for(self):
        for level in steadymap.AckLevel:
            name = f"level-{level.value}"
            self.client.create_map(name)
            options = steadymap.UploadOptions(wait_for=level)
            summary = self.client.upload(name, [wall_frame(i) for i in range(20)], options)
            self.assertEqual(getattr(summary.progress, level.value), 20)
            state = self.client.get_map(name)
            if level is not steadymap.AckLevel.RECEIVED:
                self.assertEqual(state.durable_map_seq, 20)
            if level is steadymap.AckLevel.INTEGRATED:
                self.assertEqual(state.revision, 20)

    def test_packs_pixels_without_loss_whatever_the_encoding(self):
        random = np.random.default_rng(4)
        frames = [
            wall_frame(
                i,
                depth=random.integers(1900, 2100, (48, 64), np.uint16),
                labels=random.integers(4, 9, (48, 64), np.uint8),
            )
            for i in range(4)
        ]
        meshes = []
        for encoding in steadymap.PixelEncoding:
            name = f"encoded-{encoding.value}"
            self.client.create_map(name)
            self.client.upload(name, frames, steadymap.UploadOptions(encoding=encoding))
            meshes.append(self.client.mesh(name))
        self.assertGreater(len(meshes[0].triangles), 100)
        for mesh in meshes[1:]:
            np.testing.assert_array_equal(mesh.vertices, meshes[0].vertices)
            np.testing.assert_array_equal(mesh.triangles, meshes[0].triangles)

    def test_takes_metres_wide_labels_instances_and_colour(self):
        color = np.empty((48, 64, 3), np.uint8)
        color[:] = (200, 100, 50)
        frame = wall_frame(
            depth=np.full((48, 64), 2.0, np.float32),
            labels=np.full((48, 64), 4, np.int64),
            instances=np.full((48, 64), 300, np.uint16),
            color=color,
        )
        name = self.new_map()
        self.assertEqual(self.client.upload(name, [frame] * 5).refused, [])
        mesh = self.client.mesh(name)
        np.testing.assert_allclose(mesh.vertices[:, 0], 2.0, atol=1e-3)
        expected = np.broadcast_to(color[0, 0], mesh.colors.shape)
        np.testing.assert_allclose(mesh.colors, expected, atol=3)

    def test_keeps_within_its_buffer(self):
        options = steadymap.UploadOptions(max_buffered_bytes=1, max_batch_frames=1)
        name = self.new_map()
        summary = self.client.upload(name, [wall_frame(i) for i in range(20)], options)
        self.assertEqual(summary.progress.integrated, 20)

    def test_to_a_map_that_is_not_there_fails(self):
        with self.assertRaises(errors.NotFoundError):
            self.client.upload("nowhere", [wall_frame()])

    def test_from_a_robot_with_a_bad_name_fails(self):
        with self.assertRaises(errors.InvalidArgumentError) as raised:
            options = steadymap.UploadOptions(robot="R 2")
            self.client.upload(self.new_map(), [wall_frame()], options)
        self.assertEqual(raised.exception.reason, "BAD_NAME")

    def test_gives_up_on_a_server_that_never_answers(self):
        retries, waits = [], []
        backoff = steadymap.BackoffOptions(
            first_delay_s=1.0, max_unanswered_delay_s=1.0, jitter=0.0, give_up_after_s=3.5
        )
        options = steadymap.UploadOptions(
            backoff=backoff,
            sleep=waits.append,  # Attempts take no time: only these delays count.
            on_retry=lambda error, delay_s: retries.append(error),
        )
        with socket.socket() as nobody:
            nobody.bind(("127.0.0.1", 0))  # Not listening: connections are refused.
            with steadymap.connect(f"127.0.0.1:{nobody.getsockname()[1]}") as client:
                with self.assertRaises(errors.UnavailableError):
                    client.upload("hall", [wall_frame()], options)
        self.assertEqual(waits, [1.0] * 4)
        self.assertEqual(len(retries), 4)
        for error in retries:
            self.assertIsInstance(error, errors.UnavailableError)


class _Cancelled(grpc.RpcError):
    def code(self):
        return grpc.StatusCode.CANCELLED

    def details(self):
        return "cancelled"

    def trailing_metadata(self):
        return ()


class _CallThatNeverEnds:
    """A call that ends only by cancellation."""

    def __init__(self):
        self._cancelled = threading.Event()

    def cancel(self):
        self._cancelled.set()

    def __iter__(self):
        return self

    def __next__(self):
        if not self._cancelled.wait(20.0):
            raise AssertionError("nobody cancelled the call")
        raise _Cancelled


class _LateChannel:
    """Sends all requests before it returns the call, as gRPC may on a busy machine."""

    def __enter__(self):
        return self

    def __exit__(self, *error):
        pass

    def unary_unary(self, method, **serializers):
        """Returns no response."""

    def stream_stream(self, method, **serializers):
        """Returns a function that makes a call of `method`."""

        def start(requests):
            for _ in requests:
                pass
            return _CallThatNeverEnds()

        return start


class AnUploadWhoseServerHangs(unittest.TestCase):
    def test_ends_if_its_time_is_over_before_there_is_a_call(self):
        options = steadymap.UploadOptions(open_timeout_s=0.01, backoff=IMPATIENT)
        with self.assertRaises(errors.DeadlineExceededError):
            uploader = steadymap.Uploader(_LateChannel, "tenants/default/maps/hall", options)
            uploader.push(wall_frame())
            uploader.finish()


class AnUploader(DaemonTest):
    def test_is_superseded_by_another_session_of_its_robot(self):
        name = self.new_map()
        durable = threading.Event()
        options = steadymap.UploadOptions(on_progress=lambda progress: durable.set())
        with self.assertRaises(errors.AbortedError) as raised:
            with self.client.uploader(name, options) as first:
                first.push(wall_frame(0))
                self.assertTrue(durable.wait(30.0))
                self.client.upload(name, [wall_frame(1)])
                first.finish()
        self.assertEqual(raised.exception.reason, "UPLOAD_SUPERSEDED")
        self.assertEqual(self.client.get_map(name).revision, 2)

    def test_takes_nothing_after_it_is_finished(self):
        with self.client.uploader(self.new_map()) as uploader:
            uploader.push(wall_frame())
            uploader.finish()
            with self.assertRaises(errors.FailedPreconditionError):
                uploader.push(wall_frame())
            self.assertEqual(uploader.finish().progress.integrated, 1)

    def test_finishes_at_the_end_of_its_block(self):
        name = self.new_map()
        with self.client.uploader(name) as uploader:
            uploader.push(wall_frame())
        self.assertEqual(self.client.get_map(name).revision, 1)

    def test_gives_up_where_its_block_raises(self):
        with self.assertRaises(ZeroDivisionError):
            with self.client.uploader(self.new_map()) as uploader:
                uploader.push(wall_frame())
                raise ZeroDivisionError
        with self.assertRaises((errors.CancelledError, errors.FailedPreconditionError)):
            uploader.push(wall_frame())

    def test_raises_what_a_callback_raised(self):
        def fail(progress):
            raise KeyError("of the callback")

        options = steadymap.UploadOptions(on_progress=fail)
        with self.assertRaisesRegex(KeyError, "of the callback"):
            self.client.upload(self.new_map(), [wall_frame()], options)

    def test_goes_on_where_a_process_of_the_same_session_stopped(self):
        name = self.new_map()
        options = steadymap.UploadOptions(session="named", robot="forklift")
        frames = [wall_frame(i) for i in range(20)]
        self.client.upload(name, frames[:12], options)
        summary = self.client.upload(name, frames, options)
        self.assertEqual(summary.progress.integrated, 20)
        self.assertEqual(self.client.get_map(name).revision, 20)
        repeated = self.client.upload(name, frames, options).progress
        self.assertEqual((repeated.sent, repeated.integrated, repeated.revision), (0, 20, 20))


if __name__ == "__main__":
    unittest.main()
