"""The packed leaf as proto/README.md describes it: its example, and leaves of the daemon."""

import os
import re
import struct
import unittest
from pathlib import Path

import leaf_decoder
import numpy as np
from daemon_process import DaemonTest
from leaf_decoder import Voxel
from wall_frame import wall_frame

import steadymap

TRUNCATION_M = 0.15


def readme():
    """The text of proto/README.md."""
    source = os.environ.get("STEADYMAP_SOURCE") or Path(__file__).parents[2]
    return (Path(source) / "proto" / "README.md").read_text(encoding="utf-8")


def example(name):
    """The bytes of a block of the example."""
    block = re.search(f"^```{name}$(.*?)^```$", readme(), re.DOTALL | re.MULTILINE).group(1)
    lines = re.findall(r"^((?:[0-9a-f]{2} ?)+)", block, re.MULTILINE)
    return bytes.fromhex(" ".join(lines))


def example_voxels():
    """The table of the example: steps and voxel by offset."""
    row = r"^\| (\d) (\d) (\d) \| \d \| (-?\d+) \| ([-.\d]+) \| ([.\d]+) \| ([\d ]+) \|$"
    voxels = {}
    for x, y, z, steps, distance, weight, color in re.findall(row, readme(), re.MULTILINE):
        voxel = Voxel(float(distance), float(weight), tuple(map(int, color.split())))
        voxels[64 * int(x) + 8 * int(y) + int(z)] = (int(steps), voxel)
    return voxels


def to_zigzag(value, bits):
    """A residual of a value modulo 2^bits."""
    wrapped = (value + (1 << bits - 1)) % (1 << bits) - (1 << bits - 1)
    return 2 * wrapped if wrapped >= 0 else -2 * wrapped - 1


def pack(voxels):
    """Packs (steps, weight, color) by offset, not compressed: the inverse of the decoder."""
    mask, planes, seen, last = 0, [[] for _ in range(8)], {}, [0] * 5
    for offset, (steps, weight, color) in sorted(voxels.items()):
        mask |= 1 << offset
        distance = to_zigzag(steps - leaf_decoder.predict(seen, offset), 16)
        weight_units = to_zigzag(round(256 * weight) - last[0], 16)
        channels = [to_zigzag(now - before, 8) for now, before in zip(color, last[1:])]
        pairs = struct.pack("<HH", distance, weight_units)
        for plane, byte in zip(planes, (*pairs, *channels)):
            plane.append(byte)
        seen[offset], last = steps, [round(256 * weight), *color]
    return b"\x12" + mask.to_bytes(64, "little") + b"".join(map(bytes, planes))


class TheExampleOfTheReadme(unittest.TestCase):
    def setUp(self):
        self.table = example_voxels()
        self.leaf = leaf_decoder.unpack(example("leaf"), TRUNCATION_M)

    def test_decodes_to_its_table(self):
        self.assertEqual(sorted(self.table), [0, 1, 8, 9, 64])
        self.assertEqual(sorted(self.leaf), [0, 1, 8, 9, 64])
        for offset, (steps, voxel) in self.table.items():
            found = self.leaf[offset]
            self.assertAlmostEqual(found.distance_m, steps * TRUNCATION_M / 511, delta=1e-8)
            self.assertAlmostEqual(found.distance_m, voxel.distance_m, delta=6e-8)
            self.assertEqual(found[1:], voxel[1:])

    def test_is_packed_to_its_bytes(self):
        voxels = {offset: (steps, *voxel[1:]) for offset, (steps, voxel) in self.table.items()}
        self.assertEqual(pack(voxels).hex(" "), example("leaf").hex(" "))
        self.assertEqual(pack({1: (14, 3, (190, 101, 60, 3))}).hex(" "), example("patch").hex(" "))

    def test_is_the_same_compressed(self):
        self.assertEqual(example("compressed")[0], 0x32)
        self.assertEqual(leaf_decoder.unpack(example("compressed"), TRUNCATION_M), self.leaf)

    def test_is_patched(self):
        patch = leaf_decoder.unpack(example("patch"), TRUNCATION_M)
        patched = leaf_decoder.apply_patch(self.leaf, patch)
        self.assertEqual(leaf_decoder.apply_patch(patched, patch), patched)
        changed = {offset for offset in patched if patched[offset] != self.leaf[offset]}
        self.assertEqual((sorted(patched), changed), ([0, 1, 8, 9, 64], {1}))
        self.assertAlmostEqual(patched[1].distance_m, 14 * TRUNCATION_M / 511, delta=1e-8)
        self.assertEqual(patched[1][1:], (3.0, (190, 101, 60, 3)))

    def test_is_what_the_client_decodes(self):
        leaves = [
            steadymap.Leaf(0, np.zeros(3, np.int32), example(name))
            for name in ("leaf", "compressed", "patch")
        ]
        # The quotient of two float32 differs from the rounded step at the second.
        for truncation_m in (TRUNCATION_M, 0.031, 0.4):
            voxels = steadymap.unpack_leaves(leaves, truncation_m)
            for i, leaf in enumerate(leaves):
                expect_same(self, leaf_decoder.unpack(leaf.packed, truncation_m), voxels, i)

    def test_is_refused_when_damaged(self):
        good = example("leaf")
        one_voxel = b"\x02\x01" + bytes(63)
        for damaged in (
            b"\x11" + good[1:],  # Another version.
            b"\x52" + good[1:],  # An unknown flag.
            b"\x32" + good[1:],  # Not a zstd frame.
            good[:-1],
            good + b"\x00",
            good[:40],
            b"\x02" + bytes(64),  # No voxel.
            one_voxel + bytes((2, 0, 0, 0)),  # Weight 0.
            one_voxel + bytes((0x00, 0x04, 2, 0)),  # 512 steps.
        ):
            with self.subTest(damaged=damaged[:2].hex()), self.assertRaises(ValueError):
                leaf_decoder.unpack(damaged, TRUNCATION_M)
        self.assertEqual(leaf_decoder.unpack(b"", TRUNCATION_M), {})


