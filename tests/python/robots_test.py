"""Robots that maps know."""

import unittest

import numpy as np
from daemon_process import DaemonTest
from wall_frame import wall_frame

import steadymap
from steadymap import errors
from steadymap._generated.v1 import robot_pb2
from steadymap.robots import robot_from_proto


class AMap(DaemonTest):
    def test_lists_its_robots(self):
        name = self.new_map(steadymap.MapOptions(policy="pocd"))
        self.assertEqual(self.client.robots(name), [])
        frames = [wall_frame(i, distance_m=2.0) for i in range(3)]
        self.client.upload(name, frames)
        (robot,) = self.client.robots(name)
        self.assertEqual(robot.trust, steadymap.RobotTrust.TRUSTED)
        self.assertEqual(robot.last_capture_time_ns, frames[-1].capture_time_ns)
        np.testing.assert_allclose(
            robot.T_world_camera, frames[-1].T_world_camera.matrix(), atol=1e-6
        )
        self.assertIsNone(robot.session_start_ns, "the end of an upload ends the session")
        self.assertEqual(robot.pose_error.time_ns, frames[-1].capture_time_ns)
        np.testing.assert_allclose(robot.pose_error.shift_m, 0.0, atol=0.005)
        self.assertTrue((np.linalg.eigvalsh(robot.pose_error.covariance) > 0.0).all())

    def test_without_objects_knows_no_robots(self):
        name = self.new_map()
        self.client.upload(name, [wall_frame(0, distance_m=2.0)])
        self.assertEqual(self.client.robots(name), [])
        with self.assertRaises(errors.NotFoundError):
            self.client.robots("nowhere")


class AnOffset(unittest.TestCase):
    def test_moves_points_about_its_center(self):
        message = robot_pb2.Robot(robot="dolly", sensor="left", trust=3)
        message.last_capture_time.seconds = 100
        message.session_start.seconds = 90
        message.world_from_camera.orientation.w = 1.0
        offset = message.pose_offset
        offset.time.nanos = 5
        offset.center_m.x, offset.center_m.y = 10.0, 20.0
        offset.shift_m.x = 0.5
        offset.yaw_rad = np.pi / 2
        offset.covariance.extend(float(i) for i in range(16))
        offset.anchors = 4
        error = message.pose_error
        error.time.nanos = 7
        error.shift_m.y, error.rotation_rad.z = 0.25, 0.5
        error.covariance.extend(float(i) for i in range(36))
        message.contradictions.add(robot="cart", sensor="left", objects=3).since.seconds = 80
        robot = robot_from_proto(message)
        self.assertEqual((robot.robot, robot.sensor), ("dolly", "left"))
        self.assertEqual(robot.trust, steadymap.RobotTrust.LOST)
        self.assertEqual(robot.session_start_ns, 90_000_000_000)
        self.assertEqual(
            robot.contradictions,
            (steadymap.SensorContradiction("cart", "left", 3, 80_000_000_000),),
        )
        self.assertEqual((robot.offset.time_ns, robot.offset.anchors), (5, 4))
        self.assertEqual(robot.pose_error.time_ns, 7)
        self.assertEqual(
            (robot.pose_error.shift_m[1], robot.pose_error.rotation_rad[2]), (0.25, 0.5)
        )
        self.assertEqual(robot.pose_error.covariance[1, 2], 8.0)
        moved = robot.offset.T_map_robot @ (11.0, 20.0, 3.0, 1.0)
        np.testing.assert_allclose(moved, (10.5, 21.0, 3.0, 1.0), atol=1e-12)
        self.assertEqual(robot.offset.covariance[1, 2], 6.0)
        self.assertFalse(robot.offset.covariance.flags.writeable)

    def test_may_be_unknown(self):
        robot = robot_from_proto(robot_pb2.Robot(robot="dolly", trust=9))
        self.assertEqual(robot.trust, steadymap.RobotTrust.UNSPECIFIED)
        self.assertIsNone(robot.offset)
        self.assertIsNone(robot.pose_error)
        self.assertEqual(robot.contradictions, ())
        self.assertIsNone(robot.session_start_ns)


if __name__ == "__main__":
    unittest.main()
