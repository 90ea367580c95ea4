"""Channels to a daemon, and calls over them that end in errors of ours."""

import threading
import weakref
from typing import Any, Iterator

import grpc

from steadymap.errors import CancelledError, error_from_rpc

# As client/transport/channel.cpp: pings during long uploads, a connection of its own for each channel, 2 s to
# connect, no compression by gRPC (the server refuses it), messages as large as the server sends.
_CHANNEL_OPTIONS = (
    ("grpc.keepalive_time_ms", 30_000),
    ("grpc.keepalive_timeout_ms", 10_000),
    ("grpc.initial_reconnect_backoff_ms", 100),
    ("grpc.min_reconnect_backoff_ms", 2_000),
    ("grpc.max_reconnect_backoff_ms", 2_000),
    (
        "grpc.http2.max_pings_without_data",
        0,
    ),  # Or a watch of a quiet map would not see a dead link.
    ("grpc.use_local_subchannel_pool", 1),
    ("grpc.max_receive_message_length", -1),
)


class Connection:
    """Plain-text channels to `address`, which connect when first used. Thread-safe."""

    def __init__(self, address: str, timeout_s: float) -> None:
        """Calls with one answer take `timeout_s` at most, streams of answers 20 times as long."""
        self._address = address
        self._timeout_s = timeout_s
        self._stream_timeout_s = 20 * timeout_s
        self._lock = threading.Lock()
        self._channels: "weakref.WeakSet[grpc.Channel]" = weakref.WeakSet()  # Guarded by the lock.
        self._closed = False  # Likewise.
        self.channel = self.open_channel()  # For calls that are made once.

    def close(self) -> None:
        """Closes all channels but those for asyncio; there will be no more."""
        with self._lock:
            self._closed = True
            channels = list(self._channels)
        for channel in channels:
            channel.close()

    def open_channel(self) -> grpc.Channel:
        """A channel for one try to reach the daemon; its user closes it.

        A new one knows nothing of failures before it, so the one who tries decides alone when to
        try again. Raises CancelledError once the connection is closed.
        """
        with self._lock:
            if self._closed:
                raise CancelledError("the client is closed")
            channel = grpc.insecure_channel(self._address, options=_CHANNEL_OPTIONS)
            self._channels.add(channel)
            return channel

    def open_asynchronously(self) -> "grpc.aio.Channel":
        """The same for asyncio."""
        return grpc.aio.insecure_channel(self._address, options=_CHANNEL_OPTIONS)

    def call(self, method: Any, request: Any) -> Any:
        """The answer of a call that has one. Raises SteadymapError."""
        try:
            return method(request, timeout=self._timeout_s)
        except grpc.RpcError as error:
            raise error_from_rpc(error) from None

    def stream(self, method: Any, request: Any) -> Iterator[Any]:
        """The answers of a call that streams them. Raises SteadymapError."""
        call = method(request, timeout=self._stream_timeout_s)
        try:
            yield from call
        except grpc.RpcError as error:
            raise error_from_rpc(error) from None
        finally:
            call.cancel()  # Of no effect but where the reader stopped early.
