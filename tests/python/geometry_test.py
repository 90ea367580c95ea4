"""Poses and boxes."""

import unittest

import numpy as np

import steadymap
from steadymap.geometry import as_points, box_to_proto


class PoseFromMatrix(unittest.TestCase):
    def test_and_back_gives_the_same_for_random_rotations(self):
        random = np.random.default_rng(3)
        for _ in range(200):
            quaternion = random.normal(size=4)
            quaternion /= np.linalg.norm(quaternion)
            pose = steadymap.Pose(random.normal(size=3), quaternion)
            matrix = pose.matrix()
            np.testing.assert_allclose(matrix[:3, :3] @ matrix[:3, :3].T, np.eye(3), atol=1e-12)
            self.assertAlmostEqual(np.linalg.det(matrix), 1.0)
            again = steadymap.Pose.from_matrix(matrix)
            np.testing.assert_allclose(again.matrix(), matrix, atol=1e-12)

    def test_of_half_turns(self):
        for axis in range(3):
            matrix = -np.eye(4)
            matrix[axis, axis] = matrix[3, 3] = 1.0
            again = steadymap.Pose.from_matrix(matrix).matrix()
            np.testing.assert_allclose(again, matrix, atol=1e-12)

    def test_agrees_with_a_quarter_turn_about_z(self):
        half = np.sqrt(0.5)
        pose = steadymap.Pose((1.0, 2.0, 3.0), (0.0, 0.0, half, half))
        moved = pose.matrix() @ (1.0, 0.0, 0.0, 1.0)
        np.testing.assert_allclose(moved, (1.0, 3.0, 3.0, 1.0), atol=1e-12)

    def test_refuses_what_is_no_rigid_transform(self):
        mirrored = np.diag((1.0, 1.0, -1.0, 1.0))
        projective = np.eye(4)
        projective[3, 0] = 1.0
        for matrix in (np.zeros((4, 4)), 2 * np.eye(4), mirrored, projective):
            with self.assertRaisesRegex(ValueError, "expected a rigid transform"):
                steadymap.Pose.from_matrix(matrix)
        with self.assertRaisesRegex(ValueError, "expected a 4x4 matrix"):
            steadymap.Pose.from_matrix(np.eye(3))

    def test_lets_nan_pass_for_the_service_to_refuse(self):
        for row, column in ((0, 3), (1, 1), (3, 3)):
            matrix = np.eye(4)
            matrix[row, column] = np.nan
            pose = steadymap.Pose.from_matrix(matrix)
            numbers = (*pose.position_m, *pose.quaternion_xyzw)
            self.assertFalse(np.isfinite(numbers).all())


class Arrays(unittest.TestCase):
    def test_of_a_pose_are_checked_and_read_only(self):
        with self.assertRaisesRegex(ValueError, "quaternion_xyzw"):
            steadymap.Pose((0, 0, 0), (0, 0, 1))
        pose = steadymap.Pose((0, 0, 0), (0, 0, 0, 1))
        with self.assertRaises(ValueError):
            pose.position_m[0] = 1.0

    def test_of_points_have_three_columns(self):
        self.assertEqual(as_points((1, 2, 3), "points").shape, (1, 3))
        self.assertEqual(as_points(np.empty((0, 3)), "points").shape, (0, 3))
        for wrong in (np.zeros((3, 2)), np.zeros(4), 1.0, []):
            with self.assertRaisesRegex(ValueError, "points: expected an array of shape"):
                as_points(wrong, "points")

    def test_of_a_box_are_its_corners(self):
        box = box_to_proto(((1, 2, 3), (4, 5, 6)))
        self.assertEqual((box.min_m.x, box.max_m.z), (1, 6))
        self.assertIsNone(box_to_proto(None))
        with self.assertRaisesRegex(ValueError, "box: expected"):
            box_to_proto((1, 2, 3))


if __name__ == "__main__":
    unittest.main()
