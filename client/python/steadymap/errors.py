"""Errors of the service, one exception per status code.

Every error of the service has a `code` and, if the service sent them, a stable `reason` and the
path of the offending `field`. Arguments that cannot be sent at all (e.g. an array of the wrong
shape) raise a plain `ValueError` or `TypeError`.
"""

from types import MappingProxyType
from typing import Any, Dict, Mapping, Optional, Type

import grpc
from google.protobuf.message import DecodeError

from steadymap._generated.v1 import status_pb2

_DOMAIN = "steadymap"
_DETAILS_TRAILER = "grpc-status-details-bin"
_TOO_LARGE_TEXT = "larger than max"  # gRPC's own error for a message beyond its limit.


class SteadymapError(Exception):
    """A failed call.

    Attributes:
        code: gRPC's name of the status, such as `"INVALID_ARGUMENT"`.
        message: One sentence for humans, written by the service.
        reason: The stable reason, such as `"NON_FINITE_POSE"`; `""` if none was sent.
        field: Path of the offending field, such as `"frames[0].depth.data"`; `""` if none was sent.
        metadata: Further facts by name; read-only.
        retry_delay_s: Delay before the next attempt that the service requests, seconds, or None.
    """

    code = "UNKNOWN"

    def __init__(
        self,
        message: str,
        *,
        reason: str = "",
        field: str = "",
        metadata: Optional[Mapping[str, str]] = None,
        retry_delay_s: Optional[float] = None,
    ) -> None:
        self.message = message
        self.reason = reason
        self.field = field
        self.metadata: Mapping[str, str] = MappingProxyType(dict(metadata or {}))
        self.retry_delay_s = retry_delay_s
        super().__init__(self._sentence())

    def _sentence(self) -> str:
        told = self.reason and self.reason != self.code
        name = f"{self.code} / {self.reason}" if told else self.code
        where = f" in {self.field}" if self.field and self.field not in self.message else ""
        return f"{name}{where}: {self.message}"


class InvalidArgumentError(SteadymapError, ValueError):
    """The request is invalid and must be corrected."""

    code = "INVALID_ARGUMENT"


class NotFoundError(SteadymapError):
    """The map or the object does not exist."""

    code = "NOT_FOUND"


class AlreadyExistsError(SteadymapError):
    """A map of that name exists already."""

    code = "ALREADY_EXISTS"


class UnauthenticatedError(SteadymapError):
    """The client could not be authenticated."""

    code = "UNAUTHENTICATED"


class PermissionDeniedError(SteadymapError):
    """The client lacks the permission."""

    code = "PERMISSION_DENIED"


class FailedPreconditionError(SteadymapError):
    """The operation is impossible in the current state."""

    code = "FAILED_PRECONDITION"


class OutOfRangeError(SteadymapError):
    """The requested revision no longer exists or does not exist yet: restart from a snapshot."""

    code = "OUT_OF_RANGE"


class AbortedError(SteadymapError):
    """A concurrent operation took precedence (UPLOAD_SUPERSEDED, SLOW_CONSUMER, ETAG_MISMATCH)."""

    code = "ABORTED"


class ResourceExhaustedError(SteadymapError):
    """A limit is exceeded: back off. MESSAGE_TOO_LARGE is permanent."""

    code = "RESOURCE_EXHAUSTED"


class UnavailableError(SteadymapError):
    """The service is unreachable or shutting down: retry later."""

    code = "UNAVAILABLE"


class DeadlineExceededError(SteadymapError):
    """The service did not answer in time."""

    code = "DEADLINE_EXCEEDED"


class DataLossError(SteadymapError):
    """Data is damaged or missing: report it to the operator."""

    code = "DATA_LOSS"


class InternalError(SteadymapError):
    """A fault of the service: report it to the operator."""

    code = "INTERNAL"


class UnimplementedError(SteadymapError):
    """The service is too old for this call."""

    code = "UNIMPLEMENTED"


class CancelledError(SteadymapError):
    """The call was cancelled before its response."""

    code = "CANCELLED"


_CLASSES: Dict[str, Type[SteadymapError]] = {
    error.code: error for error in SteadymapError.__subclasses__()
}
_NAMES: Dict[int, str] = {code.value[0]: code.name for code in grpc.StatusCode}


