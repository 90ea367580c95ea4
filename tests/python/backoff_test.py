"""Delays between attempts."""

import unittest

import steadymap
from steadymap.backoff import Backoff


class Delays(unittest.TestCase):
    def test_grow_to_the_longest_and_vary_by_the_jitter(self):
        options = steadymap.BackoffOptions(give_up_after_s=1000.0)
        backoff = Backoff(options, seed=1)
        expected = [0.1, 0.2, 0.4, 0.8, 1.6, 3.2, 5.0, 5.0]
        delays = [backoff.next_delay_s() for _ in expected]
        for delay, middle in zip(delays, expected):
            self.assertLessEqual(abs(delay - middle), 0.5 * middle)
        self.assertNotEqual(delays, expected)
        again = Backoff(options, seed=1)
        self.assertEqual([again.next_delay_s() for _ in expected], delays)

    def test_end_when_nothing_succeeds(self):
        options = steadymap.BackoffOptions(jitter=0.0, give_up_after_s=0.5)
        backoff = Backoff(options)
        self.assertEqual([backoff.next_delay_s() for _ in range(4)], [0.1, 0.2, 0.4, None])
        backoff.reset()
        self.assertEqual(backoff.next_delay_s(), 0.1)

    def test_come_on_top_of_what_the_service_asks(self):
        backoff = Backoff(steadymap.BackoffOptions(jitter=0.0))
        self.assertEqual(backoff.next_delay_s(asked_s=2.0), 2.1)

    def test_stay_short_while_nobody_answers(self):
        backoff = Backoff(steadymap.BackoffOptions(jitter=0.0, max_delay_s=3.0))
        delays = [backoff.next_delay_s(was_answered=False) for _ in range(5)]
        self.assertEqual(delays, [0.1, 0.2, 0.4, 0.5, 0.5])
        delays = [backoff.next_delay_s(was_answered=True) for _ in range(4)]
        self.assertEqual(delays, [0.5, 1.0, 2.0, 3.0])

    def test_end_where_tries_take_the_time(self):
        backoff = Backoff(steadymap.BackoffOptions(jitter=0.0, give_up_after_s=1.0))
        self.assertEqual(backoff.next_delay_s(took_s=0.85), 0.1)
        backoff.note_reached()
        self.assertEqual(backoff.next_delay_s(took_s=0.85), 0.2)
        self.assertIsNone(backoff.next_delay_s(took_s=0.1))

    def test_of_options_that_make_no_sense_are_refused(self):
        for wrong in (
            {"first_delay_s": 0.0},
            {"max_delay_s": 0.01},
            {"factor": 0.5},
            {"jitter": 1.0},
            {"first_delay_s": float("nan")},
        ):
            with self.assertRaises(ValueError):
                steadymap.BackoffOptions(**wrong)


if __name__ == "__main__":
    unittest.main()