def expect_same(test, leaf, voxels, place):
    """Compares a leaf with the one at `place` of those that the client unpacked, bit for bit."""
    observed = np.zeros(512, bool)
    observed[list(leaf)] = True
    np.testing.assert_array_equal(observed, voxels.observed[place].reshape(512))
    for offset, voxel in leaf.items():
        at = (place, offset >> 6, offset >> 3 & 7, offset & 7)
        found = (voxels.distance_m[at], voxels.weight[at], *voxels.colors[at])
        test.assertEqual((voxel.distance_m, voxel.weight, *voxel.color[:3]), found)


class LeavesOfTheDaemon(DaemonTest):
    def decode(self, section):
        """All leaves of a section by object and origin, compared with those of the client."""
        unpacked = steadymap.unpack_leaves(section.leaves, section.truncation_m)
        leaves = {}
        for i, packed in enumerate(section.leaves):
            leaf = leaf_decoder.unpack(packed.packed, section.truncation_m)
            expect_same(self, leaf, unpacked, i)
            leaves[packed.object_id, *packed.origin.tolist()] = leaf
        return leaves

    def test_of_a_flat_wall_are_a_plane(self):
        name = self.new_map()
        self.client.upload(name, [wall_frame(i) for i in range(3)])
        section = self.client.section(name)
        leaves = self.decode(section)
        self.assertGreater(len(leaves), 20)
        for (object_id, origin_x, _, _), leaf in leaves.items():
            self.assertEqual(object_id, 0)
            for offset, voxel in leaf.items():
                x_m = (origin_x + (offset >> 6)) * section.voxel_size_m
                if 2.0 - x_m < section.truncation_m:
                    self.assertAlmostEqual(voxel.distance_m, 2.0 - x_m, delta=1e-3)
                else:  # A lower bound: the clearance of the rays.
                    self.assertGreater(voxel.distance_m, 0.0)

    def test_of_a_rough_coloured_surface_are_those_of_the_client(self):
        random = np.random.default_rng(5)
        depth = random.integers(1700, 2100, (12, 16)).repeat(4, axis=0).repeat(4, axis=1)
        depth[random.random((48, 64)) < 0.3] = 0
        color = random.integers(0, 256, (48, 64, 3), np.uint8)
        name = self.new_map()
        frames = [wall_frame(i, depth=depth.astype(np.uint16), color=color) for i in range(2)]
        self.assertFalse(self.client.upload(name, frames).refused)
        section = self.client.section(name)
        leaves = self.decode(section)
        formats = {packed.packed[0] for packed in section.leaves}
        self.assertIn(0x32, formats)
        known = [v for leaf in leaves.values() for v in leaf.values() if v.color[3] > 0]
        self.assertGreater(len(known), 100)

    def test_of_a_watch_with_patches_lead_to_the_same_map(self):
        name = self.new_map()
        self.client.upload(name, [wall_frame(i) for i in range(3)])
        half = np.full((48, 64), 2020, np.uint16)
        half[:, 29:] = 0  # No return: a part of the leaves in the middle stays unchanged.
        options = steadymap.WatchOptions(kinds=["volumes"], takes_patches=True)
        replica, partial_patches = {}, 0
        with self.client.watch(name, options) as watch:
            truncation_m = next(watch).truncation_m
            for target in (3, 5):
                for item in self.read_up_to(watch, target):
                    partial_patches += self.apply(item, truncation_m, replica)
                self.client.upload(name, [wall_frame(target + i, depth=half) for i in range(2)])
            for item in self.read_up_to(watch, 7):
                partial_patches += self.apply(item, truncation_m, replica)
        self.assertGreater(partial_patches, 0)
        section = self.client.section(name)
        self.assertEqual(section.revision, 7)
        self.assertEqual(replica, self.decode(section))

    def read_up_to(self, watch, revision):
        """The items up to the progress to a revision."""
        items = []
        while True:
            items.append(next(watch))
            if isinstance(items[-1], steadymap.Progress) and items[-1].revision >= revision:
                return items

    def apply(self, item, truncation_m, replica):
        """Applies the leaves of an item; returns the number of patches of a part of a leaf."""
        partial_patches = 0
        for packed in getattr(item, "leaves", ()):
            key = (packed.object_id, *packed.origin.tolist())
            leaf = leaf_decoder.unpack(packed.packed, truncation_m)
            if packed.is_patch:
                partial_patches += len(leaf) < len(replica[key])
                replica[key] = leaf_decoder.apply_patch(replica[key], leaf)
            elif leaf:
                replica[key] = leaf
            else:
                del replica[key]
        return partial_patches


if __name__ == "__main__":
    unittest.main()
