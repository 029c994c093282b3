"""`hda diagnose`: what the simulation gets wrong, why, the extended model and its gain."""

import argparse
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
import time
from typing import TypeVar

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.writing import arm_to_text
from hda_arm_sim.simulate import checked
from hda_msgs_json.bag import Recording
from hda_msgs_json.samples import JointSamples, WrenchSamples
from matplotlib.figure import Figure

from . import fleet
from .bag_option import add_naming, opener
from .kept_memory import keep_freed_memory
from .known_torques import references_of
from .motors_alone import motor_figures
from .out_option import add_out
from .outcome import Outcome
from .progress import progress
from .whole_directory import check_directory, elements, save_figures, whole_directory, write_json
from ..diagnosis.detectability.excitation import asked
from ..diagnosis.diagnose import Conclusion, diagnose
from ..diagnosis.findings.choice import chosen
from ..diagnosis.findings.origin import Origin, RecordingPart
from ..diagnosis.findings.report import Diagnosis
from ..diagnosis.fitting.alignment import together
from ..diagnosis.motors_alone.motor_record import (
    is_motor_side, length_of, period_of, sweeps_together)
from ..diagnosis.motors_alone.motor_side import diagnose_motors, MotorConclusion
from ..diagnosis.reporting.exhibits import Exhibits
from ..diagnosis.reporting.page import page
from ..diagnosis.reporting.plots import figures
from ..diagnosis.reporting.summary import headline, probability
from ..diagnosis.showing import exhibits_of, predictions
from ..measurements.measurement import Measurement
from ..measurements.rates import rates_differ
from ..measurements.recording_checks import check, check_names, GateError, mended, Mending
from ..measurements.sample_grid import measurement_from
from ..pages.wording import capital
from ..version import version

PAGE = 'report.html'
AnyConclusion = Conclusion | MotorConclusion
Conclusive = TypeVar('Conclusive', Conclusion, MotorConclusion)
EXAMPLES = (
    'hda diagnose bag --arm hda_arm.yaml --out report',
    'hda diagnose bag --arm hda_arm.yaml --about backlash@joint1 --out report',
    'hda diagnose --each bags/ --arm hda_arm.yaml --out fleet')


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('bags', nargs='+', type=Path, metavar='BAG',
                        help='recordings of one arm, best 60 s each')
    parser.add_argument('--arm', required=True, help='model file, or the name of a shipped one')
    add_out(parser, 'DIR', 'directory to write: report.html, report.json, model.yaml')
    parser.add_argument('--about', action='append', default=[], metavar='EFFECT',
                        help='say whether silence rules this effect out; EFFECT@JOINT for a joint')
    parser.add_argument('--candidate', type=int, default=1, metavar='N',
                        help='of causes that look alike, the one that model.yaml holds: 1, the '
                             'first, unless given')
    parser.add_argument('--degrees', action='store_true', help='all angles are in degrees')
    parser.add_argument('--motor-at-link', action='store_true',
                        help='motor angles are divided by the gear ratio already')
    parser.add_argument('--flip', action='append', default=[], metavar='NAME',
                        help='this angle, and the torque with it, has the other sign')
    add_naming(parser)
    fleet.configure(parser)


def execute(options: argparse.Namespace) -> Outcome:
    """Diagnose and write; raises the project's errors."""
    fleet.check(options)
    if options.each:
        return fleet.execute(_together, options)
    with progress(quiet=options.json) as notify:
        return _together(options, notify)


def _together(options: argparse.Namespace,
              notify: Callable[[str], None] = lambda text: None) -> Outcome:
    """Diagnose all bags as recordings of one arm, and write; `notify` hears what is being done."""
    begin = time.monotonic()
    keep_freed_memory()
    check_directory(options.out, force=options.force, reads=options.bags)
    arm = read_arm(options.arm)
    sources = [str(bag) for bag in options.bags]
    notify('reading')
    opened = opener(options)
    recordings = [opened(bag) for bag in options.bags]
    recorded = [recording.joint_states() for recording in recordings]
    alone = [is_motor_side(samples, arm) for samples in recorded]
    if all(alone):
        return _motors(options, dict(zip(sources, recorded)), arm, begin)
    if any(alone):
        raise GateError(f'{sources[alone.index(True)]} has motors alone, '
                        f'{sources[alone.index(False)]} has links as well; diagnose them apart')
    arm = arm if arm.links is None else checked(arm)
    about = asked(arm, options.about)
    measurement = together([
        _measurement(part, options, arm, source, _references(recording, options, arm))
        for part, source, recording in zip(recorded, sources, recordings)], sources)
    found = diagnose(measurement, arm, about=about,
                     origin=Origin(options.arm, version(), sources), notify=notify)
    spent, found = time.monotonic() - begin, _chosen(found, arm, options)
    notify('drawing')
    exhibits = None if found.evidence is None else exhibits_of(found.evidence)
    found = found._replace(diagnosis=replace(
        found.diagnosis, seconds=spent,
        prediction=() if exhibits is None else predictions(exhibits)))
    drawn = {} if exhibits is None else figures(found.diagnosis, exhibits)
    _write(found, drawn, options, exhibits)
    return Outcome(_in_words(found.diagnosis, options.out), found.diagnosis.document())


