"""Processor times of repeated runs, and words for them."""
import statistics


class Times:
    """Processor times, s, of repetitions of one thing."""

    def __init__(self, seconds):
        self.seconds = list(seconds)

    @property
    def least(self):
        return min(self.seconds)

    @property
    def median(self):
        return statistics.median(self.seconds)

    def __add__(self, other):
        return Times(a + b for a, b in zip(self.seconds, other.seconds, strict=True))


def repeated(run, repetitions):
    """The last result of run(), which says its own processor_seconds, and the times of all."""
    results = [run() for _ in range(repetitions)]
    return results[-1], Times(result.processor_seconds for result in results)


def digits(value):
    return f"{value:.3g}" if abs(value) < 1000.0 else f"{value:.0f}"


def spread(values):
    """Median and range."""
    values = sorted(values)
    if not values:
        return "none"
    return f"{digits(statistics.median(values))} ({digits(values[0])} to {digits(values[-1])})"
