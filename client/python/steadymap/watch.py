"""Watches the changes of a map, with retries after transient errors."""

import asyncio
import dataclasses
import enum
import threading
import time
from typing import Any, AsyncIterator, Callable, Iterator, List, Optional, Sequence, Union

import grpc

from steadymap._generated.v1 import watch_service_pb2, watch_service_pb2_grpc
from steadymap.backoff import Backoff, BackoffOptions
from steadymap.errors import (
    SteadymapError,
    UnavailableError,
    error_from_rpc,
    is_server_answer,
    is_worth_retrying,
)
from steadymap.geometry import box_to_proto
from steadymap.watch_items import Created, Progress, Resync, Snapshot, WatchItem, item_from_proto


class WatchStart(str, enum.Enum):
    """Start of a watch without a token.

    NOW: changes from now on. SNAPSHOT: the current state that passes the filter, then its changes.
    """

    NOW = "now"
    SNAPSHOT = "snapshot"


class WatchKind(str, enum.Enum):
    """Content of a watch.

    EVENTS: the events. OBJECTS: the states of objects. VOLUMES: the leaves of background and
    objects, and the states of the objects.
    """

    EVENTS = "events"
    OBJECTS = "objects"
    VOLUMES = "volumes"


@dataclasses.dataclass(frozen=True)
class WatchOptions:
    """Start and filter of a watch. An item must pass every filter that is set.

    Attributes:
        start: Start without a token.
        resume_token: Token of a Progress with the same filter: the watch continues after it. None:
            see `start`.
        kinds: Content to receive.
        boxes: Selects items that touch one of these boxes, shape (2, 3) each: lowest and highest
            corner, world frame, metres. Empty: anywhere.
        class_ids: Selects objects and events of these classes; empty: any.
        object_ids: Selects these objects and events that concern one of them; empty: any. Events of
            robots have no object: they pass only if boxes, class_ids and object_ids are all empty.
        include_archived: True to include removed objects.
        resync_if_compacted: If the history after the token was compacted, continue with a Resync
            and a snapshot; otherwise the watch ends with OutOfRangeError.
        takes_patches: True if the caller keeps every received leaf: a Delta may then contain leaf
            patches, with half the bytes or less in a known place. Invalid with NOW.
        max_message_bytes: Upper limit of the message size, in [65536, 4194304]; 0: the server's
            default.
        backoff: Delays between reconnections.
        seed: Seed of the jitter. None: from the system.
        on_retry: Called before each wait for a reconnection with the error and the delay in
            seconds.
    """

    start: Union[WatchStart, str] = WatchStart.SNAPSHOT
    resume_token: Optional[bytes] = None
    kinds: Sequence[Union[WatchKind, str]] = (WatchKind.EVENTS, WatchKind.OBJECTS)
    boxes: Sequence[Any] = ()
    class_ids: Sequence[int] = ()
    object_ids: Sequence[int] = ()
    include_archived: bool = False
    resync_if_compacted: bool = True
    takes_patches: bool = False
    max_message_bytes: int = 0
    backoff: BackoffOptions = BackoffOptions()
    seed: Optional[int] = None
    on_retry: Optional[Callable[[SteadymapError, float], None]] = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", WatchStart(self.start))
        object.__setattr__(self, "kinds", tuple(WatchKind(kind) for kind in self.kinds))
        if not self.kinds:
            raise ValueError("kinds: expected at least one of events, objects and volumes")
        if self.takes_patches and self.start == WatchStart.NOW and self.resume_token is None:
            raise ValueError("takes_patches: requires a start with a snapshot or a token")


_STARTS = {
    WatchStart.NOW: watch_service_pb2.WATCH_START_NOW,
    WatchStart.SNAPSHOT: watch_service_pb2.WATCH_START_SNAPSHOT_THEN_FOLLOW,
}


