"""Which recordings have one rate, so that they can be diagnosed together."""

from collections.abc import Mapping

from .recording_checks import GateError

# Choices unless stated otherwise.
ONE_RATE = 0.02         # relative difference that drivers of one arm have on other days


def rates_differ(rates: Mapping[str, float]) -> tuple[str, ...]:
    """Return a sentence on recordings by their rates [samples/s], none where they have one."""
    most, least = max(rates.values()), min(rates.values())
    if most / least - 1.0 <= ONE_RATE:
        return ()
    told = ', '.join(f'{source} {rate:.4g} Hz' for source, rate in rates.items())
    return f'The recordings have other rates: {told}. All are taken as the slowest was recorded.',


def check_rate(rate: float, source: str, first_rate: float, first: str) -> None:
    """Raise GateError unless the rate of a recording is that of the first [samples/s]."""
    if abs(rate / first_rate - 1.0) > ONE_RATE:
        raise GateError(
            f'{source} has {rate:.5g} samples per second where {first} has {first_rate:.5g}; '
            f'diagnose recordings together whose rates differ by {100.0 * ONE_RATE:g} % at most, '
            'others one by one with --each')
