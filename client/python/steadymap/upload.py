"""Uploads frames of one robot to one map, with retries after transient errors."""

import secrets
import threading
import time
from typing import Callable, Iterator, Optional

import grpc

from steadymap._generated.v1 import ingest_service_pb2, ingest_service_pb2_grpc
from steadymap._generated.v1 import map_service_pb2, map_service_pb2_grpc
from steadymap.backoff import Backoff
from steadymap.errors import (
    CancelledError,
    DataLossError,
    DeadlineExceededError,
    FailedPreconditionError,
    SteadymapError,
    UnavailableError,
    error_from_rpc,
    is_server_answer,
    is_worth_retrying,
)
from steadymap.frame import Frame, frame_to_proto
from steadymap.upload_options import AckLevel, UploadOptions, UploadSummary
from steadymap.upload_queue import LossRecovery, LostFrames, UploadProgress, UploadQueue

_CONFIRMATION_TIMEOUT_S = 30.0


_LEVELS = {
    AckLevel.RECEIVED: ingest_service_pb2.ACK_LEVEL_RECEIVED,
    AckLevel.DURABLE: ingest_service_pb2.ACK_LEVEL_DURABLE,
    AckLevel.INTEGRATED: ingest_service_pb2.ACK_LEVEL_INTEGRATED,
}


class _Stream:
    """One UploadFrames call; guarded by the uploader's condition."""

    def __init__(self) -> None:
        self.call: Optional[grpc.Call] = None
        self.opened = False
        self.ended = False
        self.closed = False  # By the server, with OK.
        self.reached_goal = False
        self.error: Optional[SteadymapError] = None  # Client-side; overrides the call's status.

    def fail(self, error: SteadymapError) -> None:
        """Ends the stream with a client-side error."""
        self.error = self.error or error
        if self.call is not None:
            self.call.cancel()


