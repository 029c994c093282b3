"""`hda estimate`: the estimator over a bag, with the bits that the node publishes."""

import argparse
from dataclasses import replace
import json
from pathlib import Path
from typing import Any, NamedTuple

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.writing import arm_to_text
from hda_msgs_json.bag import BagWriter, Recording
from hda_msgs_json.errors import HdaError
from hda_msgs_json.outputs import check_directory
from hda_msgs_json.samples import JointSamples, NumberSamples, WrenchSamples
from hda_msgs_json.topics import ESTIMATOR_STATE, Topic
from hda_msgs_json.worker_threads import drawn_ahead
import numpy as np
from numpy.typing import NDArray

from .bag_option import add_naming, naming
from .known_torques import all_errors, known_signals, KnownSignal
from .out_option import add_out
from .outcome import Outcome
from .page_option import add_page, check_page, write_page
from .progress import progress
from .tare_option import check_rest, stretch, taken_zero, tare_stamps, tare_words
from ..estimating.accuracy import EstimateErrors
from ..estimating.belief_words import doubt_shares
from ..estimating.contacts import Contact, contact_lines, contacts
from ..estimating.curves import ReferenceSignal
from ..estimating.estimate_messages import estimate_samples
from ..estimating.estimates import Estimates
from ..estimating.estimator import Estimator
from ..estimating.laws import layout
from ..estimating.laws.contact import contact_level
from ..estimating.number_messages import number_samples
from ..estimating.page import About, page
from ..estimating.recorded_settings import recorded_settings, RecordedSettings
from ..estimating.state_messages import state_samples
from ..measurements.conventions import check_conventions
from ..measurements.recorded_readings import recorded_readings
from ..measurements.renamed_recording import Naming, open_named
from ..samples.driver_states import Driver
from ..samples.readings import by_motor, unknown_motors
from ..version import version

EXAMPLES = (
    'hda estimate bag --arm hda_arm.yaml --out estimates',
    'hda estimate bag --arm hda_arm.yaml --tare 0:2 --out estimates  # at rest')


UNKNOWN_MOTOR = ('nothing is known of the friction of its motor, so its torque is unknown: '
                 'hda calibrate, or dry_friction in the arm file')


class EstimateError(HdaError):
    """A recording from which nothing can be estimated."""


def check_motors(arm: Arm, by_motor: tuple[str, ...], source: str) -> None:
    """Raise EstimateError where no joint has a link angle or a motor that is known."""
    if unknown_motors(arm, by_motor) == arm.labels:
        raise EstimateError(f'{source}: no link angle of {", ".join(arm.labels)}; {UNKNOWN_MOTOR}')


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('bag', type=Path, metavar='BAG', help='bag with joint_states')
    parser.add_argument('--arm', required=True, help='model file, or the name of a shipped one')
    add_out(parser, 'BAG2', 'bag to write')
    add_page(parser)
    parser.add_argument('--default-settings', action='store_true',
                        help='ignore the settings of the estimator that the bag holds')
    parser.add_argument('--fusion', choices=('on', 'off'),
                        help='let torsion and motor torque correct each other, or not; else as '
                             'the settings say')
    parser.add_argument('--tare', type=stretch, metavar='A:B',
                        help='seconds from the start in which nothing touches the resting arm: '
                             'their mean torsion becomes zero, from B on')
    add_naming(parser)


def execute(options: argparse.Namespace) -> Outcome:
    """Estimate and write; raises the project's errors."""
    with progress('estimating', quiet=options.json):
        return _estimated(options)


def _estimated(options: argparse.Namespace) -> Outcome:
    check_directory(options.out, force=options.force, reads=[options.bag])
    check_page(options, [options.bag])
    arm = read_arm(options.arm)
    named = naming(options)
    recording = open_named(options.bag, named)
    settings = _settings(options, recording)
    driver = settings.driver if named == Naming() else Driver()
    found = recorded_readings(arm, recording, driver)
    check_conventions(arm, found.reading, found.command, str(options.bag))
    check_motors(arm, found.by_motor, str(options.bag))
    arm = by_motor(arm, found.by_motor)
    estimator = Estimator(arm, settings.estimator)
    tare = tare_stamps(options.tare, found.stamps)
    estimates, parts = estimator.in_parts(found.stamps, found.reading, found.command, tare=tare)
    if len(estimates.stamps) <= min(1, len(found.stamps) - 1):
        usable = 'only 1' if len(estimates.stamps) else 'none'
        raise EstimateError(f'{options.bag}: {usable} of {len(found.stamps)} joint states has '
                            'finite angles and a stamp later than the one before')
    last: int | None = None
    if (back := np.flatnonzero(np.diff(estimates.stamps) < 0)).size:
        raise EstimateError(f'{options.bag}: stamps go back at sample {back[0] + 1}, a loop or a '
                            'restart while it was recorded; split it there')
    if options.tare:
        check_rest(options.tare, arm, tare, found)
    about = {'arm': arm_to_text(arm), 'source': str(options.bag.name), **settings.to_metadata()}
    with BagWriter(options.out, about, force=options.force) as bag:
        for part in drawn_ahead(parts, 1):      # another thread estimates, this one writes
            _write(bag, arm, part, settings, before=last)
            last = int(part.stamps[-1])
        zero = taken_zero(options.tare, estimator, estimates, tare)
        if zero:
            bag.add_metadata({'tare': json.dumps(zero)})
        known = known_signals(recording, arm, estimates)        # damaged truth: no bag stands
        found_errors, refused = all_errors(known, estimates), len(
            estimates.refused) + found.unreadable
        shown = None if options.page is None else page(estimates, About(
            arm.labels, str(options.bag), options.arm, version(), refused, _doubts(arm, estimates),
            found_errors, tare_words(zero) if zero else ''), _beside(known))
    if shown is not None:
        write_page(options, shown)
    level = contact_level(settings.estimator.contact_deviations, len(arm.joints))
    return _outcome(options, arm, _EstimatedBag(estimates, found_errors, contacts(
        arm, estimates, level), found.by_motor), refused, zero)


