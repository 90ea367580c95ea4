"""Frames, images and checksums before they are sent."""

import dataclasses
import struct
import unittest
import zlib

import numpy as np
from wall_frame import wall_frame

import steadymap
from steadymap import checksum, images
from steadymap._generated.v1 import frame_pb2
from steadymap.frame import frame_to_proto

PNG_START = b"\x89PNG\r\n\x1a\n"


def decode_png(data):
    """Decodes a PNG file with only the filter "up", the one that images.py writes."""
    width, height, bit_depth, color_type = struct.unpack(">IIBB", data[16:26])
    start = data.index(b"IDAT")
    length = struct.unpack(">I", data[start - 4 : start])[0]
    channels = 3 if color_type == 2 else 1
    row_bytes = width * channels * bit_depth // 8
    packed = zlib.decompress(data[start + 4 : start + 4 + length])
    rows = np.frombuffer(packed, np.uint8).reshape(height, 1 + row_bytes)
    assert (rows[:, 0] == 2).all()
    pixels = np.cumsum(rows[:, 1:], axis=0, dtype=np.uint8)
    pixels = pixels.reshape(-1).view(">u2" if bit_depth == 16 else np.uint8)
    return pixels.reshape((height, width, 3) if channels == 3 else (height, width))


class FrameChecks(unittest.TestCase):
    def test_refuses_images_of_another_size_by_name(self):
        for name, wrong in (
            ("depth", np.zeros((48, 63), np.uint16)),
            ("depth", np.zeros((64, 48), np.uint16)),
            ("depth", np.zeros(48 * 64, np.uint16)),
            ("labels", np.zeros((48, 64, 1), np.uint8)),
            ("instances", np.zeros((0, 0), np.uint8)),
            ("color", np.zeros((48, 64), np.uint8)),
            ("color", np.zeros((48, 64, 4), np.uint8)),
        ):
            with self.subTest(name=name, shape=wrong.shape):
                with self.assertRaisesRegex(ValueError, f"^{name}: expected shape"):
                    wall_frame(**{name: wrong})

    def test_refuses_pixels_of_a_wrong_type(self):
        size = (48, 64)
        for changes, message in (
            ({"depth": np.zeros(size, np.int32)}, "depth: expected uint16 or floating"),
            ({"depth": np.zeros(size, np.uint8)}, "depth: expected uint16 or floating"),
            ({"labels": np.zeros(size)}, "labels: expected integers"),
            ({"instances": np.zeros(size, bool)}, "instances: expected integers"),
            ({"color": np.zeros((*size, 3))}, "color: expected uint8"),
        ):
            with self.subTest(message=message), self.assertRaisesRegex(ValueError, message):
                wall_frame(**changes)

    def test_refuses_lists_and_times_in_seconds(self):
        with self.assertRaisesRegex(TypeError, "depth"):
            wall_frame(depth=[[1, 2]])
        with self.assertRaisesRegex(TypeError, "capture_time_ns"):
            frame_to_proto(wall_frame(capture_time_ns=1.5), images.PixelEncoding.RAW)

    def test_refuses_what_no_pixel_can_be(self):
        size = (48, 64)
        for changes, message in (
            ({"labels": np.full(size, -1)}, "labels: expected ids"),
            ({"instances": np.full(size, 65536)}, "instances: expected ids"),
            ({"depth": b"GIF89a"}, "depth: expected the bytes of a PNG file"),
            ({"color": b""}, "color: expected the bytes of a PNG file"),
        ):
            with self.subTest(message=message), self.assertRaisesRegex(ValueError, message):
                frame_to_proto(wall_frame(**changes), images.PixelEncoding.RAW)

    def test_refuses_metres_per_unit_and_sizes_out_of_range(self):
        for value in (0.0, -1.0, 1.0, float("nan")):
            with self.assertRaisesRegex(ValueError, "metres_per_unit"):
                wall_frame(metres_per_unit=value)
        for side in (0, -1, 4097):
            with self.assertRaisesRegex(ValueError, "width_px"):
                steadymap.Intrinsics(side, 48, 64.0, 64.0, 31.5, 23.5)

    def test_states_the_depth_sensor_by_name_or_value(self):
        for value in (steadymap.DepthSensor.STEREO, "stereo"):
            frame = wall_frame(depth_sensor=value)
            message = frame_to_proto(frame, images.PixelEncoding.RAW)
            self.assertEqual(message.depth.sensor, frame_pb2.DEPTH_SENSOR_STEREO)
        message = frame_to_proto(wall_frame(), images.PixelEncoding.RAW)
        self.assertEqual(message.depth.sensor, frame_pb2.DEPTH_SENSOR_UNSPECIFIED)
        with self.assertRaisesRegex(ValueError, "sonar"):
            wall_frame(depth_sensor="sonar")


