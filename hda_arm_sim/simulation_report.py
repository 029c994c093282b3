"""What the simulator says of itself."""

from .health import Level, Refusals, Report
from .live import LiveArm
from .schedule import Punctuality

SLOW = 0.99             # of the rate that was asked for: below it the arm is behind real time


def simulation_report(kept: Punctuality, live: LiveArm, refusals: Refusals) -> Report:
    """Return the report of the second that passed."""
    settings = live.settings
    wanted = 1e9 / settings.period * settings.speed
    level, message = Level.OK, f'{kept.rate:.1f} Hz'
    if refused := refusals.take_new():
        level, message = Level.WARN, f'{refused} messages refused, {message}'
    if kept.skipped > 0.0 or kept.rate < SLOW * wanted:
        level = Level.WARN
        message = f'behind real time: {kept.rate:.1f} Hz instead of {wanted:.1f} Hz'
    return Report(level, message, {
        'rate [Hz]': kept.rate,
        'rate asked for [Hz]': wanted,
        'worst lateness [ms]': kept.worst * 1e3,
        'late samples': kept.late,
        'time given up [s]': kept.skipped,
        'commands beyond the torque limit': live.saturated,
        'times without a fresh command': live.expired,
        **refusals.values()})