def _write(bag: BagWriter, arm: Arm, part: Estimates, settings: RecordedSettings, *,
           before: int | None) -> None:
    """Write the messages of some estimates, which come after those at the stamp `before`."""
    rate = settings.state.state_rate
    made: dict[Topic, JointSamples | WrenchSamples | NumberSamples] = {
        **estimate_samples(arm, part, settings.unobserved),
        **number_samples(arm, part, rate, before)}
    for topic, samples in made.items():
        if isinstance(samples, JointSamples):
            bag.write_joint_states(topic, samples)
        elif isinstance(samples, WrenchSamples):
            bag.write_wrenches(topic, samples)
        else:
            bag.write_numbers(topic, samples)
    bag.write_texts(ESTIMATOR_STATE, state_samples(arm, part, rate, before))
    bag.merge()


def _settings(options: argparse.Namespace, recording: Recording) -> RecordedSettings:
    settings = (RecordedSettings() if options.default_settings
                else recorded_settings(recording.metadata))
    if options.fusion is None:
        return settings
    chosen = replace(settings.estimator, fusion=float(options.fusion == 'on'))
    return settings._replace(estimator=chosen)


class _EstimatedBag(NamedTuple):
    """What came of a recording: estimates, their errors against what is known, contacts."""

    estimates: Estimates
    found: dict[str, EstimateErrors]
    contacts: list[Contact]
    by_motor: tuple[str, ...]


def _outcome(options: argparse.Namespace, arm: Arm, made: _EstimatedBag, refused: int,
             zero: dict[str, Any]) -> Outcome:
    estimates, found, touched, alone = made
    doubted = _doubts(arm, estimates)
    report: dict[str, Any] = {
        'bag': str(options.out), 'samples': len(estimates.stamps),
        'refused': refused, 'joints': list(arm.labels),
        'largest_torque': _largest(estimates).tolist(),
        'doubts': doubted, 'tare': zero or None, 'by_motor': list(alone),
        'unknown': list(unknown_motors(arm, alone)),
        'contacts': [one._asdict() for one in touched],
        'errors': {name: {key: None if np.isnan(value) else value
                          for key, value in error._asdict().items()}
                   for name, error in found.items()}}
    torques = ', '.join(f'{value:.2f}' for value in report['largest_torque'])
    lines = [f'{options.out}: {len(estimates.stamps)} samples, {refused} refused, '
             f'joint torques up to {torques} N*m']
    lines += [f'  {100.0 * share:.3g} % of the samples: {words}'
              for words, share in doubted.items()]
    unknown = unknown_motors(arm, alone)
    lines += [f'  {label}: no link angle is in the bag; ' + (UNKNOWN_MOTOR if label in unknown else
              'its motor alone gives its torque') for label in alone]
    if zero:
        lines.append(f'  {tare_words(zero)}')
    if arm.links is None:
        lines.append('  no external torque and no tip force: they need links in the arm '
                     'file')
    lines += [f'  {line}' for line in contact_lines(touched)]
    lines += [f'  error against {name}: {error_words(error, _unit(name))}'
              for name, error in found.items()]
    return Outcome('\n'.join(lines), report)


def error_words(error: EstimateErrors, unit: str) -> str:
    """Return an error as a terminal says it."""
    if np.isnan(error.rms):
        return 'unknown, as at no time both are known'
    return (f'{error.rms:.3f} {unit} rms ({error.rms_without_mean:.3f} without its mean), '
            f'at most {error.largest:.3f}')


def _doubts(arm: Arm, estimates: Estimates) -> dict[str, float]:
    return doubt_shares(arm.labels, estimates.joints[:, :, layout.DOUBT])


def _beside(known: dict[str, KnownSignal]) -> dict[str, dict[str, ReferenceSignal]]:
    """Return known signals by the joint or axis that they speak of, under short names."""
    found: dict[str, dict[str, ReferenceSignal]] = {}
    for name, one in known.items():
        source, place, kind = name.split('/')
        key = kind.rpartition('.')[2] if place == 'tip' else place
        found.setdefault(key, {})[source] = ReferenceSignal(one.stamps, one.values)
    return found


def _largest(estimates: Estimates) -> NDArray[np.float64]:
    """Return the largest torque of each joint, NaN where none was estimated."""
    size = np.abs(estimates.torque)
    known = np.isfinite(size)
    return np.where(known.any(axis=0), np.where(known, size, 0.0).max(axis=0), np.nan)


def _unit(name: str) -> str:
    return 'N' if 'tip/' in name else 'N*m'
