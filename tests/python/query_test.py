"""Queries compared with a closed form: a flat wall."""

import tempfile
import unittest
from pathlib import Path

import numpy as np
from daemon_process import DaemonTest
from wall_frame import wall_frame

import steadymap
from steadymap import errors, mesh

WALL_M = 2.0
TRUNCATION_M = 0.15
STEP_M = 2e-3  # Distances are quantised; the truncation has some hundred steps.


class AWall(DaemonTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.client.create_map("wall", steadymap.MapOptions(truncation_m=TRUNCATION_M))
        frames = [wall_frame(i, distance_m=WALL_M) for i in range(5)]
        cls.client.upload("wall", frames)
        cls.client.create_map("empty")

    def points_before_the_wall(self, count):
        """Returns seeded points well within the truncation band, and their distances."""
        random = np.random.default_rng(5)
        distance_m = random.uniform(-0.045, 0.13, count)
        y, z = random.uniform(-0.4, 0.4, (2, count))
        return np.column_stack((WALL_M - distance_m, y, z)), distance_m

    def test_has_the_distances_of_a_plane(self):
        points, distance_m = self.points_before_the_wall(500)
        samples = self.client.sample_distance("wall", points)
        near = np.where(distance_m > 0, steadymap.PointState.FREE, steadymap.PointState.SURFACE)
        clear = np.abs(distance_m) > STEP_M
        np.testing.assert_array_equal(samples.state[clear], near[clear])
        np.testing.assert_allclose(samples.distance_m, distance_m, atol=STEP_M)
        np.testing.assert_allclose(samples.gradient @ (-1.0, 0.0, 0.0), 1.0, atol=1e-3)
        self.assertEqual(samples.revision, 5)
        self.assertEqual(samples.distance_m.shape, (500,))
        self.assertTrue((samples.weight > 0).all())
        self.assertFalse(samples.distance_m.flags.writeable)

    def test_is_unknown_where_nobody_looked(self):
        points = [(-1.0, 0.0, 0.0), (WALL_M + 0.04, 0.0, 0.0), (WALL_M + TRUNCATION_M, 0.0, 0.0)]
        samples = self.client.sample_distance("wall", points)
        unknown, surface = steadymap.PointState.UNKNOWN, steadymap.PointState.SURFACE
        self.assertEqual(samples.state.tolist(), [unknown, surface, unknown])
        self.assertTrue(np.isnan(samples.distance_m[0]) and np.isnan(samples.gradient[0]).all())
        self.assertEqual(samples.weight[0], 0.0)

    def test_is_met_by_rays_where_a_plane_is(self):
        random = np.random.default_rng(6)
        origins = random.uniform((-0.5, -0.1, -0.1), (1.5, 0.1, 0.1), (200, 3))
        targets = np.column_stack((np.full(200, WALL_M), random.uniform(-0.4, 0.4, (200, 2))))
        directions = 3.0 * (targets - origins)
        hits = self.client.cast_rays("wall", origins, directions)
        self.assertTrue((hits.state == steadymap.PointState.SURFACE).all())
        self.assertTrue((hits.free_until_m <= hits.range_m).all())
        np.testing.assert_allclose(hits.point_m, targets, atol=2 * STEP_M)
        expected_m = np.linalg.norm(targets - origins, axis=1)
        np.testing.assert_allclose(hits.range_m, expected_m, atol=2 * STEP_M)
        np.testing.assert_allclose(hits.normal, np.tile((-1.0, 0.0, 0.0), (200, 1)), atol=1e-2)

    def test_is_missed_by_rays_that_go_elsewhere(self):
        directions = [(1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0)]
        hits = self.client.cast_rays("wall", (0.0, 0.0, 0.0), directions)
        surface, unknown = steadymap.PointState.SURFACE, steadymap.PointState.UNKNOWN
        self.assertEqual(hits.state.tolist(), [surface, unknown, unknown])
        self.assertTrue(np.isnan(hits.range_m[1:]).all() and np.isnan(hits.point_m[1:]).all())
        short = self.client.cast_rays("wall", (0.0, 0.0, 0.0), directions, max_range_m=1.0)
        self.assertTrue((short.state == unknown).all())

    def test_is_a_flat_mesh(self):
        surface = self.client.mesh("wall")
        self.assertEqual((surface.revision, surface.colors), (5, None))
        np.testing.assert_allclose(surface.vertices[:, 0], WALL_M, atol=STEP_M)
        np.testing.assert_allclose(surface.normals @ (-1.0, 0.0, 0.0), 1.0, atol=1e-3)
        corners = surface.vertices[surface.triangles].astype(float)
        sides = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self.assertTrue((sides[:, 0] < 0).all(), "triangles face the camera")
        # The camera observes 64 x 48 pixels at f = 64: 2 m x 1.5 m of the wall; a voxel or two are
        # missing along each border.
        area_m2 = np.linalg.norm(sides, axis=1).sum() / 2
        self.assertGreater(area_m2, (2.0 - 4 * 0.05) * (1.5 - 4 * 0.05))
        self.assertLess(area_m2, 2.0 * 1.5)

    def test_is_cut_by_a_box(self):
        box = ((1.0, -0.2, -0.2), (3.0, 0.2, 0.2))
        surface = self.client.mesh("wall", box=box)
        self.assertGreater(len(surface.vertices), 10)
        self.assertLess(np.abs(surface.vertices[:, 1:]).max(), 0.2 + 0.05)
        self.assertLess(len(surface.vertices), len(self.client.mesh("wall").vertices))

    def test_is_exported_in_every_format(self):
        with tempfile.TemporaryDirectory() as folder:
            for name, start in (("a.ply", b"ply\n"), ("a.GLB", b"glTF"), ("a.vdb", b" BDV")):
                file = Path(folder, name)
                summary = self.client.export("wall", file)
                self.assertEqual(summary.revision, 5)
                self.assertEqual(file.stat().st_size, summary.file_bytes)
                self.assertEqual(file.read_bytes()[:4], start)
            file = Path(folder, "mesh")
            self.assertGreater(self.client.export("wall", str(file), "ply").triangles, 100)
            self.assertEqual(
                sorted(p.name for p in Path(folder).iterdir()), ["a.GLB", "a.ply", "a.vdb", "mesh"]
            )
            with self.assertRaises(ValueError):
                self.client.export("wall", Path(folder, "a.obj"))

    def test_leaves_no_file_where_an_export_fails(self):
        with tempfile.TemporaryDirectory() as folder:
            with self.assertRaises(errors.NotFoundError):
                self.client.export("nowhere", Path(folder, "a.ply"))
            self.assertEqual(list(Path(folder).iterdir()), [])

    def test_that_nobody_saw_is_empty(self):
        surface = self.client.mesh("empty")
        self.assertEqual((surface.vertices.shape, surface.triangles.shape), ((0, 3), (0, 3)))
        samples = self.client.sample_distance("empty", (0.0, 0.0, 0.0))
        self.assertEqual(samples.state.tolist(), [steadymap.PointState.UNKNOWN])
        self.assertEqual(list(self.client.objects("empty")), [])
        self.assertEqual(list(self.client.events("empty")), [])


class Requests(DaemonTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.client.create_map("hall")

    def test_of_no_points_and_rays_have_empty_answers(self):
        samples = self.client.sample_distance("hall", np.empty((0, 3)))
        self.assertEqual((samples.state.shape, samples.gradient.shape), ((0,), (0, 3)))
        hits = self.client.cast_rays("hall", (0, 0, 0), np.empty((0, 3)))
        self.assertEqual((hits.state.shape, hits.point_m.shape), ((0,), (0, 3)))

    def test_of_wrong_shapes_are_refused_here(self):
        for wrong in (np.zeros((4, 2)), np.zeros((2, 2, 3)), 7.0):
            with self.assertRaisesRegex(ValueError, "points_m: expected"):
                self.client.sample_distance("hall", wrong)
            with self.assertRaisesRegex(ValueError, "directions: expected"):
                self.client.cast_rays("hall", (0, 0, 0), wrong)
        with self.assertRaisesRegex(ValueError, "the same number of both, got 2 and 3"):
            self.client.cast_rays("hall", np.zeros((2, 3)), np.ones((3, 3)))

    def test_of_numbers_that_are_none_are_refused_by_the_service(self):
        with self.assertRaises(errors.InvalidArgumentError) as raised:
            self.client.sample_distance("hall", [(0, 0, 0), (0, np.nan, 0)])
        self.assertEqual(raised.exception.field, "points_m[1]")
        with self.assertRaises(errors.InvalidArgumentError) as raised:
            self.client.cast_rays("hall", (0, 0, 0), (0.0, 0.0, 0.0))
        self.assertIn("rays[0].direction", raised.exception.field)
        with self.assertRaises(errors.InvalidArgumentError):
            self.client.cast_rays("hall", (0, 0, 0), (1, 0, 0), max_range_m=-1.0)
        with self.assertRaises(errors.InvalidArgumentError):
            list(self.client.objects("hall", box=((1, 1, 1), (0, 0, 0))))

    def test_of_objects_that_are_not_there_are_not_found(self):
        with self.assertRaises(errors.NotFoundError):
            self.client.get_object("hall", 7)
        with self.assertRaises(errors.NotFoundError):
            self.client.mesh("hall", object_ids=[7])


class ParsePly(unittest.TestCase):
    def test_refuses_what_the_service_does_not_write(self):
        start = b"ply\nformat binary_little_endian 1.0\n"
        vertices = b"".join(b"property float %s\n" % p for p in b"x y z nx ny nz".split())
        for wrong in (
            b"",
            b"ply\nformat ascii 1.0\nend_header\n",
            start,
            start + b"element vertex 1\nproperty float x\nend_header\n",
            start + b"element vertex 1\n" + vertices + b"end_header\n" + bytes(23),
            start + b"element vertex 0\n" + vertices + b"element face 1\nend_header\n" + bytes(13),
        ):
            with self.assertRaises(errors.DataLossError):
                mesh.parse_ply(wrong, 1)


if __name__ == "__main__":
    unittest.main()
