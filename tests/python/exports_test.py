"""Complete and damaged exports."""

import tempfile
import unittest
from pathlib import Path

from steadymap import errors
from steadymap._generated.v1.query_service_pb2 import ExportMapResponse
from steadymap.checksum import extend_crc32c
from steadymap.exports import ExportSummary, take_export, write_export

CHUNKS = (b"abc", b"de")


def export_messages(chunks=CHUNKS):
    """Returns the messages for a file of `CHUNKS`, but with these chunks."""
    content = b"".join(CHUNKS)
    header = ExportMapResponse.Header(revision=7, triangles=12)
    trailer = ExportMapResponse.Trailer(file_bytes=len(content), crc32c=extend_crc32c(0, content))
    return [
        ExportMapResponse(header=header),
        *(ExportMapResponse(chunk=chunk) for chunk in chunks),
        ExportMapResponse(trailer=trailer),
    ]


class AnExport(unittest.TestCase):
    def test_is_its_chunks(self):
        chunks = []
        summary = take_export(export_messages(), chunks.append)
        self.assertEqual(b"".join(chunks), b"abcde")
        self.assertEqual(summary, ExportSummary(revision=7, file_bytes=5, triangles=12))

    def test_that_is_not_whole_is_lost(self):
        whole = export_messages()
        for messages, what in (
            (whole[:-1], "no trailer"),
            (whole[1:], "no header"),
            ([], "nothing"),
            (export_messages([b"abc"]), "a chunk less"),
            (export_messages([b"abc", b"de", b"f"]), "a chunk more"),
            (export_messages([b"abc", b"dx"]), "another byte"),
        ):
            with self.subTest(what), self.assertRaises(errors.DataLossError) as caught:
                take_export(iter(messages), lambda chunk: None)
            self.assertEqual(caught.exception.reason, "CHECKSUM")

    def test_makes_a_file_where_it_is_whole(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "map.ply")
            write_export(iter(export_messages()), path)
            self.assertEqual(path.read_bytes(), b"abcde")
            with self.assertRaises(errors.DataLossError):
                write_export(iter(export_messages()[:-1]), path)
            self.assertEqual(path.read_bytes(), b"abcde", "the file before stays")
            self.assertEqual(list(Path(folder).iterdir()), [path])


if __name__ == "__main__":
    unittest.main()
