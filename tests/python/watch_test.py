"""Watches of a scripted server and of the daemon."""

import asyncio
import dataclasses
import tempfile
import threading
import unittest
from pathlib import Path

import grpc
from daemon_process import DaemonProcess
from objects_test import room_frame
from watch_service_double import (
    WatchServiceDouble,
    created,
    delta,
    events,
    goodbye,
    progress,
    resync,
    snapshot,
    with_token,
)

import steadymap
from steadymap import errors
from steadymap._generated.v1 import watch_service_pb2

UNAVAILABLE = grpc.StatusCode.UNAVAILABLE
QUICK = steadymap.BackoffOptions(first_delay_s=0.001, max_delay_s=0.01, give_up_after_s=60.0)

# One for all tests: gRPC's asyncio supports one event loop per process.
_runner = asyncio.Runner()
unittest.addModuleCleanup(_runner.close)


def brief(item):
    """Returns a summary of an item."""
    kind = type(item).__name__
    if isinstance(item, steadymap.Snapshot):
        return (kind, item.revision, *(thing.id for thing in item.objects))
    if isinstance(item, steadymap.Delta):
        removed = tuple(-object_id for object_id in item.removed_object_ids)
        return (kind, item.revision, *removed, *(thing.id for thing in item.objects))
    if isinstance(item, steadymap.Events):
        return (kind, item.revision, *(event.number for event in item.events))
    return (kind, item.revision)


def follow(address, count, options):
    """Returns summaries of the first `count` items of a watch."""
    with steadymap.connect(address) as client, client.watch("hall", options) as watch:
        return [brief(next(watch)) for _ in range(count)]


def follow_asynchronously(address, count, options):
    """Returns summaries of the first `count` items of an asyncio watch."""

    async def collect():
        items = []
        with steadymap.connect(address) as client:
            iteration = client.watch_async("hall", options)
            while len(items) < count:
                items.append(brief(await iteration.__anext__()))
            await iteration.aclose()
        return items

    return _runner.run(collect())


