"""Objects and their history, from a map with the policy POCD."""

import math
import unittest
from unittest import mock

import numpy as np
from daemon_process import DaemonTest
from wall_frame import wall_frame

import steadymap
from steadymap import client as client_module
from steadymap._generated.v1 import event_pb2, object_pb2
from steadymap.objects import event_from_proto, object_from_proto

BOX_CLASS = 7
BOX_SIZE_M = 0.5
BOX_DISTANCE_M = 1.5


def room_frame(number, boxes_m):
    """Returns a wall at 2.5 m and squares of the class goods at 1.5 m, centred at these y."""
    frame = wall_frame(number, distance_m=2.5, width_px=160, height_px=120)
    depth, labels = frame.depth, frame.labels
    columns, rows = np.meshgrid(np.arange(160), np.arange(120))
    y = -(columns - 79.5) * BOX_DISTANCE_M / 160.0
    z = -(rows - 59.5) * BOX_DISTANCE_M / 160.0
    for center_m in boxes_m:
        inside = (abs(y - center_m) <= BOX_SIZE_M / 2) & (abs(z) <= BOX_SIZE_M / 2)
        depth[inside] = round(BOX_DISTANCE_M * 1000)
        labels[inside] = BOX_CLASS
    return frame


class ARoom(DaemonTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.client.create_map("room", steadymap.MapOptions(policy="pocd"))
        frames = [room_frame(i, (-0.4, 0.4)) for i in range(20)]
        frames += [room_frame(i, (-0.4,)) for i in range(1000, 1040)]
        summary = cls.client.upload("room", frames)
        assert not summary.refused, summary.refused

    def boxes(self, **filters):
        return list(self.client.objects("room", class_ids=[BOX_CLASS], **filters))

    def test_shows_the_box_that_stands(self):
        (box,) = self.boxes()
        self.assertEqual(box.standing, steadymap.ObjectStanding.PRESENT)
        np.testing.assert_allclose(box.cuboid.center_m[1:], (-0.4, 0.0), atol=0.06)
        self.assertAlmostEqual(box.cuboid.center_m[0], BOX_DISTANCE_M, delta=0.15)
        sides = sorted(box.cuboid.size_m)[1:]
        np.testing.assert_allclose(sides, BOX_SIZE_M, atol=0.12)
        self.assertEqual(max(box.votes, key=box.votes.get), BOX_CLASS)
        share = box.votes[BOX_CLASS] / sum(box.votes.values())
        self.assertAlmostEqual(box.class_confidence, share)
        self.assertGreater(box.stationarity, 0.5)
        self.assertAlmostEqual(box.stationarity, box.belief.stationarity)
        self.assertEqual(box.first_seen_ns, room_frame(0, ()).capture_time_ns)
        self.assertEqual(box.T_world_object.shape, (4, 4))
        self.assertEqual(self.client.get_object("room", box.id).id, box.id)

    def test_remembers_the_box_that_went(self):
        (gone,) = [
            box
            for box in self.boxes(include_archived=True)
            if box.standing is steadymap.ObjectStanding.ARCHIVED
        ]
        self.assertAlmostEqual(gone.cuboid.center_m[1], 0.4, delta=0.06)
        created, removed = (
            [event for event in self.client.events("room", types=[kind], object_ids=[gone.id])]
            for kind in ("created", steadymap.EventType.REMOVED)
        )
        self.assertEqual((len(created), len(removed)), (1, 1))
        self.assertLess(created[0].number, removed[0].number)
        self.assertGreaterEqual(removed[0].capture_time_ns, room_frame(1000, ()).capture_time_ns)
        self.assertEqual(removed[0].class_id, BOX_CLASS)
        self.assertEqual(removed[0].reason, steadymap.EventReason.SEEN_THROUGH)
        self.assertLess(removed[0].after.stationarity, created[0].after.stationarity)
        self.assertIsNone(removed[0].old_center_m)
        self.assertIsNone(removed[0].confidence)

    def test_filters_objects(self):
        (box,) = self.boxes()
        around = (box.cuboid.center_m - 0.1, box.cuboid.center_m + 0.1)
        elsewhere = (box.cuboid.center_m + 5.0, box.cuboid.center_m + 6.0)
        self.assertEqual(len(self.boxes(box=around)), 1)
        self.assertEqual(self.boxes(box=elsewhere), [])
        self.assertEqual(self.boxes(min_stationarity=1.0), [])
        self.assertEqual(self.boxes(changed_since=box.revision), [])

    def test_pages_are_joined(self):
        whole = [event.number for event in self.client.events("room")]
        ids = [thing.id for thing in self.client.objects("room", include_archived=True)]
        with mock.patch.object(client_module, "_EVENTS_PER_PAGE", 1), mock.patch.object(
            client_module, "_OBJECTS_PER_PAGE", 1
        ):
            events = self.client.events("room")
            self.assertEqual([event.number for event in events], whole)
            self.assertEqual(events.revision, self.client.get_map("room").revision)
            objects = self.client.objects("room", include_archived=True)
            self.assertEqual([thing.id for thing in objects], ids)
        self.assertEqual(whole, list(range(1, len(whole) + 1)))
        self.assertGreater(len(whole), 2)
        self.assertEqual(ids, sorted(ids))

    def test_filters_events_by_their_time(self):
        times = [event.capture_time_ns for event in self.client.events("room")]
        first, last = min(times), max(times)
        self.assertLess(first, last)
        before = self.client.events("room", start_time_ns=first, end_time_ns=last)
        self.assertEqual([e.capture_time_ns for e in before], [t for t in times if t < last])
        after = self.client.events("room", start_time_ns=last)
        self.assertEqual([e.capture_time_ns for e in after], [t for t in times if t >= last])

    def test_shows_what_the_camera_looked_through_as_free(self):
        axis = [(x, 0.0, 0.0) for x in (0.5, -1.0)]
        states = self.client.sample_distance("room", axis).state.tolist()
        self.assertEqual(states, [steadymap.PointState.FREE, steadymap.PointState.UNKNOWN])
        hits = self.client.cast_rays("room", (0.4, 0.0, 0.0), (1.0, 0.0, 0.0), max_range_m=0.2)
        self.assertEqual(hits.state.tolist(), [steadymap.PointState.FREE])
        self.assertAlmostEqual(hits.free_until_m[0], 0.2)
        away = self.client.cast_rays("room", (0.4, 0.0, 0.0), (-1.0, 0.0, 0.0), max_range_m=9.0)
        self.assertEqual(away.state.tolist(), [steadymap.PointState.UNKNOWN])
        self.assertLess(away.free_until_m[0], 0.5)

    def test_samples_name_the_object(self):
        (box,) = self.boxes()
        samples = self.client.sample_distance("room", (BOX_DISTANCE_M - 0.02, -0.4, 0.0))
        self.assertEqual((samples.object_id[0], samples.class_id[0]), (box.id, BOX_CLASS))
        hits = self.client.cast_rays("room", (0, 0, 0), (BOX_DISTANCE_M, -0.4, 0.0))
        self.assertEqual(hits.object_id[0], box.id)

    def test_events_of_an_unknown_type_are_refused_here(self):
        with self.assertRaises(ValueError):
            self.client.events("room", types=["vanished"])


class ARoomOfTwoOpinions(DaemonTest):
    def test_shows_who_says_what(self):
        name = self.new_map(steadymap.MapOptions(policy="pocd"))
        for i in range(3):
            for robot, boxes_m in (("seer", (0.0,)), ("doubter", ())):
                first = 40 * (2 * i + (robot == "doubter"))
                frames = [room_frame(first + k, boxes_m) for k in range(20)]
                self.client.upload(name, frames, steadymap.UploadOptions(robot=robot))
        (box,) = self.client.objects(name, class_ids=[BOX_CLASS])
        (contradiction,) = box.contradictions
        self.assertEqual(contradiction.present, ("seer", "camera"))
        self.assertEqual(contradiction.absent, ("doubter", "camera"))
        self.assertEqual(contradiction.sessions, 3)
        self.assertLess(contradiction.since_ns, contradiction.last_ns)
        (event,) = self.client.events(name, types=["contradicted"])
        self.assertEqual((event.object_id, event.robot), (box.id, "doubter"))
        doubter, seer = self.client.robots(name)
        for robot, other in ((doubter, seer), (seer, doubter)):
            (found,) = robot.contradictions
            self.assertEqual((found.robot, found.sensor), (other.robot, other.sensor))
            self.assertEqual((found.objects, found.since_ns), (1, contradiction.since_ns))


class FromProto(unittest.TestCase):
    def test_knows_every_enumerator_of_the_wire(self):
        for kind, prefix, known in (
            (event_pb2.EventType, "EVENT_TYPE_", steadymap.EventType),
            (event_pb2.EventReason, "EVENT_REASON_", steadymap.EventReason),
            (object_pb2.ObjectStanding, "OBJECT_STANDING_", steadymap.ObjectStanding),
        ):
            names = [
                name[len(prefix) :].lower() for name, _ in sorted(kind.items(), key=lambda i: i[1])
            ]
            self.assertEqual([entry.value for entry in known], names)

    def test_takes_types_of_a_newer_server_as_unspecified(self):
        event = event_from_proto(event_pb2.ObjectEvent(type=99, reason=99, robot="r"))
        self.assertEqual(event.type, steadymap.EventType.UNSPECIFIED)
        self.assertEqual(event.reason, steadymap.EventReason.UNSPECIFIED)
        self.assertIsNone(event.before)
        self.assertIsNone(event.capture_time_ns)

    def test_places_the_corners_of_a_turned_cuboid(self):
        message = object_pb2.Object(id=1)
        message.cuboid.size_m.x, message.cuboid.size_m.y, message.cuboid.size_m.z = (4.0, 2.0, 1.0)
        message.cuboid.center_m.x = 10.0
        message.cuboid.yaw_rad = math.pi / 2
        corners = object_from_proto(message).cuboid.corners_m()
        np.testing.assert_allclose(corners[0], (11.0, -2.0, -0.5), atol=1e-12)
        np.testing.assert_allclose(corners.min(axis=0), (9.0, -2.0, -0.5), atol=1e-12)
        np.testing.assert_allclose(corners.max(axis=0), (11.0, 2.0, 0.5), atol=1e-12)

    def test_turns_an_upright_pose_into_a_matrix(self):
        message = object_pb2.Object()
        message.world_from_object.position_m.x = 3.0
        message.world_from_object.yaw_rad = math.pi / 2
        T_world_object = object_from_proto(message).T_world_object
        np.testing.assert_allclose(T_world_object @ (1, 0, 0, 1), (3, 1, 0, 1), atol=1e-12)


if __name__ == "__main__":
    unittest.main()
