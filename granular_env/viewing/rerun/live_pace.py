"""The pace of a live view: twenty looks a second of wall time, and not faster than the run is to be watched."""

from __future__ import annotations

from time import perf_counter, sleep

FRAME_SECONDS = 0.05
# A frame that is due within this part of that time is sent now.
_EARLY = 0.1
# What is due within this part of it is gone to in one go.
_NEAR = 0.25
_LONGEST_STRIDE = 1 << 40


class Pace:
    """Chooses the ticks at which frames are sent, and waits where a run is ahead of its pace.

    Without a pace, the ticks follow from how fast the run advances. With one, they are evenly spaced in simulated time, and
    only a run that is too slow for that is looked at in between.
    """

    def __init__(self, ticks_per_second: float | None = None) -> None:
        """Begin at tick 0.

        Args:
            ticks_per_second: the most ticks in a second of wall time; None for as many as the run can do.
        """
        self._pace = ticks_per_second
        self._spacing = None if ticks_per_second is None else max(1.0, ticks_per_second * FRAME_SECONDS)
        self._rate: float | None = None
        self._sent, self._sends = -float("inf"), False
        self.restart(0)

    def restart(self, tick: int) -> None:
        """Count from this tick and this moment on."""
        self._left_tick, self._left = tick, perf_counter()
        self._origin_tick, self._origin = tick, self._left
        self._due = self._left

    def arrive(self, tick: int) -> bool:
        """Tell whether a frame is to be sent of this tick; wait before, if the run is ahead of its pace."""
        now = perf_counter()
        if tick > self._left_tick:
            self._rate = (tick - self._left_tick) / max(now - self._left, 1e-9)
        even = False
        if self._pace is not None:
            ahead = self._origin + (tick - self._origin_tick) / self._pace - now
            if ahead > 0.0:
                sleep(ahead)
                now = perf_counter()
            elif ahead < -FRAME_SECONDS:
                # What was lost is not caught up: the frames in between would be missing.
                self._origin -= ahead
            even = tick == self._next_even(tick - 1) and now >= self._sent + 0.5 * FRAME_SECONDS
        self._sends = even or now >= self._due - _EARLY * FRAME_SECONDS
        if self._sends:
            self._sent = now
        return self._sends

    def leave(self, tick: int) -> int:
        """Return the tick at which to look next, when whatever was to be done at this one is done."""
        now = perf_counter()
        if self._sends:
            # Frames take at most half of the time, however large they are.
            self._due = self._sent + max(FRAME_SECONDS, 2.0 * (now - self._sent))
        self._left_tick, self._left = tick, now
        upcoming = tick + max(1, int(min((self._rate or 0.0) * self._ahead(self._due - now), _LONGEST_STRIDE)))
        return upcoming if self._pace is None else min(upcoming, self._next_even(tick))

    def _ahead(self, seconds: float) -> float:
        """Return how far to go towards a frame that is due in so many seconds: half, as speeds change, and all when near."""
        return max(0.0, seconds if seconds <= _NEAR * FRAME_SECONDS else 0.5 * seconds)

    def _next_even(self, tick: int) -> int:
        """Return the first tick after this one that is a multiple of the even spacing."""
        assert self._spacing is not None
        number = int((tick - self._origin_tick) / self._spacing)
        while (even := self._origin_tick + round(number * self._spacing)) <= tick:
            number += 1
        return even