class AScriptedWatch(unittest.TestCase):
    """Every expectation holds for both kinds of iteration."""

    def check(self, scripts, expected, **options):
        """Plays the scripts, expects the items, and returns the requests of the last round."""
        for way in (follow, follow_asynchronously):
            with self.subTest(way=way.__name__):
                server = WatchServiceDouble(*scripts)
                self.addCleanup(server.stop)
                self.retries = []
                watch_options = steadymap.WatchOptions(
                    backoff=QUICK,
                    on_retry=lambda error, delay_s: self.retries.append((error, delay_s)),
                    **options,
                )
                items = way(server.address, len(expected), watch_options)
                self.assertEqual(items, expected)
        return server.requests

    def test_yields_a_snapshot_and_steps(self):
        script = [created(3), snapshot(3, 1, 2), snapshot(3, 4), progress(3)]
        script += [delta(5, 3, 2, removed=[1]), events(5, 7, 8), progress(5)]
        self.check(
            [script],
            [
                ("Created", 3),
                ("Snapshot", 3, 1, 2),
                ("Snapshot", 3, 4),
                ("Progress", 3),
                ("Delta", 5, -1, 2),
                ("Events", 5, 7, 8),
                ("Progress", 5),
            ],
        )

    def test_goes_on_behind_the_last_token_and_repeats_nothing(self):
        first = [created(3), progress(3), delta(4, 3, 9), events(4, 1), UNAVAILABLE]
        second = [created(3), delta(4, 3, 9), events(4, 1), progress(4), UNAVAILABLE]
        third = [created(4), events(6, 2), progress(6)]
        requests = self.check(
            [first, second, third],
            [
                ("Created", 3),
                ("Progress", 3),
                ("Delta", 4, 9),
                ("Events", 4, 1),
                ("Progress", 4),
                ("Events", 6, 2),
                ("Progress", 6),
            ],
        )
        self.assertEqual([r.resume_token for r in requests], [b"", b"token-3", b"token-4"])
        self.assertEqual(requests[1].start, watch_service_pb2.WATCH_START_UNSPECIFIED)
        self.assertEqual(len(self.retries), 2)

    def test_begins_a_snapshot_anew_that_was_cut(self):
        self.check(
            [
                [created(3), snapshot(3, 1), UNAVAILABLE],
                [created(4), snapshot(4, 1, 2), progress(4)],
            ],
            [
                ("Created", 3),
                ("Snapshot", 3, 1),
                ("Created", 4),
                ("Snapshot", 4, 1, 2),
                ("Progress", 4),
            ],
        )

    def test_goes_on_within_a_snapshot_that_was_cut(self):
        requests = self.check(
            [
                [created(3), with_token(snapshot(3, 1), b"p1"), UNAVAILABLE],
                [UNAVAILABLE],
                [created(3, continues_step=True), with_token(snapshot(3, 2), b"p2"), UNAVAILABLE],
                [created(3, continues_step=True), progress(3)],
            ],
            [("Created", 3), ("Snapshot", 3, 1), ("Snapshot", 3, 2), ("Progress", 3)],
        )
        self.assertEqual([r.resume_token for r in requests], [b"", b"p1", b"p1", b"p2"])

    def test_begins_a_snapshot_anew_that_is_gone(self):
        requests = self.check(
            [
                [created(3), with_token(snapshot(3, 1), b"p1"), UNAVAILABLE],
                [created(4), snapshot(4, 2), UNAVAILABLE],
                [created(5), snapshot(5, 2), progress(5)],
            ],
            [
                ("Created", 3),
                ("Snapshot", 3, 1),
                ("Created", 4),
                ("Snapshot", 4, 2),
                ("Created", 5),
                ("Snapshot", 5, 2),
                ("Progress", 5),
            ],
        )
        self.assertEqual([r.resume_token for r in requests], [b"", b"p1", b""])

    def test_goes_on_within_a_step_that_was_cut_and_repeats_nothing(self):
        first = [created(3), progress(3), with_token(delta(4, 3, 9), b"p1"), UNAVAILABLE]
        second = [created(3, continues_step=True), with_token(events(4, 1), b"p2"), UNAVAILABLE]
        third = [created(3, continues_step=True), progress(4), UNAVAILABLE]
        fourth = [created(4), events(6, 2), progress(6)]
        requests = self.check(
            [first, second, third, fourth],
            [
                ("Created", 3),
                ("Progress", 3),
                ("Delta", 4, 9),
                ("Events", 4, 1),
                ("Progress", 4),
                ("Events", 6, 2),
                ("Progress", 6),
            ],
        )
        self.assertEqual([r.resume_token for r in requests], [b"", b"p1", b"p2", b"token-4"])

    def test_takes_a_step_from_its_beginning_that_cannot_be_gone_on_with(self):
        part = with_token(delta(4, 3, 9), b"p1")
        requests = self.check(
            [
                [created(3), progress(3), part, UNAVAILABLE],
                [created(3, continues_step=True), grpc.StatusCode.ABORTED],
                [created(3), part, UNAVAILABLE],
                [created(3), part, progress(4)],
            ],
            [("Created", 3), ("Progress", 3), ("Delta", 4, 9), ("Progress", 4)],
        )
        self.assertEqual([r.resume_token for r in requests], [b"", b"p1", b"token-3", b"p1"])

    def test_tells_of_a_gap_in_the_history(self):
        requests = self.check(
            [
                [created(3), progress(3), UNAVAILABLE],
                [created(9), resync(9), snapshot(9, 5), UNAVAILABLE],
                [created(9), resync(9), snapshot(9, 5), progress(9)],
            ],
            [
                ("Created", 3),
                ("Progress", 3),
                ("Resync", 9),
                ("Snapshot", 9, 5),
                ("Resync", 9),
                ("Snapshot", 9, 5),
                ("Progress", 9),
            ],
        )
        self.assertTrue(requests[0].resync_if_compacted)

    def test_resumes_from_a_token_of_another_process(self):
        requests = self.check(
            [[created(3), events(4, 1), progress(4)]],
            [("Events", 4, 1), ("Progress", 4)],
            resume_token=b"kept",
        )
        self.assertEqual(requests[0].resume_token, b"kept")

    def test_waits_as_long_as_a_parting_server_asks(self):
        self.check(
            [[created(3), progress(3), goodbye(50), UNAVAILABLE], [created(3), progress(4)]],
            [("Created", 3), ("Progress", 3), ("Progress", 4)],
        )
        self.assertGreaterEqual(self.retries[0][1], 0.05)
        self.assertIsInstance(self.retries[0][0], errors.UnavailableError)

    def test_raises_what_does_not_heal(self):
        for way in (follow, follow_asynchronously):
            server = WatchServiceDouble([grpc.StatusCode.OUT_OF_RANGE])
            self.addCleanup(server.stop)
            with self.assertRaises(errors.OutOfRangeError):
                way(server.address, 1, steadymap.WatchOptions(resync_if_compacted=False))
            self.assertFalse(server.requests[0].resync_if_compacted)

    def test_sends_its_filter(self):
        requests = self.check(
            [[created(1)]],
            [("Created", 1)],
            start="now",
            kinds=["volumes", steadymap.WatchKind.EVENTS],
            boxes=[((0, 0, 0), (1, 2, 3))],
            class_ids=[7],
            object_ids=[1, 2],
            include_archived=True,
            max_message_bytes=65536,
        )
        (request,) = requests
        kinds = [watch_service_pb2.WATCH_KIND_VOLUMES, watch_service_pb2.WATCH_KIND_EVENTS]
        self.assertEqual(request.map, "tenants/default/maps/hall")
        self.assertEqual(request.start, watch_service_pb2.WATCH_START_NOW)
        self.assertEqual(list(request.filter.kinds), kinds)
        self.assertEqual(request.filter.boxes[0].max_m.z, 3.0)
        self.assertEqual(list(request.filter.class_ids), [7])
        self.assertEqual(list(request.filter.object_ids), [1, 2])
        self.assertTrue(request.filter.include_archived)
        self.assertEqual(request.max_message_bytes, 65536)

    def test_ends_when_it_is_closed_by_another_thread(self):
        server = WatchServiceDouble([created(1), progress(1)])
        self.addCleanup(server.stop)
        with steadymap.connect(server.address) as client:
            watch = client.watch("hall")
            seen = []
            ended = threading.Event()

            def read():
                for item in watch:
                    seen.append(brief(item))
                    if isinstance(item, steadymap.Progress):
                        read_all.set()
                ended.set()

            read_all = threading.Event()
            thread = threading.Thread(target=read)
            thread.start()
            self.assertTrue(read_all.wait(30.0))
            watch.close()
            self.assertTrue(ended.wait(30.0))
            thread.join()
        self.assertEqual(seen, [("Created", 1), ("Progress", 1)])
        self.assertEqual(watch.resume_token, b"token-1")

    def test_without_kinds_is_refused_here(self):
        with self.assertRaisesRegex(ValueError, "kinds: expected"):
            steadymap.WatchOptions(kinds=[])

    def test_patches_from_now_on_are_refused_here(self):
        with self.assertRaisesRegex(ValueError, "takes_patches: "):
            steadymap.WatchOptions(start="now", takes_patches=True)


