"""
Measure how often a diagnosis of seven joints is right, and how long it takes.

    diagnosis_chain.py [--records N] [--healthy N] [--first SEED] [--seconds S] [--rate HZ]
                       [--quick]

Every arm is off in stiffness, friction, damping, torque constant, and of each link in mass, centre
and inertia, by as much as its tolerances say. Waves, skew and offsets, which the diagnosis would
show, are exact. One effect of typical size is hidden at a joint drawn at random. Where it changes
not one bit of the recording, as a limit that no command reaches, the arm is a healthy one. The
arm's equations are the library's own, so what this finds is a bound: arms of another physics are
in `diagnosis.py`.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
import statistics
import sys
import time

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.effects import effect_named, Scope, TorqueConstantError
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.typical_sizes import SIZED, typical
from hda_arm_sim.motions import motion_of
from hda_torque_estimator.commands.kept_memory import keep_freed_memory
from hda_torque_estimator.diagnosis.diagnose import diagnose, sought_effects
from hda_torque_estimator.diagnosis.findings.report import Diagnosis
from hda_torque_estimator.diagnosis.fitting.hypotheses import left_aside
from hda_torque_estimator.measurements.measurement import Measurement
from hda_torque_estimator.simulating.closed_loop import run
import numpy as np
from size import parser, verdict
from torque_chain import deviate, numbers_off

ARM = read_arm('cobot7.yaml')
BARS = {'named': 0.95, 'accused': 0.01, 'seconds': 60.0}
QUICK, TINY = 'kinematic_error', 6.0        # of a tiny case: what is looked for, its length [s]
Place = tuple[str, str | None]


@dataclass(frozen=True)
class Outcome:
    """What one record was diagnosed as."""

    hidden: Place | None
    acts: bool                      # whether that changes anything of the recording
    verdict: str
    named: tuple[Place, ...]
    alike: tuple[Place, ...]        # named together with another cause
    seconds: float                  # of processor time

    @property
    def right(self) -> bool:
        """Return whether exactly what is hidden was named, alone or with what looks like it."""
        if not self.acts:
            return not self.named and not self.alike
        return self.hidden in (*self.named, *self.alike) and set(self.named) <= {self.hidden}

    @property
    def wrong(self) -> bool:
        """Return whether something was named that is not there."""
        return bool(set(self.named) - {self.hidden})


def hidden_places(count: int, first: int) -> Iterator[Place]:
    """Yield effects in turn, each at a joint drawn at random."""
    random = np.random.default_rng([first, 79])
    aside = left_aside(ARM, sought_effects())
    names = [name for name in sought_effects() if name in SIZED and name not in aside]
    order = random.permutation(len(names))
    for k in range(count):
        kind = effect_named(names[order[k % len(names)]])
        joint = None if kind.scope is Scope.ARM else str(random.choice(ARM.labels))
        yield kind.name, joint


def tolerated(seed: int) -> Arm:
    """Return an arm with which nothing is wrong: its numbers are off within their tolerances."""
    random = np.random.default_rng([seed, 80])
    made = numbers_off(ARM, random)
    for label in ARM.labels:
        error = ARM.tolerances.torque_constant * deviate(random)
        made = made.with_effect(TorqueConstantError(error=error), label)
    return made


def recorded(true: Arm, seconds: float, rate: float, seed: int) -> Measurement:
    """Return a recording of an arm that is moved by who knows the nominal one."""
    dt, every = 1e-3, round(1000.0 / rate)
    made = run(true, ARM, motion_of(ARM, 'rich', seconds, dt, seed), seed, estimator=None)
    return Measurement(ARM.labels, every * dt,
                       np.ascontiguousarray(made.reading[::every, :, :2]),
                       np.ascontiguousarray(made.command[::every]))


def outcome(place: Place | None, seconds: float, rate: float, seed: int,
            names: Sequence[str] | None = None) -> Outcome:
    """Return what is named of one arm, all effects being looked for unless some are named."""
    true = tolerated(seed)
    made, acts = recorded(true, seconds, rate, seed), False
    if place is not None:
        healthy = made
        made = recorded(true.with_effect(typical(true, *place), place[1]), seconds, rate, seed)
        acts = bool((made.reading != healthy.reading).any())
    began = time.process_time()
    said: Diagnosis = diagnose(made, ARM, names=names).diagnosis
    return Outcome(place, acts, said.verdict,
                   tuple((one.effect, one.joint) for one in said.findings),
                   tuple(each for pair in said.ambiguous for each in pair.effects),
                   time.process_time() - began)


def main() -> int:
    """Diagnose every record, and print each and the shares."""
    known = parser(__doc__)
    for name, usual in (('records', 40), ('healthy', 10), ('first', 900), ('seconds', 60.0),
                        ('rate', 1000.0)):
        known.add_argument(f'--{name}', type=type(usual), default=usual)
    asked = known.parse_args()
    keep_freed_memory()                                 # as `hda diagnose` does
    places: list[Place | None] = [(QUICK, 'joint4')]
    length, names = TINY, [QUICK] if asked.quick else None
    if not asked.quick:
        length = asked.seconds
        places = [*(None for _ in range(asked.healthy)),
                  *hidden_places(asked.records, asked.first)]
    found = []
    for seed, place in enumerate(places, asked.first):
        one = outcome(place, length, asked.rate, seed, names)
        found.append(one)
        hidden = _words(place) + (', which does nothing' if place and not one.acts else '')
        print(f'{seed} {hidden}: {one.verdict} '
              f'{", ".join(map(_words, one.named)) or "nothing"}'
              + (f' (alike: {", ".join(map(_words, one.alike))})' if one.alike else '')
              + f', {one.seconds:.0f} s', flush=True)
    return _summed(found, quick=asked.quick)


def _words(place: Place | None) -> str:
    return 'healthy' if place is None else f'{place[0]}@{place[1] or "arm"}'


def _summed(found: list[Outcome], *, quick: bool) -> int:
    """Print how often it was right, and return the exit code."""
    single = [one for one in found if one.acts]
    healthy = [one for one in found if not one.acts]
    reported, accused = sum(one.right for one in single), sum(not one.right for one in healthy)
    spent = statistics.median(one.seconds for one in found)
    print(f'single causes named: {reported} of {len(single)}; something else named: '
          f'{sum(one.wrong for one in single)}; healthy accused: {accused} of {len(healthy)}; '
          f'processor time, median: {spent:.0f} s')
    kept = (reported >= BARS['named'] * len(single) and accused <= BARS['accused'] * len(healthy)
            and spent <= BARS['seconds'])
    return verdict('95 % named, at most 1 % of healthy arms accused, 60 s', kept, quick=quick)


if __name__ == '__main__':
    sys.exit(main())
