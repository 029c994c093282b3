"""Fig. 10: the kinematic torsion over a turn, and what a quintic and a Fourier series hold."""

from typing import NamedTuple

from hda_arm_sim.foundation.arrays import Array
import numpy as np

from ..rig import bench
from ..rig.exhibit import Arms, Drawing, Exhibit, Look, Panel, PaperNumber, Trace
from ..rig.imperfections import imperfect, TOGETHER
from ..rig.printed import PRINTED
from ..rig.rig_calibration import LINK_ORDERS, SHAFT_ORDERS, waves
from ..rig.shapes import step
from ...samples.readings import LINK_READING, MOTOR_READING

_SPEED, _SECONDS = 0.2, 34.5        # one turn [rad/s], [s]
_TORQUES = (0.0, 3.0, 6.0)          # braking the turn [N*m]
_FITTED = (1, 3.0)                  # direction and torque of the run that is fitted
_WINDOW = (1.0, 1.0 + 0.06 * np.pi)     # three turns of the shaft [rad]


class _Turn(NamedTuple):
    """One turn: angles of link and shaft and the total torsion without its mean [rad]."""

    link: Array
    shaft: Array
    torsion: Array


def kinematic_torsion(arms: Arms) -> Exhibit:
    """Return the torsion of turns both ways under several torques, fitted on one of them."""
    turns = {(sense, torque): _turned(arms, sense, torque)
             for sense in (1, -1) for torque in _TORQUES}
    fitted = turns[_FITTED]
    models = {name: np.linalg.lstsq(basis(fitted), fitted.torsion, rcond=None)[0]
              for name, basis in _BASES.items()}
    held_out = {name: float(np.mean([
        _rms(turn.torsion - _BASES[name](turn) @ model)
        for key, turn in turns.items() if key != _FITTED])) for name, model in models.items()}
    own = {name: _rms(fitted.torsion - _BASES[name](fitted) @ model)
           for name, model in models.items()}
    return Exhibit(_numbers(turns, own, held_out, models['quintic (10)']),
                   _findings(turns, held_out),
                   (_turns(turns, models), _window(turns, models)),
                   ('The curve of the paper: three of its six coefficients are not in the text '
                    '(Table II).',))


def _turned(arms: Arms, sense: int, torque: float) -> _Turn:
    """Return one turn of the imperfect rig at a slow speed, braked by a torque [N*m]."""
    true = imperfect(arms.rig, TOGETHER)
    time = bench.quiet(1, _SECONDS).time
    rate = sense * _SPEED * step(time, 1.0, 2.0 * _SECONDS, 1.0)
    brake = -sense * torque * step(time, 0.6, 2.0 * _SECONDS, 0.5)
    made = bench.follow(true, arms.rig, rate, brake, seed=10 + sense)
    used = made.time > 2.5
    torsion = made.torsion[used, 0]
    return _Turn(made.reading[used, 0, LINK_READING], made.reading[used, 0, MOTOR_READING],
                 torsion - torsion.mean())


def _quintic(turn: _Turn) -> Array:
    """Return the powers of the link angle within its turn."""
    place = np.mod(turn.link, 2.0 * np.pi) / np.pi - 1.0
    return np.asarray(np.polynomial.legendre.legvander(place, 5), float)


def _of_link(turn: _Turn) -> Array:
    return np.stack([np.ones_like(turn.link), *waves(turn.link, LINK_ORDERS)], axis=1)


def _of_both(turn: _Turn) -> Array:
    return np.hstack([_of_link(turn), np.stack(waves(turn.shaft, SHAFT_ORDERS), axis=1)])


_BASES = {'quintic (10)': _quintic, 'Fourier, link orders': _of_link,
          'Fourier, link and shaft orders': _of_both}


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean((values - values.mean()) ** 2)))


def _numbers(turns: dict[tuple[int, float], _Turn], own: dict[str, float],
             held_out: dict[str, float], quintic: Array) -> tuple[PaperNumber, ...]:
    scale = PRINTED.linear_stiffness
    ends = np.polynomial.legendre.legvander(np.array([-1.0, 1.0]), 5) @ quintic
    spread = float(np.mean([_rms(turn.torsion) for turn in turns.values()]))
    rows = [PaperNumber('kinematic torsion, rms', 'N*m', None, None, scale * spread,
                        'as torque at K_f'),
            PaperNumber('jump of the quintic where the turn closes', 'N*m', None,
                        scale * float(abs(ends[1] - ends[0])), 0.0, 'Fourier: none')]
    for name in _BASES:
        printed = name.startswith('quintic')
        for what, value in (('on the turn it is fitted to', own[name]),
                            ('held out', held_out[name])):
            rows.append(PaperNumber(f'{name}, left {what}', 'N*m', None,
                                    scale * value if printed else None,
                                    None if printed else scale * value,
                                    f'{1e6 * value:.1f} urad rms'))
    return (*rows, PaperNumber('difference of both directions, same angle', 'N*m', 0.0, None,
                               scale * _difference(turns[1, 3.0], turns[-1, 3.0]),
                               'paper: unique'),
            PaperNumber('difference of two torques, same angle', 'N*m', 0.0, None,
                        scale * _difference(turns[1, 0.0], turns[1, 6.0]), 'paper: unique'))


