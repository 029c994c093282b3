"""Which recordings have one rate, so that they can be diagnosed together."""

from .recording_checks import GateError

# Choices unless stated otherwise.
ONE_RATE = 0.02         # relative difference that drivers of one arm have on other days


def check_rate(rate: float, source: str, first_rate: float, first: str) -> None:
    """Raise GateError unless the rate of a recording is that of the first [samples/s]."""
    if abs(rate / first_rate - 1.0) > ONE_RATE:
        raise GateError(
            f'{source} has {rate:.5g} samples per second where {first} has {first_rate:.5g}; '
            f'diagnose recordings together whose rates differ by {100.0 * ONE_RATE:g} % at most')
