"""Changes of maps on a daemon, and concurrent changes."""

import shutil
import tempfile
import unittest
from pathlib import Path

from daemon_process import DaemonProcess, DaemonTest

import steadymap
from steadymap import errors
from steadymap._generated.v1 import map_pb2
from steadymap.map_change import MapChange, change_map

NOTHING = {
    "labels": {},
    "removed_labels": (),
    "world_frame": None,
    "display_name": None,
    "byte_budget": None,
    "classes": (),
    "etag": None,
}
FRAME = steadymap.WorldFrame("Gate 3", "2", steadymap.GeoAnchor(47.37, 8.54, 410.0, 90.0))
BOX = steadymap.SemanticClass(7, "box", "semi_static")


class AMap(DaemonTest):
    def test_keeps_its_labels_and_its_world_frame(self):
        options = steadymap.MapOptions(labels={"site": "north"}, world_frame=FRAME)
        name = self.new_map(options)
        created = self.client.get_map(name)
        self.assertEqual(created.options.labels, {"site": "north"})
        self.assertEqual(created.options.world_frame, FRAME)
        self.assertIs(created.condition, steadymap.MapCondition.READY)
        self.assertEqual((created.condition_reason, created.integrated_map_seq), ("", 0))

    def test_without_a_world_frame_has_an_empty_one(self):
        self.assertEqual(
            self.client.get_map(self.new_map()).options.world_frame, steadymap.WorldFrame()
        )

    def test_changes_in_what_is_named_alone(self):
        labels = {"site": "north", "shift": "day"}
        name = self.new_map(steadymap.MapOptions(labels=labels, world_frame=FRAME))
        etag = self.client.get_map(name).etag
        changed = self.client.update_map(
            name, labels={"shift": "", "a": "1"}, remove_labels=["site", "never-there"]
        )
        self.assertEqual(changed.options.labels, {"shift": "", "a": "1"})
        self.assertEqual(changed.options.world_frame, FRAME)
        self.assertNotEqual(changed.etag, etag)
        changed = self.client.update_map(name, world_frame="Gate 4", display_name="Depot")
        expected = steadymap.WorldFrame("Gate 4", FRAME.floor, FRAME.anchor)
        self.assertEqual(changed.options.world_frame, expected)
        self.assertEqual(changed.options.display_name, "Depot")
        self.assertEqual(changed.options.labels, {"shift": "", "a": "1"})
        changed = self.client.update_map(name, world_frame=steadymap.WorldFrame(), byte_budget=9)
        self.assertEqual(changed.options.world_frame, steadymap.WorldFrame())
        self.assertEqual(changed.options.byte_budget, 9)
        self.assertEqual(self.client.get_map(name), changed)

    def test_takes_more_classes_and_changes_none(self):
        name = self.new_map(steadymap.MapOptions(classes=[BOX]))
        person = steadymap.SemanticClass(9, "person", "dynamic")
        for _ in range(2):
            changed = self.client.update_map(name, add_classes=[BOX, person])
            self.assertEqual(changed.options.classes, (BOX, person))
        with self.assertRaises(errors.InvalidArgumentError) as raised:
            self.client.update_map(name, add_classes=[steadymap.SemanticClass(7, "crate")])
        self.assertEqual(raised.exception.field, "map.config.classes")
        self.assertIn("class 7", raised.exception.message)
        self.assertEqual(self.client.get_map(name).options.classes, (BOX, person))

    def test_refuses_what_cannot_be(self):
        name = self.new_map()
        with self.assertRaises(errors.InvalidArgumentError) as raised:
            self.client.update_map(name, labels={"Site": "north"})
        self.assertEqual(raised.exception.field, "map.labels")
        with self.assertRaises(errors.InvalidArgumentError) as raised:
            self.client.update_map(name, world_frame="w" * 513)
        self.assertEqual(raised.exception.field, "map.world_frame.description")
        with self.assertRaises(errors.InvalidArgumentError):
            self.client.create_map("labelled", steadymap.MapOptions(labels={"1": ""}))
        with self.assertRaisesRegex(ValueError, "at least one change"):
            self.client.update_map(name)
        with self.assertRaises(errors.NotFoundError):
            self.client.update_map("nowhere", labels={"a": "1"})

    def test_is_guarded_by_its_etag(self):
        name = self.new_map()
        etag = self.client.get_map(name).etag
        self.client.update_map(name, labels={"a": "1"}, etag=etag)
        with self.assertRaises(errors.AbortedError) as raised:
            self.client.update_map(name, labels={"a": "2"}, etag=etag)
        self.assertEqual(raised.exception.reason, "ETAG_MISMATCH")
        self.assertEqual(self.client.get_map(name).options.labels, {"a": "1"})


