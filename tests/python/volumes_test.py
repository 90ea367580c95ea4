"""Leaves compared with samples from the service."""

import unittest

import numpy as np
from daemon_process import DaemonTest
from wall_frame import wall_frame

import steadymap
from steadymap import errors


def centers_m(section):
    """Returns the centres of all voxels of the background's leaves, shape (L, 8, 8, 8, 3)."""
    voxels = np.stack(np.meshgrid(*3 * [np.arange(8)], indexing="ij"), axis=-1)
    origins = np.array([leaf.origin for leaf in section.leaves])
    return (origins[:, None, None, None] + voxels) * section.voxel_size_m


class ASection(DaemonTest):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        random = np.random.default_rng(7)
        cls.client.create_map("rough")
        frames = []
        for i in range(3):
            # Rough surface with holes: predictions of all kinds, large residuals, sparse masks.
            depth = random.integers(1700, 2100, (12, 16)).repeat(4, axis=0).repeat(4, axis=1)
            depth[random.random((48, 64)) < 0.3] = 0
            color = random.integers(0, 256, (48, 64, 3), np.uint8)
            frames.append(wall_frame(i, depth=depth.astype(np.uint16), color=color))
        summary = cls.client.upload("rough", frames)
        assert not summary.refused, summary.refused
        cls.section = cls.client.section("rough")
        cls.voxels = steadymap.unpack_leaves(cls.section.leaves, cls.section.truncation_m)

    def test_names_its_revision_and_scale(self):
        self.assertEqual(self.section.revision, 3)
        self.assertEqual((self.section.voxel_size_m, self.section.objects), (0.05, ()))
        self.assertEqual(len(self.section.leaves), self.client.get_map("rough").leaves)

    def test_has_the_distances_and_weights_that_the_service_samples(self):
        observed = self.voxels.observed
        points_m = centers_m(self.section)[observed]
        self.assertGreater(len(points_m), 1000)
        samples = self.client.sample_distance("rough", points_m)
        known = ~np.isnan(samples.distance_m)
        # A sample may be unknown if a neighbour is.
        self.assertGreater(known.sum(), 0.1 * len(points_m))
        distance_m = self.voxels.distance_m[observed][known]
        np.testing.assert_allclose(distance_m, samples.distance_m[known], atol=1e-5)
        weight = self.voxels.weight[observed][known]
        np.testing.assert_allclose(weight, samples.weight[known], rtol=1e-4, atol=1e-4)

    def test_counts_the_voxels_that_the_map_counts(self):
        self.assertEqual(self.voxels.observed.sum(), self.client.get_map("rough").voxels)
        self.assertTrue(np.isnan(self.voxels.distance_m[~self.voxels.observed]).all())
        self.assertTrue((self.voxels.weight[~self.voxels.observed] == 0).all())

    def test_has_colours_where_a_surface_was_seen(self):
        self.assertEqual(self.voxels.colors.shape, (*self.voxels.observed.shape, 3))
        self.assertGreater(self.voxels.colors.std(), 10)

    def test_is_cut_by_a_box(self):
        box = ((1.5, 0.0, 0.0), (2.5, 0.3, 0.3))
        part = self.client.section("rough", box=box)
        self.assertLess(len(part.leaves), len(self.section.leaves))
        whole = {tuple(leaf.origin): leaf.packed for leaf in self.section.leaves}
        for leaf in part.leaves:
            self.assertEqual(leaf.packed, whole[tuple(leaf.origin)])

    def test_of_a_flat_wall_is_a_plane(self):
        name = self.new_map()
        self.client.upload(name, [wall_frame(i) for i in range(3)])
        section = self.client.section(name)
        voxels = steadymap.unpack_leaves(section.leaves, section.truncation_m)
        expected_m = 2.0 - centers_m(section)[voxels.observed][:, 0]
        distance_m = voxels.distance_m[voxels.observed]
        in_band = expected_m < section.truncation_m
        np.testing.assert_allclose(distance_m[in_band], expected_m[in_band], atol=1e-3)
        # Further in front, a distance is a lower bound: the clearance of the rays.
        self.assertTrue((distance_m[~in_band] <= section.truncation_m).all())
        self.assertTrue((distance_m[~in_band] > 0.0).all())


class UnpackLeaves(unittest.TestCase):
    def test_of_none_and_of_leaves_that_are_gone(self):
        self.assertEqual(steadymap.unpack_leaves([], 0.15).observed.shape, (0, 8, 8, 8))
        gone = steadymap.Leaf(0, np.zeros(3, np.int32), b"")
        self.assertFalse(steadymap.unpack_leaves([gone], 0.15).observed.any())

    def test_refuses_damaged_leaves(self):
        one_voxel = b"\x02" + b"\x01" + bytes(63)
        good = one_voxel + bytes((2, 0, 2, 0))
        voxels = steadymap.unpack_leaves([steadymap.Leaf(0, np.zeros(3, np.int32), good)], 0.511)
        self.assertAlmostEqual(float(voxels.distance_m[0, 0, 0, 0]), 0.001, places=6)
        for damaged in (
            b"\x01" + good[1:],  # Another version.
            b"\x42" + good[1:],  # An unknown flag.
            b"\x02",
            b"\x02" + bytes(64),  # No voxel.
            good[:-1],
            good + b"\x00",
            b"\x12" + good[1:],  # Missing colours.
            b"\x22" + good[1:],  # No zstd frame.
            one_voxel + bytes((2, 0, 0, 0)),  # Without weight.
            one_voxel + bytes((0xFF, 0xFF, 2, 0)),  # Beyond the truncation.
            one_voxel + bytes((0x00, 0x04, 2, 0)),  # Beyond it by one step.
        ):
            leaf = steadymap.Leaf(0, np.zeros(3, np.int32), damaged)
            with self.subTest(damaged=damaged[:2]), self.assertRaises(errors.DataLossError):
                steadymap.unpack_leaves([leaf], 0.15)


if __name__ == "__main__":
    unittest.main()