class _WatchState:
    """State of a watch across its streams. Does no network I/O."""

    def __init__(self, map_name: str, options: WatchOptions) -> None:
        self.token = options.resume_token
        self._map_name = map_name
        self._options = options
        self._backoff = Backoff(options.backoff, options.seed)
        self._step: List[WatchItem] = []
        self._revision: Optional[int] = None  # Of the last Progress.
        self._goodbye_delay_s = 0.0
        self._start_s = 0.0  # Start of the stream, monotonic clock.
        self._was_created = False
        self._got_part = False  # This stream sent a part with a resume token.
        self._part_token = b""  # Of the newest part of the current step.
        self._part_is_snapshot = False

    def request(self) -> watch_service_pb2.WatchMapRequest:
        """Builds the request for the next stream.

        It resumes within the step that the last stream left unfinished, or else after the last
        complete step.
        """
        options = self._options
        self._start_s = time.monotonic()
        self._was_created = False
        self._got_part = False
        request = watch_service_pb2.WatchMapRequest(
            map=self._map_name,
            max_message_bytes=options.max_message_bytes,
            resync_if_compacted=options.resync_if_compacted,
            takes_patches=options.takes_patches,
        )
        if self._part_token:
            request.resume_token = self._part_token
        elif self.token is not None:
            request.resume_token = self.token
        else:
            request.start = _STARTS[options.start]
        for kind in options.kinds:
            kind_name = f"WATCH_KIND_{kind.name}"
            request.filter.kinds.append(watch_service_pb2.WatchKind.Value(kind_name))
        request.filter.boxes.extend(box_to_proto(box) for box in options.boxes)
        request.filter.class_ids.extend(options.class_ids)
        request.filter.object_ids.extend(options.object_ids)
        request.filter.include_archived = options.include_archived
        return request

    def take(self, response: watch_service_pb2.WatchMapResponse) -> List[WatchItem]:
        """Returns the items that may be yielded after this message.

        A step is held back until its Progress: if it were yielded in parts and the stream broke in
        between, its events would be yielded twice. Snapshots may be large and are yielded as they
        arrive: if the stream breaks and the snapshot cannot be continued, the next one begins with
        Created or Resync again.
        """
        if response.HasField("goodbye"):
            delay = response.goodbye.reconnect_after
            self._goodbye_delay_s = delay.seconds + delay.nanos * 1e-9
            return []
        item = item_from_proto(response)
        if isinstance(item, Created):
            return self._take_created(item, response.created.continues_step)
        if item is None:
            return []
        self._note_part(response, isinstance(item, Snapshot))
        if isinstance(item, (Snapshot, Resync)):
            return [item]
        self._step.append(item)
        if not isinstance(item, Progress):
            return []
        if item.revision != self._revision:
            self._backoff.reset()
        self._revision = item.revision
        self.token = item.resume_token
        whole, self._step = self._step, []
        return whole

    def _take_created(self, item: Created, continues_step: bool) -> List[WatchItem]:
        self._was_created = True
        self._backoff.note_reached()
        if continues_step:
            return []
        begins_anew = self.token is None or (self._part_token and self._part_is_snapshot)
        self._forget_part()
        return [item] if begins_anew else []

    def _note_part(self, response: watch_service_pb2.WatchMapResponse, is_snapshot: bool) -> None:
        """Stores the resume token of this message; all parts of a step have one, or none has."""
        message = getattr(response, response.WhichOneof("kind"))
        is_part = not isinstance(
            message, (watch_service_pb2.WatchProgress, watch_service_pb2.WatchResync)
        )
        self._part_token = message.resume_token if is_part else b""
        self._part_is_snapshot = is_snapshot
        if self._part_token:
            self._got_part = True
            self._backoff.reset()

    def _forget_part(self) -> None:
        """Drops the current step; it will be sent again from its beginning."""
        self._part_token = b""
        self._step = []

    def delay_after(self, error: Optional[SteadymapError]) -> float:
        """Returns the seconds to wait before the next stream; raises a permanent error.

        `error` None: the server ended the stream with OK.
        """
        was_answered = error is None or is_server_answer(error)
        # A step that the server repeatedly fails to complete must not be requested forever.
        if not self._part_token or (self._was_created and was_answered and not self._got_part):
            self._forget_part()
        error = error or UnavailableError("the server ended the watch")
        if not is_worth_retrying(error):
            raise error
        delay_s = self._backoff.next_delay_s(
            was_answered=was_answered,
            asked_s=max(self._goodbye_delay_s, error.retry_delay_s or 0.0),
            # A watch of an unchanged map may last for hours.
            took_s=0.0 if self._was_created else time.monotonic() - self._start_s,
        )
        self._goodbye_delay_s = 0.0
        if delay_s is None:
            raise error
        if self._options.on_retry is not None:
            self._options.on_retry(error, delay_s)
        return delay_s


