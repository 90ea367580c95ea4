"""Options and results of uploads."""

import dataclasses
import enum
from typing import Callable, List, Optional, Union

from steadymap.backoff import BackoffOptions
from steadymap.errors import SteadymapError
from steadymap.frame import Frame
from steadymap.images import PixelEncoding, default_encoding
from steadymap.upload_queue import LostFrames, RefusedFrame, UploadProgress


class AckLevel(str, enum.Enum):
    """Processing level of a frame.

    RECEIVED: validated, in memory. DURABLE: in the log; survives kill -9 and power loss.
    INTEGRATED: part of a committed revision; visible to every later read.
    """

    RECEIVED = "received"
    DURABLE = "durable"
    INTEGRATED = "integrated"


@dataclasses.dataclass(frozen=True)
class UploadOptions:
    """Options of an upload.

    Attributes:
        robot: Id of the robot that recorded the frames; matches `[a-z][a-z0-9-]{0,62}`.
        sensor: Id of the sensor on the robot; two sensors of one robot upload concurrently, each in
            its own session.
        session: Id of the upload session, of the same form as `robot`; None: a random id. With a
            fixed id, a later process that pushes the same frames in the same order continues the
            upload.
        encoding: Wire encoding of depth and label arrays. None: ZSTD if the package zstandard is
            installed, else RAW.
        wait_for: Level that every frame must reach before the upload is finished.
        max_batch_bytes, max_batch_frames: Limits of a message, unless a single frame is larger.
        max_buffered_bytes: Memory limit of frames that are not durable yet; `push` blocks above it.
        open_timeout_s: A server that does not answer the opening within this time counts as
            unavailable.
        backoff: Delays between reconnections.
        seed: Seed of the jitter. None: from the system.
        sleep: Replaces the wait between reconnections and the clock; attempts then take no time.
            For tests. None: waits in real time.
        on_progress: Called after each acknowledgement, from the uploader's thread. Must not call
            the uploader.
        read_again: Returns a pushed frame again, by its index. For frames of a recording. If the
            service has lost frames that it had acknowledged, the uploader reads and resends them in
            order, before all later frames. Called from a thread of the uploader; must not call the
            uploader. An exception ends the upload. None: lost frames cannot be resent.
        on_lost: Called from the uploader's thread when the service has lost frames that it had
            acknowledged. With `on_lost` but without `read_again` (a robot that uploads live
            frames), the upload continues after the lost frames and counts them as lost. Without
            both it ends with DataLossError.
        on_retry: Called from the uploader's thread before each wait for a reconnection with the
            error and the delay in seconds.
    """

    robot: str = "robot"
    sensor: str = "camera"
    session: Optional[str] = None
    encoding: Optional[Union[PixelEncoding, str]] = None
    wait_for: Union[AckLevel, str] = AckLevel.INTEGRATED
    max_batch_bytes: int = 1 << 20
    max_batch_frames: int = 8
    max_buffered_bytes: int = 32 << 20
    open_timeout_s: float = 20.0
    backoff: BackoffOptions = BackoffOptions()
    seed: Optional[int] = None
    sleep: Optional[Callable[[float], object]] = None
    on_progress: Optional[Callable[[UploadProgress], None]] = None
    read_again: Optional[Callable[[int], Frame]] = None
    on_lost: Optional[Callable[[LostFrames], None]] = None
    on_retry: Optional[Callable[[SteadymapError, float], None]] = None

    def __post_init__(self) -> None:
        encoding = default_encoding() if self.encoding is None else PixelEncoding(self.encoding)
        object.__setattr__(self, "encoding", encoding)
        object.__setattr__(self, "wait_for", AckLevel(self.wait_for))
        for name in ("max_batch_bytes", "max_batch_frames", "max_buffered_bytes"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name}: expected at least 1, got {getattr(self, name)}")


@dataclasses.dataclass(frozen=True)
class UploadSummary:
    """Result of an upload.

    Attributes:
        progress: Progress at the end.
        refused: Frames refused by the service, in the order of their indices; the first 1000.
        lost: Frames that the service lost and that were not resent, in ascending order.
    """

    progress: UploadProgress
    refused: List[RefusedFrame]
    lost: List[LostFrames] = dataclasses.field(default_factory=list)
