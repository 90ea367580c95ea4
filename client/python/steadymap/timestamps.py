"""Times as nanoseconds since 1970, the resolution of the service."""

from typing import Any, Optional

from google.protobuf import timestamp_pb2

_NANOSECONDS = 1_000_000_000


def timestamp_to_proto(time_ns: int) -> timestamp_pb2.Timestamp:
    """Converts a time; TypeError for anything but an integer (e.g. seconds as float)."""
    if isinstance(time_ns, bool) or not hasattr(time_ns, "__index__"):
        raise TypeError(f"capture_time_ns: expected integer nanoseconds, got {type(time_ns)}")
    seconds, nanos = divmod(int(time_ns), _NANOSECONDS)
    return timestamp_pb2.Timestamp(seconds=seconds, nanos=nanos)


def time_ns_from_proto(message: Any, name: str) -> Optional[int]:
    """Returns the time in the field `name`, nanoseconds since 1970; None if it is absent."""
    if not message.HasField(name):
        return None
    time = getattr(message, name)
    return time.seconds * _NANOSECONDS + time.nanos
