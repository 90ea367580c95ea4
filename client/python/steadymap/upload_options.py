"""How frames are uploaded, and what became of them."""

import dataclasses
import enum
from typing import Callable, List, Optional, Union

from steadymap.backoff import BackoffOptions
from steadymap.errors import SteadymapError
from steadymap.frame import Frame
from steadymap.images import PixelEncoding, default_encoding
from steadymap.upload_queue import LostFrames, RefusedFrame, UploadProgress


class AckLevel(str, enum.Enum):
    """How far a frame has come.

    RECEIVED: validated, in memory. DURABLE: in the log; survives kill -9 and power loss.
    INTEGRATED: part of a committed revision; every later read shows it.
    """

    RECEIVED = "received"
    DURABLE = "durable"
    INTEGRATED = "integrated"


@dataclasses.dataclass(frozen=True)
class UploadOptions:
    """How frames are uploaded.

    Attributes:
        robot: id of the robot that the frames come from, matching `[a-z][a-z0-9-]{0,62}`.
        sensor: id of the sensor on it; two sensors of a robot upload at the same time, each in its
            own session.
        session: id of the upload session, of the same form; None: a random one. Naming it lets a
            later process that pushes the same frames in the same order go on where this one
            stopped.
        encoding: how depth and label arrays travel. None: ZSTD where the package zstandard is
            installed, else RAW.
        wait_for: the level that every frame must have reached when the upload is finished.
        max_batch_bytes, max_batch_frames: a message holds no more, unless one frame is larger.
        max_buffered_bytes: frames that are not durable yet take no more memory; `push` waits.
        open_timeout_s: a server that does not answer the opening for so long counts as unavailable.
        backoff: waits between reconnections.
        seed: of the jitter. None: from the system.
        sleep: replaces the waiting between reconnections, and the clock: tries then take no time. For
            tests. None: really waits.
        on_progress: called after each acknowledgement, from the uploader's thread; it must not call
            the uploader.
        read_again: gives a frame once more, by its index among those that were pushed: for frames of
            a recording. If the service has lost frames that it had acknowledged, they are read and
            sent again, in their order and before those behind. Called from a thread of the uploader;
            it must not call the uploader. What it raises ends the upload. None: they are gone.
        on_lost: called from the uploader's thread when the service turns out to have lost frames.
            Without `read_again` and with this, as a robot that uploads what it sees has it, the
            upload goes on behind them and counts them as lost. Without both it ends with
            DataLossError.
        on_retry: called likewise before each wait for a reconnection, with what went wrong and the
            seconds to wait.
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
    """What became of an upload.

    Attributes:
        progress: at the end.
        refused: frames that the service refused, in the order of their indices; the first 1000.
        lost: frames that the service lost and that were not sent again, by rising indices.
    """

    progress: UploadProgress
    refused: List[RefusedFrame]
    lost: List[LostFrames] = dataclasses.field(default_factory=list)
