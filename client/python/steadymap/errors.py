"""What can go wrong, one exception a status family.

Every error of the service has a `code`, and where the service gave them a stable `reason` and the
path of the `field` to blame. Arguments that cannot even be sent (an array of the wrong shape) are a
plain `ValueError` or `TypeError`.
"""

from types import MappingProxyType
from typing import Any, Dict, Mapping, Optional, Type

import grpc
from google.protobuf.message import DecodeError

from steadymap._generated.v1 import status_pb2

_DOMAIN = "steadymap"
_DETAILS_TRAILER = "grpc-status-details-bin"
_TOO_LARGE_TEXT = "larger than max"  # How gRPC itself refuses a message beyond its limit.


class SteadymapError(Exception):
    """A call that failed.

    Attributes:
        code: gRPC's name of the status, such as `"INVALID_ARGUMENT"`.
        message: one sentence for a person, as the service wrote it.
        reason: the stable reason, such as `"NON_FINITE_POSE"`; `""` where none was given.
        field: path of the field to blame, such as `"frames[0].depth.data"`; `""` where none was.
        metadata: further facts by name; read-only.
        retry_delay_s: seconds that the service asks to wait before another try, or None.
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
    """The request is wrong: fix it."""

    code = "INVALID_ARGUMENT"


class NotFoundError(SteadymapError):
    """There is no such map or object."""

    code = "NOT_FOUND"


class AlreadyExistsError(SteadymapError):
    """There is a map of that name."""

    code = "ALREADY_EXISTS"


class UnauthenticatedError(SteadymapError):
    """The service does not know who asks."""

    code = "UNAUTHENTICATED"


class PermissionDeniedError(SteadymapError):
    """Who asks may not."""

    code = "PERMISSION_DENIED"


class FailedPreconditionError(SteadymapError):
    """Not in this state: something else must happen first."""

    code = "FAILED_PRECONDITION"


class OutOfRangeError(SteadymapError):
    """A revision that is no longer, or not yet, there: start anew from a snapshot."""

    code = "OUT_OF_RANGE"


class AbortedError(SteadymapError):
    """Something else came in between (UPLOAD_SUPERSEDED, SLOW_CONSUMER, ETAG_MISMATCH)."""

    code = "ABORTED"


class ResourceExhaustedError(SteadymapError):
    """Too much, too fast or too large: back off. MESSAGE_TOO_LARGE never passes by waiting."""

    code = "RESOURCE_EXHAUSTED"


class UnavailableError(SteadymapError):
    """The service cannot be reached, or is about to stop: try again later."""

    code = "UNAVAILABLE"


class DeadlineExceededError(SteadymapError):
    """No answer in time."""

    code = "DEADLINE_EXCEEDED"


class DataLossError(SteadymapError):
    """Data is damaged or gone: tell somebody."""

    code = "DATA_LOSS"


class InternalError(SteadymapError):
    """A fault of the service: tell somebody."""

    code = "INTERNAL"


class UnimplementedError(SteadymapError):
    """The service is too old for this call."""

    code = "UNIMPLEMENTED"


class CancelledError(SteadymapError):
    """Given up before there was an answer."""

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
    """The error that a `google.rpc.Status` tells; details of other domains are ignored."""
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
    """The error that a gRPC call ended with, its trailing details included."""
    code = error.code().value[0]
    status = status_pb2.Status(code=code, message=error.details() or "no message was given")
    for key, value in error.trailing_metadata() or ():
        if key != _DETAILS_TRAILER:
            continue
        # Proxies put what they like there: it counts only where it says the same as the status.
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
    """The message in the bytes, or None where they are damaged."""
    try:
        return kind.FromString(value)
    except DecodeError:
        return None


_BY_GRPC_WITHOUT_REASON = frozenset(
    ("UNAVAILABLE", "DEADLINE_EXCEEDED", "CANCELLED", "INTERNAL", "UNKNOWN")
)


def is_server_answer(error: SteadymapError) -> bool:
    """Whether the service itself ended the call so.

    Otherwise it was gRPC or a deadline of ours: the server could not be reached, did not answer, or
    went away. The same rule as the C++ client's.
    """
    # The service always gives a reason.
    return error.code not in _BY_GRPC_WITHOUT_REASON or bool(error.reason)


_RETRIED_WHATEVER_THE_REASON = frozenset(("UNAVAILABLE", "DEADLINE_EXCEEDED"))
_RETRIED_WITHOUT_REASON = frozenset(("INTERNAL", "UNKNOWN", "CANCELLED"))


def is_worth_retrying(error: SteadymapError) -> bool:
    """Whether a stream that ended so may succeed when it is opened anew.

    The same rule as the C++ client's: never for what the caller must fix first, nor after
    UPLOAD_SUPERSEDED, where going on would take the session back and forth for ever.
    """
    if error.code in _RETRIED_WHATEVER_THE_REASON:
        return True
    if error.code == "ABORTED":
        return error.reason != "UPLOAD_SUPERSEDED"
    if error.code == "RESOURCE_EXHAUSTED":
        return error.reason != "MESSAGE_TOO_LARGE"
    if error.code == "DATA_LOSS":
        return error.reason == "CHECKSUM"  # A batch damaged on its way, not a map on disk.
    # gRPC reports connections that break in mid-message so; the service always gives a reason.
    return error.code in _RETRIED_WITHOUT_REASON and not error.reason
