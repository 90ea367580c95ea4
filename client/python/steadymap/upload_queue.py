"""State of an upload session: pending frames, acknowledgements and flow-control credit.

Pure state: no threads, clock or network. Same rules as client/upload/upload_queue.h.
"""

import collections
import dataclasses
import enum
from typing import Deque, List, Optional, Set, Tuple

from steadymap._generated.v1 import frame_pb2, ingest_service_pb2
from steadymap.checksum import extend_crc32c
from steadymap.errors import (
    DataLossError,
    InternalError,
    ResourceExhaustedError,
    SteadymapError,
    error_from_status,
)

# Enough for a diagnosis; bounds the memory for a robot that sends only invalid frames.
_MAX_KEPT_REFUSALS = 1000

# Upper bounds of the bytes that tags, lengths, sequence and checksum add to a message and to each
# of its frames.
_ENVELOPE_BYTES = 32
_FRAME_ENVELOPE_BYTES = 6

_UNLIMITED_BYTES = 1 << 62  # For a server without a limit.


@dataclasses.dataclass(frozen=True)
class RefusedFrame:
    """A frame refused by the service.

    Attributes:
        index: Index among the frames of the upload, from 0.
        error: Error with reason and field path.
    """

    index: int
    error: SteadymapError


@dataclasses.dataclass(frozen=True)
class LostFrames:
    """Frames that the service had acknowledged as durable and no longer has.

    This happens, for example, after its disk was restored from an older copy.

    Attributes:
        first, last: Indices among the frames of the upload, from 0, both included.
    """

    first: int
    last: int


class LossRecovery(enum.Enum):
    """Policy for lost frames: NONE is an error, GO_ON gives them up, SEND_AGAIN resends them."""

    NONE = "none"
    GO_ON = "go_on"
    SEND_AGAIN = "send_again"


@dataclasses.dataclass(frozen=True)
class UploadProgress:
    """Progress of an upload: counts of frames since its start.

    A refused frame is counted in `pushed`, `sent` and `refused` only. Only the levels can decrease,
    when the service has lost frames that it had acknowledged.

    Attributes:
        pushed: Passed to the uploader.
        sent: Sent at least once.
        received: Validated and held in the server's memory; known only if `wait_for` is RECEIVED,
            else equal to `durable`.
        durable: Stored on the server's disk.
        integrated: Part of a committed revision.
        refused: Refused by the service.
        lost: Were durable, are missing on the server and were not resent.
        sent_again: Repeated transmissions after reconnections.
        reconnections: Streams opened after the first.
        bytes_sent: Bytes of serialized batches.
        revision: Newest revision named by an acknowledgement. If an earlier stream integrated the
            frames and its acknowledgements were lost: the revision of the map when the client
            confirmed the integration.
    """

    pushed: int = 0
    sent: int = 0
    received: int = 0
    durable: int = 0
    integrated: int = 0
    refused: int = 0
    lost: int = 0
    sent_again: int = 0
    reconnections: int = 0
    bytes_sent: int = 0
    revision: int = 0


