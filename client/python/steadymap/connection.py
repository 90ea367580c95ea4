"""Channels to a daemon, and calls over them that raise SteadymapError."""

import threading
import weakref
from typing import Any, Iterator

import grpc

from steadymap.errors import CancelledError, error_from_rpc

# Same settings as client/transport/channel.cpp: keepalive pings during long uploads, a separate
# connection per channel, 2 s to connect, no gRPC compression (the server rejects it), no limit on
# received messages.
_CHANNEL_OPTIONS = (
    ("grpc.keepalive_time_ms", 30_000),
    ("grpc.keepalive_timeout_ms", 10_000),
    ("grpc.initial_reconnect_backoff_ms", 100),
    ("grpc.min_reconnect_backoff_ms", 2_000),
    ("grpc.max_reconnect_backoff_ms", 2_000),
    (
        "grpc.http2.max_pings_without_data",
        0,
    ),  # Otherwise a watch of an unchanged map would not detect a lost connection.
    ("grpc.use_local_subchannel_pool", 1),
    ("grpc.max_receive_message_length", -1),
)


class Connection:
    """Plain-text channels to `address`, which connect on first use. Thread-safe."""

    def __init__(self, address: str, timeout_s: float) -> None:
        """Unary calls take at most `timeout_s`, streaming calls 20 times as long."""
        self._address = address
        self._timeout_s = timeout_s
        self._stream_timeout_s = 20 * timeout_s
        self._lock = threading.Lock()
        self._channels: "weakref.WeakSet[grpc.Channel]" = weakref.WeakSet()  # Guarded by the lock.
        self._closed = False  # Guarded by the lock.
        self.channel = self.open_channel()  # For single calls.

    def close(self) -> None:
        """Closes all channels except asyncio channels; no new channels can be opened."""
        with self._lock:
            self._closed = True
            channels = list(self._channels)
        for channel in channels:
            channel.close()

    def open_channel(self) -> grpc.Channel:
        """Opens a channel for one attempt to reach the daemon; the caller closes it.

        A new channel has no backoff from earlier failures, so the caller alone decides the time of
        the next attempt. Raises CancelledError once the connection is closed.
        """
        with self._lock:
            if self._closed:
                raise CancelledError("the client is closed")
            channel = grpc.insecure_channel(self._address, options=_CHANNEL_OPTIONS)
            self._channels.add(channel)
            return channel

    def open_asynchronously(self) -> "grpc.aio.Channel":
        """Opens a channel for asyncio."""
        return grpc.aio.insecure_channel(self._address, options=_CHANNEL_OPTIONS)

    def call(self, method: Any, request: Any) -> Any:
        """Makes a unary call and returns its response. Raises SteadymapError."""
        try:
            return method(request, timeout=self._timeout_s)
        except grpc.RpcError as error:
            raise error_from_rpc(error) from None

    def stream(self, method: Any, request: Any) -> Iterator[Any]:
        """Yields the responses of a streaming call. Raises SteadymapError."""
        call = method(request, timeout=self._stream_timeout_s)
        try:
            yield from call
        except grpc.RpcError as error:
            raise error_from_rpc(error) from None
        finally:
            call.cancel()  # Has an effect only if the reader stopped early.
