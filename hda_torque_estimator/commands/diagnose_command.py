"""`hda diagnose`: what the simulation gets wrong, why, the extended model and its gain."""

import argparse
from dataclasses import replace
from pathlib import Path
import time

from hda_arm_sim.model.arm import Arm
from hda_arm_sim.model.files import arm_to_text, read_arm
from hda_arm_sim.simulate import checked
from hda_msgs_json.bag import open_recording
from hda_msgs_json.samples import JointSamples
from matplotlib.figure import Figure

from . import fleet
from .motors_alone import motor_figures
from .outcome import Outcome
from .whole_directory import save_figures, whole_directory, write_json
from ..diagnosis.alignment import together
from ..diagnosis.diagnose import Conclusion, diagnose
from ..diagnosis.excitation import asked
from ..diagnosis.gate import check, check_names, GateError, mended, Mending
from ..diagnosis.measurement import Measurement, measurement_from
from ..diagnosis.motor_record import is_motor_side, sweeps_of
from ..diagnosis.motor_side import diagnose_motors, MotorConclusion
from ..diagnosis.page import page
from ..diagnosis.plots import figures
from ..diagnosis.showing import exhibits_of, predictions
from ..version import version

AnyConclusion = Conclusion | MotorConclusion


def configure(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument('bags', nargs='+', type=Path, metavar='BAG',
                        help='recordings of one arm, best 60 s each')
    parser.add_argument('--arm', required=True, help='model file, or the name of a shipped one')
    parser.add_argument('--out', required=True, type=Path, metavar='DIR',
                        help='directory to write: report.html, report.json, model.yaml')
    parser.add_argument('--about', action='append', default=[], metavar='EFFECT',
                        help='say whether silence rules this effect out; EFFECT@JOINT for a joint')
    parser.add_argument('--degrees', action='store_true', help='all angles are in degrees')
    parser.add_argument('--motor-at-link', action='store_true',
                        help='motor angles are divided by the gear ratio already')
    parser.add_argument('--flip', action='append', default=[], metavar='NAME',
                        help='this angle, and the torque with it, has the other sign')
    fleet.configure(parser)


def execute(options: argparse.Namespace) -> Outcome:
    """Diagnose and write; raises the project's errors."""
    fleet.check(options)
    return fleet.execute(_together, options) if options.each else _together(options)


def _together(options: argparse.Namespace) -> Outcome:
    """Diagnose all bags as recordings of one arm, and write."""
    begin = time.monotonic()
    if options.out.exists():
        raise GateError(f'{options.out} exists; name another place for the diagnosis')
    arm = read_arm(options.arm)
    samples = open_recording(options.bags[0]).joint_states()
    if is_motor_side(samples, arm):
        return _motors(options, samples, arm, begin)
    arm = checked(arm)
    about = asked(arm, options.about)
    sources = [str(bag) for bag in options.bags]
    others = [open_recording(bag).joint_states() for bag in options.bags[1:]]
    measurement = together([_measurement(part, options, arm, source) for part, source in
                            zip([samples, *others], sources)], sources)
    found = diagnose(measurement, arm, about=about,
                     arm_file=options.arm, version=version(), sources=sources)
    spent = time.monotonic() - begin
    exhibits = None if found.evidence is None else exhibits_of(found.evidence)
    found = found._replace(diagnosis=replace(
        found.diagnosis, seconds=spent,
        prediction=() if exhibits is None else predictions(exhibits)))
    drawn = {} if exhibits is None else figures(found.diagnosis, exhibits)
    _write(found, drawn, options.out)
    return Outcome('\n'.join(found.diagnosis.sentences()), found.diagnosis.document())


def _motors(options: argparse.Namespace, samples: JointSamples, arm: Arm,
            begin: float) -> Outcome:
    """Diagnose the motors of a recording that has no link angles, and write."""
    if len(options.bags) > 1:
        raise GateError(f'{options.bags[0]} has motors alone; diagnose such bags one by one: say '
                        '--each')
    source = str(options.bags[0])
    sweeps = sweeps_of(mended(samples, arm, _mending(options), source), arm, source)
    found = diagnose_motors(sweeps, arm, arm_file=options.arm, version=version())
    found = found._replace(diagnosis=replace(found.diagnosis, seconds=time.monotonic() - begin))
    _write(found, motor_figures(found.parts), options.out)
    return Outcome('\n'.join(found.diagnosis.sentences()), found.diagnosis.document())


def _measurement(samples: JointSamples, options: argparse.Namespace, arm: Arm,
                 source: str) -> Measurement:
    """Return what a recording holds, mended as the user says; raises GateError."""
    check_names(samples, arm, source)
    measurement = measurement_from(arm.labels, mended(samples, arm, _mending(options), source))
    check(measurement, arm, source)
    return measurement


def _mending(options: argparse.Namespace) -> Mending:
    return Mending(options.degrees, options.motor_at_link, tuple(options.flip))


def _write(found: AnyConclusion, drawn: dict[str, Figure], out: Path) -> None:
    """Write the directory; it appears whole or not at all."""
    with whole_directory(out, GateError) as partial:
        write_json(partial / 'report.json', found.diagnosis.document())
        (partial / 'model.yaml').write_text(arm_to_text(found.extended), encoding='utf-8')
        inline = save_figures(drawn, partial)
        (partial / 'report.html').write_text(page(found.diagnosis, inline), encoding='utf-8')