class UploadQueue:
    """Frames by client sequence, credit, and batches.

    The caller bounds its memory: it pushes only while `buffered_bytes` is below a limit.
    """

    def __init__(
        self,
        max_batch_bytes: int,
        max_batch_frames: int,
        recovery: LossRecovery = LossRecovery.NONE,
    ) -> None:
        self._recovery = recovery
        self._max_batch_bytes = max_batch_bytes
        self._max_batch_frames = max_batch_frames
        self._max_message_bytes = _UNLIMITED_BYTES
        # Client sequences `durable + 1` to `last_pushed` with their serialized bytes. None: must be
        # read again.
        self._pending: Deque[Tuple[Optional[frame_pb2.Frame], int]] = collections.deque()
        self.buffered_bytes = 0
        self.last_pushed = 0
        self._next_to_send = 1
        self._highest_sent = 0
        self.received = 0
        # All frames up to `received`, `durable` and `integrated` have this level or are refused.
        self.durable = 0
        self.integrated = 0
        self._credit_bytes = 0
        self._credit_frames = 0
        self._refused_ahead: Set[int] = set()  # Refused sequences above `integrated`.
        self._refused_behind = 0  # Number of refused sequences up to `integrated`.
        self._was_refused = bytearray()  # By client sequence - 1, up to the last refused one.
        self._given_up: List[Tuple[LostFrames, int]] = []  # With the number of frames not refused.
        self.refused: List[RefusedFrame] = []
        self._sent_again = 0
        self._bytes_sent = 0
        self._revision = 0

    @property
    def all_sent(self) -> bool:
        """True if every pushed frame was sent on this stream or was durable before it."""
        return self._next_to_send > self.last_pushed

    def push(self, frame: frame_pb2.Frame) -> None:
        """Appends a frame and assigns it the next client sequence."""
        self.last_pushed += 1
        if self.last_pushed <= self.durable:
            return  # An earlier run of this session uploaded it.
        frame_bytes = frame.ByteSize()
        self._pending.append((frame, frame_bytes))
        self.buffered_bytes += frame_bytes

    @property
    def lost(self) -> List[LostFrames]:
        """Frames that were given up, in ascending order."""
        return [frames for frames, _ in self._given_up]

    def open(self, opened: ingest_service_pb2.UploadOpened) -> Optional[LostFrames]:
        """Restarts at the server's resume point.

        Returns the frames newly detected as lost, or None. DataLossError if frames are lost and
        there is no recovery.
        """
        resume = opened.resume_client_seq
        lost: Optional[LostFrames] = None
        if resume >= self.durable:
            self._settle(resume)
        elif self._recovery is LossRecovery.SEND_AGAIN:
            lost = LostFrames(resume, self.durable - 1)
            self._miss_again(resume)
        elif self._recovery is LossRecovery.GO_ON:
            lost = self._give_up(resume)
        else:
            raise DataLossError(
                f"the server acknowledged frames up to {self.durable} of this session as durable, "
                f"but now has only frames up to {resume}"
            )
        self._next_to_send = self.durable + 1
        self._credit_bytes = opened.credit.bytes
        self._credit_frames = opened.credit.frames
        self._max_message_bytes = opened.max_message_bytes or _UNLIMITED_BYTES
        return lost

    def frame_to_read_again(self) -> Optional[int]:
        """Returns the index of the first frame of the next batch that must be read again.

        None if there is no such frame or no credit.
        """
        end = self._next_to_send + min(self._credit_frames, self._max_batch_frames)
        batch_bytes = 0
        for client_seq in range(self._next_to_send, min(end, self.last_pushed + 1)):
            frame, frame_bytes = self._pending[client_seq - self.durable - 1]
            if frame is None:
                return client_seq - 1
            batch_bytes += frame_bytes
            if batch_bytes >= self._max_batch_bytes:
                return None
        return None

    def fill_in(self, index: int, frame: frame_pb2.Frame) -> None:
        """Supplies the frame named by `frame_to_read_again`."""
        frame_bytes = frame.ByteSize()
        self._pending[index - self.durable] = (frame, frame_bytes)
        self.buffered_bytes += frame_bytes

    def grant(self, credit: ingest_service_pb2.UploadCredit) -> None:
        """Adds flow-control credit."""
        self._credit_bytes += credit.bytes
        self._credit_frames += credit.frames

    def acknowledge(self, ack: ingest_service_pb2.UploadAck) -> None:
        """Records an acknowledgement. InternalError if it names a frame that was never sent."""
        if ack.client_seq >= self._next_to_send:
            raise InternalError(
                f"the server acknowledged frame {ack.client_seq}, "
                f"but only {self._next_to_send - 1} were sent",
                reason="INTERNAL",
            )
        for refused in ack.refused:
            self._note_refused(refused)
        if ack.level >= ingest_service_pb2.ACK_LEVEL_RECEIVED:
            self.received = max(self.received, ack.client_seq)
        if ack.level >= ingest_service_pb2.ACK_LEVEL_DURABLE:
            self._settle(ack.client_seq)
        if ack.level >= ingest_service_pb2.ACK_LEVEL_INTEGRATED:
            self._note_integrated(ack.client_seq)
        self._revision = max(self._revision, ack.revision)

    def can_take_batch(self) -> bool:
        """True if `take_batch` would return a batch or raise."""
        if self.all_sent or self._pending[self._next_to_send - self.durable - 1][0] is None:
            return False
        frame_bytes = self._bytes_at(self._next_to_send)
        has_credit = self._credit_frames > 0 and frame_bytes <= self._credit_bytes
        return has_credit or frame_bytes > self._max_message_bytes

    def take_batch(self) -> Optional[ingest_service_pb2.UploadFramesRequest]:
        """Returns the next message, as large as limits and credit allow, or None.

        ResourceExhaustedError / MESSAGE_TOO_LARGE for a frame larger than the largest message.
        """
        if not self.can_take_batch():
            return None
        count = self._choose_frame_count()
        if count == 0:
            raise ResourceExhaustedError(
                f"frame {self._next_to_send - 1} takes {self._bytes_at(self._next_to_send)} bytes, "
                f"but the server takes messages of at most {self._max_message_bytes} bytes",
                reason="MESSAGE_TOO_LARGE",
            )
        first = self._next_to_send - self.durable - 1
        frames = [self._pending[first + i][0] for i in range(count)]
        request = ingest_service_pb2.UploadFramesRequest()
        request.batch.first_client_seq = self._next_to_send
        request.batch.frames.extend(frames)
        request.batch.images_crc32c = _images_crc32c(frames)
        batch_bytes = request.batch.ByteSize()
        self._credit_bytes -= batch_bytes
        self._credit_frames -= count
        self._bytes_sent += batch_bytes
        self._next_to_send += count
        sent_first = max(0, self._next_to_send - 1 - self._highest_sent)
        self._sent_again += count - sent_first
        self._highest_sent += sent_first
        return request

    def progress(self, reconnections: int) -> UploadProgress:
        """Returns the current progress."""
        lost = sum(count for _, count in self._given_up)
        lost_behind = sum(c for frames, c in self._given_up if frames.last < self.integrated)
        return UploadProgress(
            pushed=self.last_pushed,
            sent=self._highest_sent,
            received=self._without_refused(max(self.received, self.durable)) - lost,
            durable=self._without_refused(self.durable) - lost,
            integrated=self._without_refused(self.integrated) - lost_behind,
            refused=self._refused_behind + len(self._refused_ahead),
            lost=lost,
            sent_again=self._sent_again,
            reconnections=reconnections,
            bytes_sent=self._bytes_sent,
            revision=self._revision,
        )

    def _settle(self, client_seq: int) -> None:
        while self.durable < client_seq:
            self.durable += 1
            if self._pending:
                self.buffered_bytes -= self._pending.popleft()[1]

    def _miss_again(self, resume: int) -> None:
        """Marks the lost frames as pending; they are read again when they are sent."""
        missing = max(0, min(self.durable, self.last_pushed) - resume)
        self._pending.extendleft([(None, 0)] * missing)
        self.durable = resume
        self.received = min(self.received, resume)
        self._set_back_integrated(resume)

    def _give_up(self, resume: int) -> Optional[LostFrames]:
        """Continues after the last durable frame; None if all lost frames were given up before."""
        lost = LostFrames(resume, self.durable - 1)
        if self._given_up and self._given_up[-1][0] == lost:
            return None
        self._set_back_integrated(resume)
        while self._given_up and self._given_up[-1][0].first >= lost.first:
            self._given_up.pop()
        last = min(lost.last + 1, self.last_pushed)
        refused = sum(self._was_refused[lost.first : last])
        self._given_up.append((lost, last - lost.first - refused))
        return lost

    def _set_back_integrated(self, client_seq: int) -> None:
        for sequence in range(client_seq + 1, min(self.integrated, len(self._was_refused)) + 1):
            if self._was_refused[sequence - 1]:
                self._refused_ahead.add(sequence)
                self._refused_behind -= 1
        self.integrated = min(self.integrated, client_seq)

    def _note_integrated(self, client_seq: int) -> None:
        for frames, _ in self._given_up:  # Lost frames count as processed.
            if client_seq >= frames.first:
                client_seq = max(client_seq, frames.last + 1)
        self.integrated = max(self.integrated, client_seq)
        behind = {sequence for sequence in self._refused_ahead if sequence <= self.integrated}
        self._refused_ahead -= behind
        self._refused_behind += len(behind)

    def _note_refused(self, refused: ingest_service_pb2.RefusedFrame) -> None:
        client_seq = refused.client_seq
        # Ignores a repeated report after a reconnection and a sequence that was never sent.
        if client_seq in self._refused_ahead:
            return
        if not self.integrated < client_seq < self._next_to_send:
            return
        self._refused_ahead.add(client_seq)
        self._was_refused.extend(bytes(max(0, client_seq - len(self._was_refused))))
        self._was_refused[client_seq - 1] = 1
        if len(self.refused) < _MAX_KEPT_REFUSALS:
            self.refused.append(RefusedFrame(client_seq - 1, error_from_status(refused.status)))

    def _without_refused(self, client_seq: int) -> int:
        ahead = sum(1 for sequence in self._refused_ahead if sequence <= client_seq)
        return min(client_seq, self.last_pushed) - self._refused_behind - ahead

    def _bytes_at(self, client_seq: int) -> int:
        """Returns an upper bound of the bytes of a message with this frame alone."""
        frame_bytes = self._pending[client_seq - self.durable - 1][1]
        return frame_bytes + _FRAME_ENVELOPE_BYTES + _ENVELOPE_BYTES

    def _choose_frame_count(self) -> int:
        available = self.last_pushed + 1 - self._next_to_send
        most_frames = min(available, self._credit_frames, self._max_batch_frames)
        batch_bytes = _ENVELOPE_BYTES
        count = 0
        while count == 0 or count < most_frames:
            if self._pending[self._next_to_send + count - self.durable - 1][0] is None:
                break
            grown = batch_bytes + self._bytes_at(self._next_to_send + count) - _ENVELOPE_BYTES
            if grown > self._max_message_bytes:
                break
            if count > 0 and (grown > self._max_batch_bytes or grown > self._credit_bytes):
                break
            batch_bytes = grown
            count += 1
        return count


def _images_crc32c(frames: List[frame_pb2.Frame]) -> int:
    crc = 0
    for frame in frames:
        for image in (frame.depth, frame.labels, frame.instances, frame.color):
            crc = extend_crc32c(crc, image.data)
    return crc