class Uploader:
    """An upload session; returned by `Client.uploader`.

    Frames get the indices 0, 1, ... in the order they are pushed. Transient errors (a lost
    connection, a restarted or draining server, a full disk) are retried with backoff. Only frames
    that are not durable are sent again, and the server integrates each frame once. A permanent
    error ends the upload, and the next `push` or `finish` raises it.

    As a context manager it finishes at the end of the block, or cancels if the block raises. Uses
    one thread of its own and one of gRPC. Thread-safe.
    """

    def __init__(
        self, open_channel: Callable[[], grpc.Channel], map_name: str, options: UploadOptions
    ) -> None:
        """Each stream uses a new channel from `open_channel`."""
        self._open_channel = open_channel
        self._map_name = map_name
        self._options = options
        self._session = options.session or f"upload-{secrets.token_hex(8)}"
        self._changed = threading.Condition()
        recovery = LossRecovery.GO_ON if options.on_lost is not None else LossRecovery.NONE
        if options.read_again is not None:
            recovery = LossRecovery.SEND_AGAIN
        self._queue = UploadQueue(options.max_batch_bytes, options.max_batch_frames, recovery)
        self._stream = _Stream()
        self._reconnections = 0
        self._finishing = False
        self._cancelled = False
        self._done = False
        self._error: Optional[BaseException] = None
        self._thread = threading.Thread(target=self._run, name="steadymap-upload", daemon=True)
        self._thread.start()

    def __enter__(self) -> "Uploader":
        return self

    def __exit__(self, kind: object, value: object, traceback: object) -> None:
        try:
            if kind is None:
                self.finish()
        finally:
            self.close()

    @property
    def session(self) -> str:
        """Id of the upload session."""
        return self._session

    @property
    def progress(self) -> UploadProgress:
        """Current progress of the upload."""
        with self._changed:
            return self._queue.progress(self._reconnections)

    def push(self, frame: Frame) -> None:
        """Accepts a frame and copies its arrays; blocks while the buffer is full.

        Raises the error that ended the upload; FailedPreconditionError after `finish`; ValueError
        for images that cannot be encoded.
        """
        message = frame_to_proto(frame, self._options.encoding)
        with self._changed:
            self._changed.wait_for(self._has_room)
            if self._error is not None:
                raise self._error
            if self._finishing or self._done:
                raise FailedPreconditionError("the upload is already finished")
            self._queue.push(message)
            self._changed.notify_all()

    def finish(self) -> UploadSummary:
        """Waits until every frame has reached `wait_for` or was refused, and ends the upload.

        A refused frame is no error of the upload. Raises the error that ended the upload before
        that.
        """
        with self._changed:
            self._finishing = True
            self._end_where_reached(self._stream)
            self._changed.notify_all()
            self._changed.wait_for(lambda: self._done)
            if self._error is not None:
                raise self._error
            refused = sorted(self._queue.refused, key=lambda frame: frame.index)
            progress = self._queue.progress(self._reconnections)
            return UploadSummary(progress, refused, self._queue.lost)

    def close(self) -> None:
        """Ends the upload at once. Frames that are not durable yet may be lost."""
        with self._changed:
            self._cancelled = True
            if self._stream.call is not None:
                self._stream.call.cancel()
            self._changed.notify_all()
        self._thread.join()

    def _run(self) -> None:
        error: Optional[BaseException] = None
        try:
            error = self._run_streams()
        except Exception as unexpected:  # E.g. from a callback; `finish` raises it.
            error = unexpected
        with self._changed:
            self._error = error
            self._done = True
            self._changed.notify_all()

    def _run_streams(self) -> Optional[SteadymapError]:
        backoff = Backoff(self._options.backoff, self._options.seed)
        while True:
            advance_before = self._advance()
            start_s = time.monotonic()
            with self._open_channel() as channel:
                error = self._run_stream(channel)
            if self._advance() > advance_before:
                backoff.reset()
            if error is None or not is_worth_retrying(error):
                return error
            # An opened stream may have been idle for hours, so its duration does not count.
            counts = not self._stream.opened and self._options.sleep is None
            took_s = time.monotonic() - start_s if counts else 0.0
            delay_s = backoff.next_delay_s(
                was_answered=self._stream.closed or is_server_answer(error),
                asked_s=error.retry_delay_s or 0.0,
                took_s=took_s,
            )
            if delay_s is None or not self._wait_before_retry(error, delay_s):
                return error

    def _advance(self) -> int:
        progress = self.progress
        return progress.durable + progress.integrated + progress.refused

    def _wait_before_retry(self, error: SteadymapError, delay_s: float) -> bool:
        """Returns True if the upload shall be tried again."""
        if self._options.on_retry is not None:
            self._options.on_retry(error, delay_s)
        if self._options.sleep is not None:
            self._options.sleep(delay_s)
        with self._changed:
            if self._options.sleep is None:
                self._changed.wait_for(lambda: self._cancelled, delay_s)
            self._reconnections += 1
            return not self._cancelled

    def _run_stream(self, channel: grpc.Channel) -> Optional[SteadymapError]:
        """Runs one stream; returns the error that ended it, or None if the upload is complete."""
        stream = _Stream()
        stub = ingest_service_pb2_grpc.IngestServiceStub(channel)
        call = stub.UploadFrames(self._requests(stream))
        with self._changed:
            stream.call = call
            self._stream = stream
            if self._cancelled or stream.error is not None:  # Cancelled before the call existed.
                call.cancel()
        error: Optional[SteadymapError] = None
        try:
            for response in call:
                self._take(stream, response)
            stream.closed = True
        except grpc.RpcError as rpc_error:
            error = error_from_rpc(rpc_error)
        finally:
            with self._changed:
                stream.ended = True
                call.cancel()  # Has an effect only if a callback raised.
                self._changed.notify_all()
        if self._cancelled:
            return CancelledError("the upload was cancelled")
        if stream.reached_goal:
            return None
        if stream.error is not None or error is not None:
            return stream.error or error
        return self._confirm(channel)

    def _requests(self, stream: _Stream) -> Iterator[ingest_service_pb2.UploadFramesRequest]:
        """Yields the messages to send; runs in a thread of gRPC."""
        yield self._open_message()
        with self._changed:
            if not self._changed.wait_for(
                lambda: stream.opened or self._is_over(stream), self._options.open_timeout_s
            ):
                message = (
                    "the server did not answer the opening of the upload within "
                    f"{self._options.open_timeout_s} s"
                )
                stream.fail(DeadlineExceededError(message))
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._is_over(stream) or self._writer_has_work())
                if self._is_over(stream):
                    return
                missing = self._queue.frame_to_read_again()
                request = None
                if missing is None:
                    try:
                        request = self._queue.take_batch()
                    except SteadymapError as error:
                        stream.fail(error)
                        return
            if missing is not None:
                if not self._read_again(stream, missing):
                    return
            elif request is None:
                return  # All frames are sent and no more will be pushed.
            else:
                yield request

    def _read_again(self, stream: _Stream, index: int) -> bool:
        """Reads a lost frame again; returns True if the stream can continue."""
        error: Optional[SteadymapError] = None
        try:
            message = frame_to_proto(self._options.read_again(index), self._options.encoding)
        except Exception as cause:  # Any exception of the caller's function.
            error = DataLossError(
                f"the server lost frame {index}, which it had acknowledged as durable, and it could "
                f"not be read again: {cause!r}"
            )
            error.__cause__ = cause
        with self._changed:
            if error is not None:
                stream.fail(error)
                return False
            self._queue.fill_in(index, message)
            return True

    def _open_message(self) -> ingest_service_pb2.UploadFramesRequest:
        request = ingest_service_pb2.UploadFramesRequest()
        request.open.map = self._map_name
        request.open.robot = self._options.robot
        request.open.sensor = self._options.sensor
        request.open.session = self._session
        # The first level reports the refused frames.
        levels = [AckLevel.DURABLE, AckLevel.INTEGRATED]
        if self._options.wait_for is AckLevel.RECEIVED:
            levels.insert(0, AckLevel.RECEIVED)
        request.open.ack_levels.extend(_LEVELS[level] for level in levels)
        with self._changed:
            request.open.last_durable_client_seq = self._queue.durable
        return request

    def _take(self, stream: _Stream, response: ingest_service_pb2.UploadFramesResponse) -> None:
        kind = response.WhichOneof("kind")
        lost: Optional[LostFrames] = None
        with self._changed:
            try:
                if kind == "opened":
                    lost = self._queue.open(response.opened)
                    stream.opened = True
                elif kind == "ack":
                    self._queue.acknowledge(response.ack)
                elif kind == "credit":
                    self._queue.grant(response.credit)
            except SteadymapError as error:
                stream.fail(error)
            self._end_where_reached(stream)
            progress = self._queue.progress(self._reconnections)
            self._changed.notify_all()
        if lost is not None and self._options.on_lost is not None:
            self._options.on_lost(lost)
        if kind == "ack" and self._options.on_progress is not None:
            self._options.on_progress(progress)

    def _end_where_reached(self, stream: _Stream) -> None:
        if not (stream.opened and self._finishing and self._has_reached_goal()):
            return
        stream.reached_goal = True
        if self._options.wait_for is not AckLevel.INTEGRATED:
            # Otherwise the server integrates all frames before it ends the stream.
            stream.call.cancel()

    def _confirm(self, channel: grpc.Channel) -> Optional[SteadymapError]:
        """Requests the session's state after a stream that ended with OK.

        The acknowledgement of frames that an earlier, broken stream uploaded may be lost.
        """
        with self._changed:
            if not self._finishing or not self._queue.all_sent:
                return UnavailableError("the server ended the upload before all frames were sent")
        request = ingest_service_pb2.GetUploadStateRequest(
            map=self._map_name,
            robot=self._options.robot,
            sensor=self._options.sensor,
            session=self._session,
        )
        stub = ingest_service_pb2_grpc.IngestServiceStub(channel)
        try:
            state = stub.GetUploadState(request, timeout=_CONFIRMATION_TIMEOUT_S)
        except grpc.RpcError as rpc_error:
            return error_from_rpc(rpc_error)
        ack = ingest_service_pb2.UploadAck(
            level=_LEVELS[AckLevel.INTEGRATED],
            client_seq=state.integrated_client_seq,
            revision=self._ask_for_revision(channel),
        )
        with self._changed:
            try:
                self._queue.acknowledge(ack)
            except SteadymapError as error:
                return error
            if self._has_reached_goal():
                return None
        return UnavailableError("the server ended the upload before all frames were integrated")

    def _ask_for_revision(self, channel: grpc.Channel) -> int:
        """Returns the revision of the map; 0 if this client lacks the permission to read it."""
        request = map_service_pb2.GetMapRequest(name=self._map_name)
        request.read_mask.paths.append("state.revision")
        stub = map_service_pb2_grpc.MapServiceStub(channel)
        try:
            return stub.GetMap(request, timeout=_CONFIRMATION_TIMEOUT_S).state.revision
        except grpc.RpcError:
            return 0

    def _has_reached_goal(self) -> bool:
        """True if every pushed frame has the requested level or was refused."""
        reached = {
            AckLevel.RECEIVED: max(self._queue.received, self._queue.durable),
            AckLevel.DURABLE: self._queue.durable,
            AckLevel.INTEGRATED: self._queue.integrated,
        }
        return reached[self._options.wait_for] >= self._queue.last_pushed

    def _has_room(self) -> bool:
        has_room = self._queue.buffered_bytes < self._options.max_buffered_bytes
        return self._done or self._finishing or has_room

    def _writer_has_work(self) -> bool:
        if self._queue.can_take_batch() or self._queue.frame_to_read_again() is not None:
            return True
        return self._finishing and self._queue.all_sent

    def _is_over(self, stream: _Stream) -> bool:
        return stream.ended or self._cancelled or stream.error is not None
