"""
Measure how often a diagnosis is right, on recordings of the independent truth in `test/truth/`.

    diagnosis.py [--records N] [--healthy N] [--pairs N] [--triples N] [--workers N] [--first SEED]

Hides effects in 60 s recordings at 1 kHz, diagnoses them, and writes `docs/accuracy.md`: the table
of what was asked and reached, and what was called what. Seeds from FIRST on are used here alone.
"""

from argparse import ArgumentParser, Namespace
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
import sys
import time

from diagnosis_tables import page
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.motions import motion
from hda_torque_estimator.diagnosis.diagnose import diagnose, sought_effects
from hda_torque_estimator.diagnosis.measurement import measurement_from
from hda_torque_estimator.recorded import joint_samples
from hidden_truth import CATALOGUE, draw, OUTSIDE, record, scattered
import numpy as np

ROOT = Path(__file__).resolve().parents[1]
ARM = read_arm('hda_arm.yaml')
SECONDS, PERIOD = 60.0, 1e-3


@dataclass(frozen=True)
class Case:
    """One recording: what is hidden in it, and how it is diagnosed."""

    group: str                      # row of the table it belongs to
    hidden: tuple[str, ...]
    seed: int
    motion: str = 'rich'
    noise: float = 1.0
    without: str | None = None      # an effect that the catalogue lacks


def cases(asked: Namespace) -> Iterator[Case]:
    """Yield all recordings of the study."""
    names = [effect.name for effect in CATALOGUE]
    random, seed = np.random.default_rng(asked.first), asked.first
    for _ in range(asked.healthy):
        yield Case('healthy', (), (seed := seed + 1), noise=2.0)
    for _ in range(asked.records):
        for name in names:
            yield Case('one', (name,), (seed := seed + 1))
            yield Case('left out', (name,), (seed := seed + 1), without=name)
            yield Case('poor', (name,), (seed := seed + 1), motion='slow_sine')
        for effect in OUTSIDE:
            yield Case('outside', (effect.name,), (seed := seed + 1))
    for group, count, size in (('two', asked.pairs, 2), ('three', asked.triples, 3)):
        for _ in range(count):
            chosen = tuple(str(name) for name in random.choice(names, size, replace=False))
            yield Case(group, chosen, (seed := seed + 1))


def outcome(case: Case) -> dict[str, object]:
    """Record and diagnose one case; returns what was hidden and what was said."""
    random = np.random.default_rng([case.seed, 1])
    hidden = [draw(name, random) for name in case.hidden]
    path = motion(case.motion, 2, SECONDS, PERIOD, case.seed)
    made = record(hidden, motion_angle=path.angle, motion_rate=path.rate, dt=PERIOD,
                  seed=case.seed, noise=case.noise)
    reading = np.stack([made.motor_angle, made.link_angle], axis=2)
    rates = np.full_like(reading, np.nan)
    samples = joint_samples(ARM, made.stamps, np.concatenate([reading, rates], axis=2),
                            made.command)
    began = time.process_time()
    said = diagnose(measurement_from(ARM.labels, samples), ARM, names=[
        name for name in sought_effects() if name != case.without]).diagnosis
    rest = said.unexplained
    return {
        'group': case.group, 'seed': case.seed, 'seconds': time.process_time() - began,
        'hidden': [(one.effect, one.joint, one.parameters, one.site, one.coordinate)
                   for one in hidden],
        'scatter': scattered(case.seed),
        'verdict': said.verdict, 'removed': said.gain.removed,
        'said': [(one.effect, one.joint, {name: (number.value, number.low, number.high)
                                          for name, number in one.parameters.items()})
                 for one in said.findings],
        'alike': [list(pair.effects) for pair in said.ambiguous],
        'rest': None if rest is None else (rest.site, rest.joint, rest.depends_on)}


def attempted(case: Case) -> dict[str, object]:
    """Return the outcome of a case; one that the truth or the diagnosis cannot do says why."""
    try:
        return outcome(case)
    except ValueError as error:
        return {'group': case.group, 'seed': case.seed, 'hidden': case.hidden,
                'error': str(error)}


def asked_for(words: Sequence[str]) -> Namespace:
    """Return the sizes of the study."""
    parser = ArgumentParser(description=__doc__)
    for name, default in (('records', 10), ('healthy', 300), ('pairs', 100), ('triples', 40),
                          ('workers', 2), ('first', 20000), ('limit', 0)):
        parser.add_argument(f'--{name}', type=int, default=default)
    return parser.parse_args(words)


def main() -> int:
    """Run the study and write the page."""
    asked = asked_for(sys.argv[1:])
    todo = list(cases(asked))
    end = time.monotonic() + asked.limit if asked.limit else float('inf')
    # a limited study sees every group alike
    order = np.random.default_rng(asked.first).permutation(len(todo)) if asked.limit else range(
        len(todo))
    results: list[dict[str, object]] = []
    with ProcessPoolExecutor(asked.workers) as pool:
        for start in range(0, len(todo), 2 * asked.workers):
            if time.monotonic() > end:
                break
            part = [todo[k] for k in order[start:start + 2 * asked.workers]]
            results += pool.map(attempted, part)
            print(f'{len(results)} of {len(todo)}', Counter(r['group'] for r in results),
                  flush=True)
    (ROOT / 'docs' / 'accuracy.md').write_text(page(results, len(todo)), encoding='utf-8')
    return 0


if __name__ == '__main__':
    sys.exit(main())
