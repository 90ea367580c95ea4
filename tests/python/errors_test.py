"""Errors of the wire format as exceptions."""

import unittest

import grpc
from google.protobuf import any_pb2

from steadymap import errors
from steadymap._generated.v1 import status_pb2


class FakeRpcError(grpc.RpcError):
    """An error like those of gRPC, with content from the test."""

    def __init__(self, code, message, trailers=()):
        super().__init__()
        self._code, self._message, self._trailers = code, message, trailers

    def code(self):
        return self._code

    def details(self):
        return self._message

    def trailing_metadata(self):
        return self._trailers


def packed(name, message):
    """Packs a detail like a server."""
    return any_pb2.Any(
        type_url=f"type.googleapis.com/google.rpc.{name}", value=message.SerializeToString()
    )


def info(reason, domain="steadymap", **metadata):
    return packed(
        "ErrorInfo", status_pb2.ErrorInfo(reason=reason, domain=domain, metadata=metadata)
    )


def trailer(code, *details):
    status = status_pb2.Status(code=code.value[0], message="", details=details)
    return ("grpc-status-details-bin", status.SerializeToString())


class ErrorFromRpc(unittest.TestCase):
    def test_carries_reason_field_metadata_and_delay(self):
        code = grpc.StatusCode.INVALID_ARGUMENT
        violations = status_pb2.BadRequest()
        violations.field_violations.add(field="frames[3].depth.data", description="too short")
        retry = status_pb2.RetryInfo()
        retry.retry_delay.FromMilliseconds(1500)
        details = (
            info("IMAGE_SIZE_MISMATCH", expected="8"),
            packed("BadRequest", violations),
            packed("RetryInfo", retry),
        )
        error = errors.error_from_rpc(FakeRpcError(code, "too short", [trailer(code, *details)]))
        self.assertIs(type(error), errors.InvalidArgumentError)
        self.assertIsInstance(error, ValueError)
        self.assertEqual(error.reason, "IMAGE_SIZE_MISMATCH")
        self.assertEqual(error.field, "frames[3].depth.data")
        self.assertEqual(dict(error.metadata), {"expected": "8"})
        self.assertEqual(error.retry_delay_s, 1.5)
        self.assertEqual(
            str(error), "INVALID_ARGUMENT / IMAGE_SIZE_MISMATCH in frames[3].depth.data: too short"
        )

    def test_has_a_class_for_every_status(self):
        for code in grpc.StatusCode:
            if code is grpc.StatusCode.OK:
                continue
            with self.subTest(code=code):
                error = errors.error_from_rpc(FakeRpcError(code, "so it is"))
                self.assertEqual(error.code, code.name)
                self.assertEqual(error.reason, "")
                if code is not grpc.StatusCode.UNKNOWN:
                    self.assertIsNot(type(error), errors.SteadymapError)

    def test_ignores_details_of_another_domain(self):
        code = grpc.StatusCode.NOT_FOUND
        trailers = [trailer(code, info("ELSEWHERE", domain="example.com"))]
        self.assertEqual(errors.error_from_rpc(FakeRpcError(code, "gone", trailers)).reason, "")

    def test_ignores_details_that_contradict_the_status(self):
        trailers = [trailer(grpc.StatusCode.NOT_FOUND, info("NOT_FOUND"))]
        error = errors.error_from_rpc(
            FakeRpcError(grpc.StatusCode.UNAVAILABLE, "a proxy's", trailers)
        )
        self.assertEqual((error.code, error.reason), ("UNAVAILABLE", ""))

    def test_survives_details_that_are_damaged(self):
        trailers = [("grpc-status-details-bin", b"\xff\xff\xff"), ("other", "text")]
        error = errors.error_from_rpc(FakeRpcError(grpc.StatusCode.INTERNAL, "broken", trailers))
        self.assertEqual((error.code, error.message), ("INTERNAL", "broken"))

    def test_survives_a_detail_that_is_damaged(self):
        code = grpc.StatusCode.NOT_FOUND
        detail = any_pb2.Any(type_url="type.googleapis.com/google.rpc.ErrorInfo", value=b"\xff")
        error = errors.error_from_rpc(FakeRpcError(code, "gone", [trailer(code, detail)]))
        self.assertEqual((error.code, error.message), ("NOT_FOUND", "gone"))

    def test_knows_a_message_that_grpc_itself_refuses(self):
        error = errors.error_from_rpc(
            FakeRpcError(
                grpc.StatusCode.RESOURCE_EXHAUSTED, "Received message larger than max (9 vs. 8)"
            )
        )
        self.assertEqual(error.reason, "MESSAGE_TOO_LARGE")
        self.assertFalse(errors.is_worth_retrying(error))

    def test_metadata_is_read_only(self):
        with self.assertRaises(TypeError):
            errors.NotFoundError("gone").metadata["a"] = "b"


class IsWorthRetrying(unittest.TestCase):
    def test_follows_the_contract(self):
        worth = [
            errors.UnavailableError("", reason="DRAINING"),
            errors.DeadlineExceededError(""),
            errors.AbortedError("", reason="SLOW_CONSUMER"),
            errors.ResourceExhaustedError("", reason="DISK_LOW"),
            errors.DataLossError("", reason="CHECKSUM"),
            errors.InternalError(""),
        ]
        not_worth = [
            errors.InvalidArgumentError(""),
            errors.NotFoundError(""),
            errors.PermissionDeniedError(""),
            errors.UnauthenticatedError(""),
            errors.UnimplementedError(""),
            errors.OutOfRangeError("", reason="REVISION_COMPACTED"),
            errors.AbortedError("", reason="UPLOAD_SUPERSEDED"),
            errors.ResourceExhaustedError("", reason="MESSAGE_TOO_LARGE"),
            errors.DataLossError(""),
            errors.InternalError("", reason="INTERNAL"),
        ]
        for error in worth:
            self.assertTrue(errors.is_worth_retrying(error), error)
        for error in not_worth:
            self.assertFalse(errors.is_worth_retrying(error), error)


if __name__ == "__main__":
    unittest.main()