class DepthInUnits(unittest.TestCase):
    def test_rounds_metres_and_drops_what_is_no_return(self):
        depth = np.array([[0.0, -1.0, np.nan, np.inf], [1.0004, 1.0006, 65.534, 65.536]])
        units = images.depth_in_units(depth, 0.001)
        self.assertEqual(units.dtype, np.dtype("<u2"))
        self.assertEqual(units.tolist(), [[0, 0, 0, 0], [1000, 1001, 65534, 0]])

    def test_warns_of_floats_that_are_no_metres(self):
        with self.assertWarnsRegex(UserWarning, "floats are metres, at most 65.534 .* is 1200"):
            images.depth_in_units(np.array([[1200.0, 2500.0], [np.nan, 0.0]], np.float32), 0.001)
        nothing = np.array([[np.inf, np.nan], [-1.0, 0.0]], np.float32)
        self.assertFalse(images.depth_in_units(nothing, 0.001).any())

    def test_gives_back_what_was_in_units(self):
        units = np.arange(65535, dtype=np.uint16).reshape(255, 257)
        for dtype in (np.float32, np.float64):
            metres = units.astype(dtype) * dtype(0.001)
            np.testing.assert_array_equal(images.depth_in_units(metres, 0.001), units)

    def test_takes_big_endian_and_strided_images(self):
        units = np.arange(12, dtype=np.uint16).reshape(3, 4)
        for same in (units.astype(">u2"), units[:, ::-1][:, ::-1], np.asfortranarray(units)):
            self.assertEqual(images.depth_in_units(same, 0.001).tobytes(), units.tobytes())


class Labels(unittest.TestCase):
    def test_take_the_smallest_type_that_holds_them(self):
        for labels, expected in (
            (np.array([[0, 255]], np.int64), np.uint8),
            (np.array([[0, 256]], np.int64), np.uint16),
            (np.array([[65535]], np.uint32), np.uint16),
        ):
            unsigned = images.labels_as_unsigned(labels, "labels")
            self.assertEqual(unsigned.dtype, expected)
            np.testing.assert_array_equal(unsigned, labels)


class EncodePng(unittest.TestCase):
    def test_keeps_every_pixel(self):
        random = np.random.default_rng(1)
        for shape, dtype in (((5, 7), np.uint16), ((1, 1), np.uint8), ((6, 4, 3), np.uint8)):
            pixels = random.integers(0, np.iinfo(dtype).max, shape, dtype, endpoint=True)
            data = images.encode_png(pixels)
            self.assertTrue(data.startswith(PNG_START))
            np.testing.assert_array_equal(decode_png(data), pixels)


class Crc32c(unittest.TestCase):
    def test_of_the_published_check_value(self):
        self.assertEqual(checksum.extend_crc32c(0, b"123456789"), 0xE3069283)
        self.assertEqual(checksum.extend_crc32c_with_numpy(0, b"123456789"), 0xE3069283)

    def test_is_the_same_with_numpy_and_in_parts(self):
        self.assertIsNotNone(checksum.extend_crc32c_natively)
        random = np.random.default_rng(2)
        for length in (0, 1, 63, 64, 65, 128, 1000, 4096, 100_001):
            data = random.bytes(length)
            cut = length // 3
            whole = checksum.extend_crc32c(0, data)
            self.assertEqual(checksum.extend_crc32c_with_numpy(0, data), whole)
            first = checksum.extend_crc32c_with_numpy(0, data[:cut])
            self.assertEqual(checksum.extend_crc32c_with_numpy(first, data[cut:]), whole)


class FrameToProto(unittest.TestCase):
    def test_copies_the_images(self):
        frame = wall_frame()
        message = frame_to_proto(frame, images.PixelEncoding.RAW)
        frame.depth[:] = 0
        self.assertEqual(message.depth.data, np.full((48, 64), 2000, "<u2").tobytes())

    def test_passes_files_as_they_are(self):
        png = images.encode_png(wall_frame().depth)
        frame = dataclasses.replace(wall_frame(), depth=png, labels=png, color=b"\xff\xd8\xff...")
        message = frame_to_proto(frame, images.PixelEncoding.ZSTD)
        self.assertEqual((message.depth.data, message.labels.data), (png, png))
        self.assertEqual(message.depth.encoding, frame_pb2.DEPTH_ENCODING_PNG_UINT16)
        self.assertEqual(message.labels.encoding, frame_pb2.LABEL_ENCODING_PNG)
        self.assertEqual(message.color.encoding, frame_pb2.COLOR_ENCODING_JPEG)

    def test_splits_the_capture_time(self):
        message = frame_to_proto(
            wall_frame(capture_time_ns=1_650_000_000_123_456_789), images.PixelEncoding.RAW
        )
        time = message.capture_time
        self.assertEqual((time.seconds, time.nanos), (1_650_000_000, 123_456_789))


if __name__ == "__main__":
    unittest.main()
