"""`hda estimate`: the estimator over a bag, with the bits that the node publishes."""

import argparse
from dataclasses import replace
import json
from pathlib import Path
from typing import Any

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.files import arm_to_text, read_arm
from hda_msgs_json.ahead import drawn_ahead
from hda_msgs_json.bag import BagWriter, open_recording, Recording
from hda_msgs_json.errors import HdaError
from hda_msgs_json.outputs import check_directory
from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import (ESTIMATOR_STATE, reference_joint_torque, REFERENCE_TIP_WRENCH,
                                  truth_joint_torque, TRUTH_TIP_WRENCH)
import numpy as np
from numpy.typing import NDArray

from .out_option import add_out
from .outcome import Outcome
from .tare_option import check_rest, stretch, taken_zero, tare_stamps, tare_words
from ..estimating.accuracy import Errors, errors
from ..estimating.belief_words import doubt_shares
from ..estimating.estimate_messages import estimate_samples
from ..estimating.estimator import Estimates, Estimator
from ..estimating.laws import estimate
from ..estimating.recorded_settings import recorded_settings, RecordedSettings
from ..estimating.state_messages import state_samples
from ..measurements.conventions import check_conventions
from ..measurements.recorded_readings import recorded_readings


class EstimateError(HdaError):
    """A recording from which nothing can be estimated."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('bag', type=Path, metavar='BAG', help='bag with joint_states')
    parser.add_argument('--arm', required=True, help='model file, or the name of a shipped one')
    add_out(parser, 'BAG2', 'bag to write')
    parser.add_argument('--default-settings', action='store_true',
                        help='ignore the settings of the estimator that the bag tells')
    parser.add_argument('--fusion', choices=('on', 'off'),
                        help='let torsion and motor torque correct each other, or not; else as '
                             'the settings say')
    parser.add_argument('--tare', type=stretch, metavar='A:B',
                        help='seconds from the start in which nothing touches the resting arm: '
                             'their mean torsion becomes zero, from B on')


def execute(options: argparse.Namespace) -> Outcome:
    """Estimate and write; raises the project's errors."""
    check_directory(options.out, force=options.force, reads=[options.bag])
    arm = read_arm(options.arm)
    recording = open_recording(options.bag)
    settings = _settings(options, recording)
    found = recorded_readings(arm, recording, settings.driver)
    check_conventions(arm, found.reading, found.command, str(options.bag))
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
        found_errors = _all_errors(recording, arm, estimates)   # damaged truth: no bag stands
    return _outcome(options, arm, estimates, found_errors,
                    len(estimates.refused) + found.unreadable, zero)


def _write(bag: BagWriter, arm: Arm, part: Estimates, settings: RecordedSettings, *,
           before: int | None) -> None:
    """Write the messages of some estimates, which come after those at the stamp `before`."""
    for topic, samples in estimate_samples(arm, part, settings.unobserved).items():
        if isinstance(samples, JointSamples):
            bag.write_joint_states(topic, samples)
        else:
            bag.write_wrenches(topic, samples)
    bag.write_texts(ESTIMATOR_STATE, state_samples(arm, part, settings.state.state_rate, before))
    bag.merge()


def _settings(options: argparse.Namespace, recording: Recording) -> RecordedSettings:
    settings = (RecordedSettings() if options.default_settings
                else recorded_settings(recording.metadata))
    if options.fusion is None:
        return settings
    chosen = replace(settings.estimator, fusion=float(options.fusion == 'on'))
    return settings._replace(estimator=chosen)


def _all_errors(recording: Recording, arm: Arm, estimates: Estimates) -> dict[str, Errors]:
    """Return the errors against every truth and reference that the bag holds."""
    found = {}
    for column, label in zip(estimates.torque.T, arm.labels):
        for topic in (truth_joint_torque(label), reference_joint_torque(label)):
            if name := _held(recording, topic.name):
                known = recording.wrenches(name)
                found[topic.name] = errors(estimates.stamps, column, known.stamps,
                                           known.torque[:, 2])
    for topic in (TRUTH_TIP_WRENCH, REFERENCE_TIP_WRENCH):
        name = _held(recording, topic.name)
        if name and arm.links is not None:
            known = recording.wrenches(name)
            for axis, letter in enumerate('xy'):
                found[f'{topic.name}.{letter}'] = errors(
                    estimates.stamps, estimates.base_force[:, axis], known.stamps,
                    known.force[:, axis])
    return found


def _held(recording: Recording, topic: str) -> str | None:
    return next((name for name in recording.topics if name.strip('/') == topic), None)


def _outcome(options: argparse.Namespace, arm: Arm, estimates: Estimates,
             found: dict[str, Errors], refused: int, zero: dict[str, Any]) -> Outcome:
    doubted = doubt_shares(arm.labels, estimates.joints[:, :, estimate.DOUBT])
    report: dict[str, Any] = {
        'bag': str(options.out), 'samples': len(estimates.stamps),
        'refused': refused, 'joints': list(arm.labels),
        'largest_torque': _largest(estimates).tolist(),
        'doubts': doubted, 'tare': zero or None,
        'errors': {name: {key: None if np.isnan(value) else value
                          for key, value in error._asdict().items()}
                   for name, error in found.items()}}
    torques = ', '.join(f'{value:.2f}' for value in report['largest_torque'])
    lines = [f'{options.out}: {len(estimates.stamps)} samples, {refused} refused, '
             f'joint torques up to {torques} N*m']
    lines += [f'  {100.0 * share:.3g} % of the samples: {words}'
              for words, share in doubted.items()]
    if zero:
        lines.append(f'  {tare_words(zero)}')
    if arm.links is None:
        lines.append('  no external torque and no tip force: the arm file says "links: none"')
    lines += [f'  error against {name}: {error.rms:.3f} {_unit(name)} rms '
              f'({error.rms_without_mean:.3f} without its mean), at most {error.largest:.3f}'
              for name, error in found.items()]
    return Outcome('\n'.join(lines), report)


def _largest(estimates: Estimates) -> NDArray[np.float64]:
    """Return the largest torque of each joint, NaN where none was estimated."""
    size = np.abs(estimates.torque)
    known = np.isfinite(size)
    return np.where(known.any(axis=0), np.where(known, size, 0.0).max(axis=0), np.nan)


def _unit(name: str) -> str:
    return 'N' if 'tip/' in name else 'N*m'
