"""How long to wait between tries."""

import dataclasses
import random
from typing import Optional


@dataclasses.dataclass(frozen=True)
class BackoffOptions:
    """Exponentially growing, jittered delays; all times in seconds.

    Attributes:
        first_delay_s: before the first retry.
        max_delay_s: no delay is longer, jitter aside, where a server had answered.
        max_unanswered_delay_s: no delay is longer, jitter aside, where none had: a try that nobody
            hears costs little, and who waits long between two comes back late to a server that is
            there again.
        factor: each delay against the one before, at least 1.
        jitter: delays vary by this share of themselves, in [0, 1): a fleet loses its server at the
            same moment, and must not come back to it at the same moment.
        give_up_after_s: without any success for this long, the retrying ends.
    """

    first_delay_s: float = 0.1
    max_delay_s: float = 5.0
    max_unanswered_delay_s: float = 0.5
    factor: float = 2.0
    jitter: float = 0.5
    give_up_after_s: float = 60.0

    def __post_init__(self) -> None:
        if not (self.first_delay_s > 0 and self.max_delay_s >= self.first_delay_s):
            raise ValueError(
                "backoff: expected 0 < first_delay_s <= max_delay_s, "
                f"got {self.first_delay_s} and {self.max_delay_s}"
            )
        if not (self.factor >= 1 and 0 <= self.jitter < 1):
            raise ValueError(
                "backoff: expected factor >= 1 and jitter in [0, 1), "
                f"got {self.factor} and {self.jitter}"
            )


class Backoff:
    """Gives the delays; knows no clock: it counts the delays it gave, and what tries are said to
    have taken. The same rules as client/transport/backoff.h of the C++ client."""

    def __init__(self, options: BackoffOptions, seed: Optional[int] = None) -> None:
        """Equal seeds give equal delays; None takes one from the system."""
        self._options = options
        self._random = random.Random(seed)
        self._next_s = options.first_delay_s
        self._waited_s = 0.0

    def reset(self) -> None:
        """Notes a success: the delays and the time to give up after start over."""
        self._next_s = self._options.first_delay_s
        self._waited_s = 0.0

    def note_reached(self) -> None:
        """Notes that there is a server, though nothing came of it: the time to give up after starts
        over, the delays go on growing."""
        self._waited_s = 0.0

    def next_delay_s(
        self, *, was_answered: bool = True, asked_s: float = 0.0, took_s: float = 0.0
    ) -> Optional[float]:
        """The next delay, or None once the time since the last success exceeds the limit.

        Args:
            was_answered: whether a server answered the try that failed.
            asked_s: the wait that it asked for; the delay comes on top, so that not all come back
                at once.
            took_s: what the try took of the time to give up after.
        """
        self._waited_s += took_s
        if self._waited_s > self._options.give_up_after_s:
            return None
        longest_s = self._options.max_delay_s
        if not was_answered:
            longest_s = min(longest_s, self._options.max_unanswered_delay_s)
        base_s = min(self._next_s, longest_s)
        spread = self._random.uniform(-self._options.jitter, self._options.jitter)
        delay_s = asked_s + base_s * (1.0 + spread)
        self._waited_s += delay_s
        self._next_s = min(base_s * self._options.factor, longest_s)
        return delay_s
