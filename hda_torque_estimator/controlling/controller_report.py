"""What the controller says of itself."""

from hda_arm_sim.health import Level, Pace, Refusals, Report

from .live_controller import LiveController


def controller_report(live: LiveController, pace: Pace, refusals: Refusals) -> Report:
    """Return the report of the second that passed."""
    refused = refusals.take_new()
    level, message = Level.OK, f'enabled, {pace.rate:.1f} Hz' if live.enabled else 'disabled'
    if live.stopped:
        level, message = Level.ERROR, f'stopped: {live.stopped}'
    elif refused:
        level, message = Level.WARN, f'{refused} messages refused, {message}'
    return Report(level, message, {
        **pace.values(),
        'enabled': live.enabled,
        'samples answered': live.answered,
        'samples lost': live.gaps.lost,
        'commands at the torque limit': live.limited,
        'torque feedback K_J': live.controller.settings.torque_feedback,
        **refusals.values()})