class AWatchOfADaemon(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.daemon = DaemonProcess(Path(folder.name))
        self.addCleanup(self.daemon.kill)
        self.client = steadymap.connect(self.daemon.address)
        self.addCleanup(self.client.close)
        self.client.create_map("hall", steadymap.MapOptions(policy="pocd"))

    def read_up_to(self, watch, revision):
        """Returns the items up to the Progress that reaches the revision."""
        items = []
        for item in watch:
            items.append(item)
            if isinstance(item, steadymap.Progress) and item.revision >= revision:
                return items
        self.fail("the watch ended")

    def apply(self, items, objects, numbers):
        """Updates a copy of the objects and the numbers of the events."""
        for item in items:
            if isinstance(item, (steadymap.Created, steadymap.Resync)):
                objects.clear()
            if isinstance(item, steadymap.Delta):
                for object_id in item.removed_object_ids:
                    objects.pop(object_id, None)
            if isinstance(item, (steadymap.Snapshot, steadymap.Delta)):
                objects.update({thing.id: thing for thing in item.objects})
            if isinstance(item, steadymap.Events):
                numbers.extend(event.number for event in item.events)

    def assert_mirrors(self, objects):
        for thing in self.client.objects("hall"):
            self.assertEqual(objects.pop(thing.id).revision, thing.revision)
        self.assertEqual(objects, {})

    def test_sees_what_the_map_tells_over_a_kill(self):
        both = [room_frame(i, (-0.4, 0.4)) for i in range(20)]
        one = [room_frame(i, (-0.4,)) for i in range(1000, 1040)]
        objects, numbers = {}, []
        with self.client.watch("hall", steadymap.WatchOptions(backoff=QUICK)) as watch:
            self.assertIsInstance(next(watch), steadymap.Created)
            self.client.upload("hall", both)
            self.apply(self.read_up_to(watch, 20), objects, numbers)
            self.assert_mirrors(dict(objects))
            self.daemon.kill()
            self.daemon.restart()
            self.client.upload("hall", one)
            self.apply(self.read_up_to(watch, 60), objects, numbers)
            self.assert_mirrors(objects)
        told = [event.number for event in self.client.events("hall")]
        self.assertEqual(numbers, told)
        self.assertGreater(len(told), 2)

    def test_goes_on_from_a_token_in_another_client(self):
        with self.client.watch("hall", steadymap.WatchOptions(backoff=QUICK)) as watch:
            self.client.upload("hall", [room_frame(i, (0.4,)) for i in range(10)])
            end = self.client.get_map("hall").revision
            self.read_up_to(watch, end)
            token = watch.resume_token
        self.client.upload("hall", [room_frame(i, (0.4,)) for i in range(10, 30)])
        options = steadymap.WatchOptions(resume_token=token)
        with steadymap.connect(self.daemon.address) as client:
            with client.watch("hall", options) as watch:
                items = self.read_up_to(watch, self.client.get_map("hall").revision)
        deltas = [item for item in items if isinstance(item, steadymap.Delta)]
        self.assertEqual(deltas[0].previous_revision, end)
        self.assertFalse(any(isinstance(item, steadymap.Created) for item in items))

    def test_brings_leaves_where_volumes_are_asked_for(self):
        self.client.upload("hall", [room_frame(i, (0.4,)) for i in range(10)])
        with self.client.watch("hall", steadymap.WatchOptions(kinds=["volumes"])) as watch:
            items = self.read_up_to(watch, 10)
        leaves = [leaf for item in items[1:-1] for leaf in item.leaves]
        state = self.client.get_map("hall")
        self.assertEqual(len(leaves), state.leaves)
        self.assertTrue(all((leaf.origin % 8 == 0).all() and leaf.packed for leaf in leaves))

    def test_brings_patches_where_they_are_asked_for(self):
        self.client.create_map("store", steadymap.MapOptions(policy="static"))
        self.client.upload("store", [room_frame(i, (0.4,)) for i in range(10)])
        for takes_patches in (False, True):
            options = steadymap.WatchOptions(kinds=["volumes"], takes_patches=takes_patches)
            known = self.client.get_map("store").revision
            with self.client.watch("store", options) as watch:
                self.read_up_to(watch, known)
                more = [room_frame(i, (0.4,)) for i in range(known, known + 3)]
                self.client.upload("store", more)
                items = self.read_up_to(watch, known + 3)
            deltas = [item for item in items if isinstance(item, steadymap.Delta)]
            leaves = [leaf for delta in deltas for leaf in delta.leaves]
            self.assertEqual(any(leaf.is_patch for leaf in leaves), takes_patches)
            self.assertIsNotNone(items[-1].last_capture_time_ns)

    def test_of_a_map_that_is_not_there_is_not_found(self):
        with self.assertRaises(errors.NotFoundError):
            next(self.client.watch("nowhere"))

    def test_with_a_token_of_another_filter_is_resynced_or_refused(self):
        with self.client.watch("hall", steadymap.WatchOptions(kinds=["events"])) as watch:
            self.client.upload("hall", [room_frame(0, ())])
            end = self.client.get_map("hall").revision
            self.read_up_to(watch, end)
            token = watch.resume_token
        options = steadymap.WatchOptions(kinds=["objects"], resume_token=token)
        with self.client.watch("hall", options) as watch:
            self.assertEqual(next(watch), steadymap.Resync(end, "BAD_RESUME_TOKEN"))
        strict = dataclasses.replace(options, resync_if_compacted=False)
        with self.assertRaises(errors.InvalidArgumentError) as raised:
            next(self.client.watch("hall", strict))
        self.assertEqual(raised.exception.reason, "BAD_RESUME_TOKEN")


if __name__ == "__main__":
    unittest.main()
