"""
Measure how often a diagnosis is right, on recordings of the independent truth in `test/truth/`.

    diagnosis.py [--records N] [--healthy N] [--pairs N] [--triples N] [--workers N] [--first SEED]
                 [--limit SECONDS] [--kept FILE] [--page FILE] [--quick]

Hides effects in 60 s recordings at 1 kHz, diagnoses them, and writes a page, `docs/accuracy.md`:
the table of what was asked and reached, and what was called what. Seeds from FIRST on are used
here alone. Outcomes are kept in FILE as they come, so that a study that was stopped goes on where
it was; they hold for one state of the code.
"""

from argparse import Namespace
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
import json
from pathlib import Path
import sys
import tempfile
import time
from typing import Any

from diagnosis_tables import page
from hda_arm_sim.model.files import read_arm
from hda_torque_estimator.diagnosis.diagnose import diagnose, sought_effects
from hda_torque_estimator.measurements.sample_grid import measurement_from
from hidden_truth import CATALOGUE, draw, OUTSIDE, published, scattered
from kept import outcomes
import numpy as np
from size import parser

ROOT = Path(__file__).resolve().parents[1]
ARM = read_arm('hda_arm.yaml')
LAST = ('outside', 'left out', 'poor')  # groups whose rates a part of the records shows


@dataclass(frozen=True)
class Case:
    """One recording: what is hidden in it, and how it is diagnosed."""

    group: str                      # row of the table it belongs to
    hidden: tuple[str, ...]
    seed: int
    motion: str = 'rich'
    noise: float = 1.0
    without: str | None = None      # an effect that the catalogue lacks

    def key(self) -> str:
        """Return what distinguishes it from all others."""
        return json.dumps(asdict(self))


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


def outcome(case: Case) -> dict[str, Any]:
    """Record and diagnose one case; returns what was hidden and what was said."""
    random = np.random.default_rng([case.seed, 1])
    hidden = [draw(name, random) for name in case.hidden]
    samples = published(ARM, hidden, case.seed, name=case.motion, noise=case.noise)
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


def attempted(case: Case) -> dict[str, Any]:
    """Return the outcome of a case; one that the truth or the diagnosis cannot do says why."""
    try:
        return {'case': case.key(), **outcome(case)}
    except ValueError as error:
        return {'case': case.key(), 'group': case.group, 'seed': case.seed,
                'hidden': case.hidden, 'error': str(error)}


def asked_for(words: Sequence[str]) -> Namespace:
    """Return the sizes of the study."""
    known = parser(__doc__)
    for name, default in (('records', 10), ('healthy', 300), ('pairs', 100), ('triples', 40),
                          ('workers', 2), ('first', 20000), ('limit', 0)):
        known.add_argument(f'--{name}', type=int, default=default)
    known.add_argument('--kept', type=Path, default=ROOT / 'out' / 'diagnosis.jsonl')
    known.add_argument('--page', type=Path, default=ROOT / 'docs' / 'accuracy.md')
    return known.parse_args(words)


def main() -> int:
    """Run the study and write the page."""
    asked = asked_for(sys.argv[1:])
    if not asked.quick:
        return run(asked)
    with tempfile.TemporaryDirectory() as folder:
        return run(tiny(asked, Path(folder)))


def tiny(asked: Namespace, folder: Path) -> Namespace:
    """Return the study of one healthy arm, which leaves its outcome and page in a folder."""
    return Namespace(**{**vars(asked), 'records': 0, 'pairs': 0, 'triples': 0, 'healthy': 1,
                        'workers': 1, 'kept': folder / 'kept.jsonl', 'page': folder / 'page.md'})


def run(asked: Namespace) -> int:
    """Run what is asked for and write the page."""
    planned = list(cases(asked))
    results = outcomes(planned, attempted, asked, LAST)
    print(Counter(result['group'] for result in results))
    asked.page.write_text(page(results, len(planned)), encoding='utf-8')
    return 0


if __name__ == '__main__':
    sys.exit(main())