def _motors(options: argparse.Namespace, recorded: Mapping[str, JointSamples], arm: Arm,
            begin: float) -> Outcome:
    """Diagnose the motors of recordings that have no link angles, by their names, and write."""
    recorded = {source: mended(samples, arm, _mending(options), source)
                for source, samples in recorded.items()}
    lengths = [length_of(samples) for samples in recorded.values()]
    bags = [RecordingPart(source, sum(lengths[:place]), lengths[place])
            for place, source in enumerate(recorded)]
    found = diagnose_motors(sweeps_together(recorded, arm), arm, arm_file=options.arm,
                            version=version(), bags=bags, said=rates_differ({
                                source: 1.0 / period_of(samples)
                                for source, samples in recorded.items()}))
    found = _chosen(found, arm, options)
    found = found._replace(diagnosis=replace(found.diagnosis, seconds=time.monotonic() - begin))
    _write(found, motor_figures(found.parts), options)
    return Outcome(_in_words(found.diagnosis, options.out), found.diagnosis.document())


def _in_words(diagnosis: Diagnosis, out: Path) -> str:
    """Return what a terminal says: verdict, sentence, how sure, numbers, where the page is."""
    verdict, *numbers = diagnosis.sentences()
    is_named = diagnosis.findings or diagnosis.ambiguous or diagnosis.unexplained
    sure = probability(diagnosis)
    plain = [f'  {headline(diagnosis)}{f" {capital(sure)} probable." if sure else ""}']
    return '\n'.join([verdict, *(plain if is_named else []), *numbers,
                      f'  to read: {out / PAGE}'])


def _chosen(found: Conclusive, arm: Arm, options: argparse.Namespace) -> Conclusive:
    """Return a conclusion whose arm holds the candidate that was asked for; raises ChoiceError."""
    diagnosis, extended = chosen(found.diagnosis, found.extended, arm, options.candidate)
    return found._replace(diagnosis=diagnosis, extended=extended)


def _measurement(samples: JointSamples, options: argparse.Namespace, arm: Arm,
                 source: str, references: Mapping[str, WrenchSamples]) -> Measurement:
    """Return what a recording holds, mended as the user says; raises GateError."""
    check_names(samples, arm, source)
    measurement = measurement_from(arm.labels, mended(samples, arm, _mending(options), source),
                                   source, references)
    check(measurement, arm, source)
    return measurement


def _references(recording: Recording, options: argparse.Namespace,
                arm: Arm) -> dict[str, WrenchSamples]:
    """Return the reference torques of a recording; a link that is flipped turns its own round."""
    return {label: replace(torque, torque=-torque.torque) if label in options.flip else torque
            for label, torque in references_of(recording, arm.labels).items()}


def _mending(options: argparse.Namespace) -> Mending:
    return Mending(options.degrees, options.motor_at_link, tuple(options.flip))


def _write(found: AnyConclusion, drawn: dict[str, Figure], options: argparse.Namespace,
           exhibits: Exhibits | None = None) -> None:
    """Write the directory; it appears whole or not at all. What has exhibits is plotted."""
    with whole_directory(options.out, force=options.force) as partial:
        write_json(partial / 'report.json', found.diagnosis.document())
        notes = ''.join(f'# {note}\n' for note in found.diagnosis.notes())
        (partial / 'model.yaml').write_text(notes + arm_to_text(found.extended),
                                            encoding='utf-8')
        save_figures(drawn, partial)
        (partial / PAGE).write_text(
            page(found.diagnosis, {} if exhibits else elements(drawn), exhibits),
            encoding='utf-8')
