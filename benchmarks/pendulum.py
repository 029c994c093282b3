"""
Simulate a servo that swings a pendulum, and fit its friction to what was measured.

The servo gives `kt (duty U - kt omega) / R`, and its duty follows the goal by a gain. Motor and
friction are fitted to the positions of all gains but one, which is then simulated.
"""

from collections.abc import Mapping, Sequence

from numba import njit
import numpy as np
from real_commands import Floats, Numbers
from scipy.optimize import differential_evolution, minimize

LEFT_OUT = 200              # gain that no fit sees
STEPS = 4                   # of the integrator in a sample
SEED = 1                    # of the search
MASS, LENGTH, GRAVITY = 0.49, 0.1, 9.81             # of the pendulum [kg, m, m/s^2]
WEIGHT, SWINGS = MASS * GRAVITY * LENGTH, MASS * LENGTH ** 2    # [N*m], [kg*m^2]
DUTY = 4096.0 / (2.0 * np.pi) / (256.0 * 885.0)     # of each unit of gain and radian
# What is fitted, from and to: kt [N*m/A], R [ohm], inertia of the servo [kg*m^2], dry [N*m] and
# viscous [N*m*s/rad] friction, friction per torque through the gear. That share grows with the
# torque [1/(N*m)] and falls with speed [s/rad], as in the catalogue (eq:load-friction).
BOUNDS = {'kt': (0.1, 0.8), 'R': (1.0, 10.0), 'inertia': (0.0, 5e-3), 'dry': (0.0, 0.1),
          'viscous': (0.0, 0.1), 'load': (0.0, 0.8), 'growth': (0.0, 20.0), 'fall': (0.0, 3.0)}
Log = tuple[float, Floats, Floats]      # gain, time (k,), what `simulated` reads (k, 4)
STRUCTURES = {'coulomb_viscous': 5, 'load': 6, 'load_shaped': 8}


@njit(cache=False)
def simulated(values: Floats, gain: float, time: Floats, log: Floats) -> Floats:
    """Return positions (k,) by a log (k, 4): goal, voltage, whether the motor is on, position."""
    kt, resistance, inertia, dry, viscous, load, growth, fall = values
    whole = inertia + SWINGS
    angle, rate, turning, found = log[0, 3], 0.0, 0.0, np.empty(len(time))
    for k in range(len(time)):
        found[k] = angle
        dt = (time[min(k + 1, len(time) - 1)] - time[k]) / STEPS
        for _ in range(STEPS):
            torque = -WEIGHT * np.sin(angle)
            drag = viscous
            if log[k, 2] > 0.0:
                duty = min(max(gain * DUTY * (log[k, 0] - angle), -1.0), 1.0)
                torque += kt * duty * log[k, 1] / resistance
                drag += kt * kt / resistance
            through = abs(WEIGHT * np.sin(angle) + SWINGS * turning)
            share = load * (1.0 + growth * through) / (1.0 + fall * abs(rate))
            level = dry + share * through
            free = (rate + dt * torque / whole) / (1.0 + dt * drag / whole)
            slows = dt * level / whole / (1.0 + dt * drag / whole)
            after = 0.0 if abs(free) <= slows else free - slows * np.sign(free)
            turning = (after - rate) / dt if dt > 0.0 else 0.0
            rate = after
            angle += dt * rate
    return found


def held_out(logs: Mapping[str, Mapping[str, Floats]]) -> Numbers:
    """Return the mean absolute error of each structure of friction on the gain left out [rad]."""
    tables = {name: (float(name.rpartition('kp')[2]), log['time'], np.stack(
        [log['goal_position'], log['input_volts'], log['torque_enable'], log['position']], axis=1))
        for name, log in logs.items()}
    seen = [one for one in tables.values() if one[0] != LEFT_OUT]
    left = [one for one in tables.values() if one[0] == LEFT_OUT]
    return {name: _fit(seen, left, count) for name, count in STRUCTURES.items()}


def _fit(seen: Sequence[Log], left: Sequence[Log], count: int) -> Numbers:
    """Return how the first of the numbers, fitted to some logs, do on them and on others."""
    bounds = list(BOUNDS.values())
    none = np.zeros(len(bounds))
    low, high = np.array(bounds[:count]).T

    def whole(part: Floats) -> Floats:
        return np.concatenate([np.clip(part, low, high), none[count:]])

    def error(part: Floats) -> float:
        return miss(whole(part), seen)

    coarse = differential_evolution(error, bounds[:count], seed=SEED, maxiter=60, popsize=10,
                                    tol=1e-6, polish=False)
    fine = minimize(error, coarse.x, method='Nelder-Mead', options={'maxiter': 1500})
    best = whole(fine.x)
    return {'seen': miss(best, seen), 'left_out': miss(best, left),
            'values': dict(zip(BOUNDS, best[:count].tolist()))}


def miss(values: Floats, logs: Sequence[Log]) -> float:
    """Return the mean absolute error of the simulation of logs [rad]."""
    errors = [simulated(values, gain, time, log) - log[:, 3] for gain, time, log in logs]
    return float(np.mean(np.abs(np.concatenate(errors))))