_DETAILS = {
    "google.rpc.ErrorInfo": status_pb2.ErrorInfo,
    "google.rpc.BadRequest": status_pb2.BadRequest,
    "google.rpc.RetryInfo": status_pb2.RetryInfo,
}


def error_from_status(status: status_pb2.Status) -> SteadymapError:
    """Converts a `google.rpc.Status`; ignores details of other domains."""
    reason, field, metadata, retry_delay_s = "", "", {}, None
    for detail in status.details:
        kind = detail.type_url.rpartition("/")[2]
        message = _parse(_DETAILS[kind], detail.value) if kind in _DETAILS else None
        if isinstance(message, status_pb2.ErrorInfo) and message.domain == _DOMAIN:
            reason, metadata = message.reason, dict(message.metadata)
        elif isinstance(message, status_pb2.BadRequest) and message.field_violations:
            field = message.field_violations[0].field
        elif isinstance(message, status_pb2.RetryInfo):
            retry_delay_s = message.retry_delay.seconds + message.retry_delay.nanos * 1e-9
    name = _NAMES.get(status.code, "UNKNOWN")
    return _CLASSES.get(name, SteadymapError)(
        status.message, reason=reason, field=field, metadata=metadata, retry_delay_s=retry_delay_s
    )


def error_from_rpc(error: grpc.RpcError) -> SteadymapError:
    """Converts the error of a gRPC call, including its trailing details."""
    code = error.code().value[0]
    status = status_pb2.Status(code=code, message=error.details() or "no message was given")
    for key, value in error.trailing_metadata() or ():
        if key != _DETAILS_TRAILER:
            continue
        # Proxies may change the trailer: use it only if its code equals the code of the status.
        details = _parse(status_pb2.Status, value)
        if details is not None and details.code == code:
            del status.details[:]
            status.details.extend(details.details)
    converted = error_from_status(status)
    if (
        isinstance(converted, ResourceExhaustedError)
        and not converted.reason
        and _TOO_LARGE_TEXT in converted.message
    ):
        return ResourceExhaustedError(converted.message, reason="MESSAGE_TOO_LARGE")
    return converted


def _parse(kind: Any, value: bytes) -> Any:
    """Parses a message, or returns None if the bytes are damaged."""
    try:
        return kind.FromString(value)
    except DecodeError:
        return None


_BY_GRPC_WITHOUT_REASON = frozenset(
    ("UNAVAILABLE", "DEADLINE_EXCEEDED", "CANCELLED", "INTERNAL", "UNKNOWN")
)


def is_server_answer(error: SteadymapError) -> bool:
    """True if the service itself ended the call with `error`.

    False if the error comes from gRPC or a client deadline: the server was unreachable, did not
    answer, or closed the connection. Same rule as in the C++ client.
    """
    # Every error of the service has a reason.
    return error.code not in _BY_GRPC_WITHOUT_REASON or bool(error.reason)


_RETRIED_WHATEVER_THE_REASON = frozenset(("UNAVAILABLE", "DEADLINE_EXCEEDED"))
_RETRIED_WITHOUT_REASON = frozenset(("INTERNAL", "UNKNOWN", "CANCELLED"))


def is_worth_retrying(error: SteadymapError) -> bool:
    """True if a stream that ended with `error` may succeed on a new stream.

    Same rule as in the C++ client: false for errors that the caller must fix first, and for
    UPLOAD_SUPERSEDED, because two uploaders would supersede each other endlessly.
    """
    if error.code in _RETRIED_WHATEVER_THE_REASON:
        return True
    if error.code == "ABORTED":
        return error.reason != "UPLOAD_SUPERSEDED"
    if error.code == "RESOURCE_EXHAUSTED":
        return error.reason != "MESSAGE_TOO_LARGE"
    if error.code == "DATA_LOSS":
        return error.reason == "CHECKSUM"  # A batch damaged in transit, not a map damaged on disk.
    # gRPC reports a connection that breaks within a message with these codes; errors of the service
    # always have a reason.
    return error.code in _RETRIED_WITHOUT_REASON and not error.reason