class ADamagedMap(unittest.TestCase):
    def test_is_listed_with_the_reason(self):
        with tempfile.TemporaryDirectory() as folder:
            daemon = DaemonProcess(Path(folder))
            self.addCleanup(daemon.kill)
            with steadymap.connect(daemon.address) as client:
                client.create_map("hall")
            daemon.kill()
            for map_folder in (Path(folder) / "data" / "maps").iterdir():
                shutil.rmtree(map_folder)
            daemon.restart()
            with steadymap.connect(daemon.address) as client:
                (damaged,) = client.list_maps()
                with self.assertRaises(errors.DataLossError):
                    client.update_map("hall", labels={"a": "1"})
            daemon.kill()
        self.assertEqual(damaged.name, "tenants/default/maps/hall")
        self.assertIs(damaged.condition, steadymap.MapCondition.DAMAGED)
        self.assertIn("is missing", damaged.condition_reason)


class AChange(unittest.TestCase):
    """Changes of a map in this process, with the etags and request ids of the contract."""

    def setUp(self):
        self.map = map_pb2.Map(name="tenants/default/maps/hall", labels={"old": "1"}, etag="1")
        self.requests = []
        self.answers_to_lose = 0
        self.others = 0

    def send(self, request):
        if self.others > 0:
            self.others -= 1
            self.change_state({f"theirs-{self.others}": "3"})
        if not (self.requests and self.requests[-1].request_id == request.request_id):
            if request.map.etag != self.map.etag:
                raise errors.AbortedError("another state", reason="ETAG_MISMATCH")
            self.map.labels.clear()
            self.change_state(request.map.labels)
        self.requests.append(request)
        if self.answers_to_lose > 0:
            self.answers_to_lose -= 1
            raise errors.UnavailableError("connection reset")
        return self.map

    def change_state(self, labels):
        self.map.labels.update(labels)
        self.map.etag = str(int(self.map.etag) + 1)

    def change(self, **change):
        return change_map(
            MapChange(**{**NOTHING, **change}), lambda: self.map, self.send, lambda delay_s: None
        )

    def test_whose_answer_is_lost_is_sent_again_and_counts_once(self):
        self.answers_to_lose = 2
        self.change(labels={"new": "2"})
        self.assertEqual(len({request.request_id for request in self.requests}), 1)
        self.assertEqual(len(self.requests), 3)
        self.assertEqual(self.map.etag, "2")
        self.assertEqual(self.map.labels, {"old": "1", "new": "2"})

    def test_that_is_never_answered_is_given_up(self):
        self.answers_to_lose = 1_000_000
        with self.assertRaises(errors.UnavailableError):
            self.change(labels={"new": "2"})
        self.assertGreater(len(self.requests), 1)

    def test_keeps_those_of_others_in_between(self):
        self.others = 2
        self.change(labels={"new": "2"}, removed_labels=["old"])
        self.assertEqual(self.map.labels, {"theirs-0": "3", "theirs-1": "3", "new": "2"})

    def test_of_a_map_that_never_rests_ends(self):
        self.others = 1_000_000
        with self.assertRaises(errors.AbortedError):
            self.change(labels={"new": "2"})
        self.assertEqual(self.requests, [])


if __name__ == "__main__":
    unittest.main()