class Watch(Iterator[WatchItem]):
    """An iterator over the changes of a map; returned by `Client.watch`.

    Starts with the first `next`, and ends when it is closed. Yields Created, Snapshot chunks if
    requested, and a Progress; then steps: Delta and Events items, completed by a Progress. After a
    broken stream it resumes after the last Progress, or after the received part of a long step, and
    yields no item twice and omits none. If that is impossible, it yields Created or Resync: the
    caller must drop its state. Permanent errors are raised. A context manager; `close` may be
    called from any thread.
    """

    def __init__(
        self, open_channel: Callable[[], grpc.Channel], map_name: str, options: WatchOptions
    ) -> None:
        """Each stream uses a new channel from `open_channel`."""
        self._open_channel = open_channel
        self._state = _WatchState(map_name, options)
        self._closed = threading.Event()
        self._lock = threading.Lock()
        self._call: Optional[grpc.Call] = None  # Guarded by the lock.
        self._items = self._iterate()

    def __enter__(self) -> "Watch":
        return self

    def __exit__(self, kind: object, value: object, traceback: object) -> None:
        self.close()

    def __next__(self) -> WatchItem:
        return next(self._items)

    @property
    def resume_token(self) -> Optional[bytes]:
        """Token of the last complete step; None before the first."""
        return self._state.token

    def close(self) -> None:
        """Ends the watch; a waiting `next` ends with StopIteration."""
        self._closed.set()
        with self._lock:
            if self._call is not None:
                self._call.cancel()

    def _iterate(self) -> Iterator[WatchItem]:
        while not self._closed.is_set():
            error: Optional[SteadymapError] = None
            with self._open_channel() as channel:
                stub = watch_service_pb2_grpc.WatchServiceStub(channel)
                call = stub.WatchMap(self._state.request())
                with self._lock:
                    self._call = call
                try:
                    if not self._closed.is_set():
                        for response in call:
                            yield from self._state.take(response)
                except grpc.RpcError as rpc_error:
                    error = error_from_rpc(rpc_error)
                finally:
                    call.cancel()
            if not self._closed.is_set():
                self._closed.wait(self._state.delay_after(error))


async def watch_asynchronously(
    open_channel: Callable[[], grpc.aio.Channel], map_name: str, options: WatchOptions
) -> AsyncIterator[WatchItem]:
    """Watches a map with asyncio; yields the items that `Watch` yields.

    Closing or cancelling the iteration ends the watch.
    """
    state = _WatchState(map_name, options)
    while True:
        error: Optional[SteadymapError] = None
        async with open_channel() as channel:
            stub = watch_service_pb2_grpc.WatchServiceStub(channel)
            call = stub.WatchMap(state.request())
            try:
                async for response in call:
                    for item in state.take(response):
                        yield item
            except grpc.RpcError as rpc_error:
                error = error_from_rpc(rpc_error)
            finally:
                call.cancel()
        await asyncio.sleep(state.delay_after(error))
