"""Delays between attempts."""

import dataclasses
import random
from typing import Optional


@dataclasses.dataclass(frozen=True)
class BackoffOptions:
    """Exponentially growing, jittered delays; all times in seconds.

    Attributes:
        first_delay_s: Delay before the first retry.
        max_delay_s: Longest delay, before jitter, after an attempt that a server answered.
        max_unanswered_delay_s: Longest delay, before jitter, after an attempt without an answer. It
            is shorter than `max_delay_s`: such an attempt costs no server time, and a long delay
            postpones the reconnection to a restarted server.
        factor: Ratio of each delay to the previous one, at least 1.
        jitter: Each delay is multiplied by a random factor in [1 - jitter, 1 + jitter]; in [0, 1).
            Robots of a fleet lose their server at the same moment; jitter spreads their
            reconnections.
        give_up_after_s: Retrying ends after this time without a success.
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
    """Computes the delays. Same rules as client/transport/backoff.h.

    Uses no clock: the elapsed time is the sum of the returned delays and of `took_s`.
    """

    def __init__(self, options: BackoffOptions, seed: Optional[int] = None) -> None:
        """Equal seeds give equal delays; None takes a seed from the system."""
        self._options = options
        self._random = random.Random(seed)
        self._next_s = options.first_delay_s
        self._waited_s = 0.0

    def reset(self) -> None:
        """Records a success: resets the delays and the time counted against `give_up_after_s`."""
        self._next_s = self._options.first_delay_s
        self._waited_s = 0.0

    def note_reached(self) -> None:
        """Records that a server was reached without a success.

        Resets the time counted against `give_up_after_s`; the delays keep growing.
        """
        self._waited_s = 0.0

    def next_delay_s(
        self, *, was_answered: bool = True, asked_s: float = 0.0, took_s: float = 0.0
    ) -> Optional[float]:
        """Returns the next delay, or None if the time since the last success exceeds the limit.

        Args:
            was_answered: True if a server answered the failed attempt.
            asked_s: Delay requested by the server. The jittered delay is added to it, so that the
                clients of one server do not reconnect at the same moment.
            took_s: Duration of the attempt, counted against `give_up_after_s`.
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