def _difference(first: _Turn, second: _Turn) -> float:
    """Return how far the smooth torsions of two turns are apart at the same shaft angle, rms."""
    fits = [np.linalg.lstsq(_of_both(turn), turn.torsion, rcond=None)[0]
            for turn in (first, second)]
    return _rms(_of_both(first)[:, 1:] @ (fits[0] - fits[1])[1:])


def _findings(turns: dict[tuple[int, float], _Turn],
              held_out: dict[str, float]) -> tuple[str, ...]:
    scale = PRINTED.linear_stiffness
    left = {name: scale * value for name, value in held_out.items()}
    return (
        f'On turns that no fit has seen the quintic leaves {left["quintic (10)"]:.2f} N*m rms, a '
        f'Fourier series of the link alone {left["Fourier, link orders"]:.2f}, one of link and '
        f'shaft {left["Fourier, link and shaft orders"]:.2f}. The quintic holds the eccentric '
        'scale and none of the 200 waves of the wave generator.',
        'The kinematic torsion is unique to the angle indeed: directions and torques differ by '
        f'{scale * _difference(turns[1, 3.0], turns[-1, 3.0]):.3f} and '
        f'{scale * _difference(turns[1, 0.0], turns[1, 6.0]):.3f} N*m rms. It is unique to BOTH '
        'angles, shaft and link; a curve over one turn of the link at a coarse rate shows but '
        'the slow part.',
        'Skew, hysteresis and the torque itself shift each turn by a constant, which the zero of '
        'each turn takes up here.')


def _turns(turns: dict[tuple[int, float], _Turn], models: dict[str, Array]) -> Drawing:
    """Draw all turns, and the fits that know the link alone."""
    looks = (Look.MARK, Look.THIRD, Look.FOURTH)
    panels = []
    for sense, title in ((1, 'CCW'), (-1, 'CW')):
        traces = [_trace(turns[sense, torque], 1e6 * turns[sense, torque].torsion,
                         f'{torque:g} N·m', look, 7) for torque, look in zip(_TORQUES, looks)]
        turn = turns[sense, 3.0]
        traces += [_trace(turn, 1e6 * (_BASES[name](turn) @ models[name]), name, look, 40)
                   for name, look in (('quintic (10)', Look.PRINTED),
                                      ('Fourier, link orders', Look.CONSISTENT))]
        panels.append(Panel(title, 'link angle in its turn [rad]', 'kinematic torsion [µrad]',
                            tuple(traces)))
    return Drawing('turns', 'Kinematic torsion of the imperfect rig, both ways and under three '
                   'torques. Quintic and link orders follow the slow part.', (tuple(panels),))


def _trace(turn: _Turn, values: Array, name: str, look: Look, thin: int) -> Trace:
    place = np.mod(turn.link, 2.0 * np.pi)
    order = np.argsort(place)[::thin]
    return Trace(place[order], values[order], name, look)


def _window(turns: dict[tuple[int, float], _Turn], models: dict[str, Array]) -> Drawing:
    """Draw three turns of the shaft."""
    turn = turns[-1, 6.0]
    place = np.mod(turn.link, 2.0 * np.pi)
    inside = (place > _WINDOW[0]) & (place < _WINDOW[1])
    part = _Turn(turn.link[inside], turn.shaft[inside], turn.torsion[inside])
    traces = [_trace(part, 1e6 * part.torsion, 'measured', Look.TRUTH, 2)]
    traces += [_trace(part, 1e6 * (_BASES[name](part) @ model), name, look, 2)
               for (name, model), look in zip(models.items(), (Look.PRINTED, Look.THIRD,
                                                               Look.CONSISTENT))]
    return Drawing('window', 'Three turns of the shaft of a held-out turn (CW, 6 N·m).',
                   ((Panel('held out', 'link angle in its turn [rad]',
                           'kinematic torsion [µrad]', tuple(traces)),),))
