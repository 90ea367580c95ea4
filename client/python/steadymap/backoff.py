"""How long to wait between tries."""

import dataclasses
import random
from typing import Optional


@dataclasses.dataclass(frozen=True)
class BackoffOptions:
    """Exponentially growing, jittered delays; all times in seconds.

    Attributes:
        first_delay_s: before the first retry.
        max_delay_s: no delay is longer, jitter aside.
        factor: each delay against the one before, at least 1.
        jitter: delays vary by this share of themselves, in [0, 1), so that a fleet does not return
            to a restarted server all at once.
        give_up_after_s: without any success for this long in delays, the retrying ends.
    """

    first_delay_s: float = 0.1
    max_delay_s: float = 5.0
    factor: float = 2.0
    jitter: float = 0.2
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
    """Gives the delays; knows no clock: it counts the delays it gave."""

    def __init__(self, options: BackoffOptions, seed: Optional[int] = None) -> None:
        """Equal seeds give equal delays; None takes one from the system."""
        self._options = options
        self._random = random.Random(seed)
        self._next_s = options.first_delay_s
        self._waited_s = 0.0

    def reset(self) -> None:
        """Notes a success: the delays start over."""
        self._next_s = self._options.first_delay_s
        self._waited_s = 0.0

    def next_delay_s(self, at_least_s: float = 0.0) -> Optional[float]:
        """The next delay, no less than the service asks for, or None once the delays since the last
        success exceed the limit."""
        if self._waited_s > self._options.give_up_after_s:
            return None
        spread = self._random.uniform(-self._options.jitter, self._options.jitter)
        delay_s = max(self._next_s * (1.0 + spread), at_least_s)
        self._waited_s += delay_s
        self._next_s = min(self._next_s * self._options.factor, self._options.max_delay_s)
        return delay_s
