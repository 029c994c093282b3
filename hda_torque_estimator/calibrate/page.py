"""The page of a calibration: one HTML file that needs no network and no other file."""

from collections.abc import Sequence
from typing import Any

from .calibration import Calibration
from ..least_squares.bounds import declaration
from ..pages.badge import Badge
from ..pages.render import render
from ..pages.wording import short, spoken

BETTER = Badge('healthy', 'Calibrated', 'every joint was calibrated')
PARTLY = Badge('ambiguous', 'Partly calibrated', 'a joint stays as it was')


def page(found: Calibration, *, out: str, arm: str, bags: Sequence[str], version: str) -> str:
    """Return a calibration as one HTML document; all text in it is escaped."""
    joints = found.report()['joints']
    return render(
        'calibration.html', title='Calibration', joints=[_joint(one) for one in joints],
        badge=PARTLY if any(one['kept'] for one in joints) else BETTER,
        headline=_headline(joints), out=out,
        facts=[('arm as given', arm), ('model file', out), *(
            (f'recording {place}', bag) for place, bag in enumerate(bags, 1)),
            ('version', version)])


def _headline(joints: Sequence[dict[str, Any]]) -> str:
    """Return what became of the torque of each joint, in one sentence."""
    sentence = '; '.join(map(_became, joints))
    return f'{sentence[:1].upper()}{sentence[1:]}.'


def _became(report: dict[str, Any]) -> str:
    joint, before, after = spoken(report['joint']), short(report['before']), short(report['after'])
    if report['kept']:
        return f'{joint} stays as it was'
    if report.get('motor') and not report['after']:
        return f'the torque of {joint} is off by {short(report["motor"])} N·m by its motor alone'
    if before == after:
        return f'the torque of {joint} is off by {after} N·m, as before'
    return f'the torque of {joint} is off by {after} N·m instead of {before}'


def _joint(report: dict[str, Any]) -> dict[str, Any]:
    """Return what the page shows of one joint, however it was calibrated."""
    polynomial = report.get('polynomial')
    errors = [(name, report[key]) for name, key in (
        ('arm as given', 'before'), ('calibrated', 'after'), ('by the motor alone', 'motor'))
        if report.get(key, 0.0) > 0.0]
    if polynomial is not None:
        errors.append(('polynomial of degree 5', polynomial))
    most = max((value for _, value in errors), default=0.0) or 1.0
    seen = report.get('held_out', True)
    meant = [{**one, 'meaning': declaration(one['name']).meaning}
             for one in report.get('numbers', [])]
    return {**report, 'numbers': meant,
            'errors': [(name, value, value / most) for name, value in errors],
            'torque': report.get('torque', report.get('reference', 0.0)),
            'scale': report.get('scale', ''), 'nominal': report.get('nominal', []),
            'doubtful': report.get('doubtful', []),
            'where': 'where the fit has not seen' if seen else 'on the only recording'}
