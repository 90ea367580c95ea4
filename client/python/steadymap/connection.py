"""The channel to a daemon, and calls over it that end in errors of ours."""

from typing import Any, Iterator

import grpc

from steadymap.errors import error_from_rpc

# As client/channel.cpp: pings during long uploads, a restarted server found again within 2 s, no
# compression by gRPC (the server refuses it), messages as large as the server sends.
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
    ("grpc.max_receive_message_length", -1),
)


class Connection:
    """A plain-text channel to `address`, which connects when first used."""

    def __init__(self, address: str, timeout_s: float) -> None:
        """Calls with one answer take `timeout_s` at most, streams of answers 20 times as long."""
        self._address = address
        self._timeout_s = timeout_s
        self._stream_timeout_s = 20 * timeout_s
        self.channel = grpc.insecure_channel(address, options=_CHANNEL_OPTIONS)

    def close(self) -> None:
        """Closes the channel."""
        self.channel.close()

    def open_asynchronously(self) -> "grpc.aio.Channel":
        """A channel to the same daemon for asyncio; its user closes it."""
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
