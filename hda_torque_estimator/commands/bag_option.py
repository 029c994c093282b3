"""The options that say how a bag of others names its topics and joints, the same everywhere."""

import argparse
from collections.abc import Callable
from pathlib import Path

from hda_msgs_json.bag import Recording

from ..measurements.renamed_recording import Naming, naming_of, open_named

NAMING = ('topic', 'link_topic', 'motor_topic', 'name', 'even_stamps')
"""What the options are called."""


def add_naming(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    group = parser.add_argument_group('bags of others')
    group.add_argument('--topic', metavar='TOPIC',
                       help='joint states of both sides, JointState or DynamicJointState; '
                            'joint_states unless given, in any namespace if only one has it')
    group.add_argument('--link-topic', metavar='TOPIC',
                       help='joint states of the links alone, paired by stamp with --motor-topic')
    group.add_argument('--motor-topic', metavar='TOPIC',
                       help='joint states of the motor shafts alone; joint1 there is joint1_motor')
    group.add_argument('--name', action='append', default=[], metavar='THEIRS=OURS',
                       help='a name in the bag and the one of the arm file, as m1=joint1_motor or '
                            '"mot_*=joint*_motor"; may be given again')
    group.add_argument('--even-stamps', action='store_true',
                       help='stamps of a host that come late or in bursts become even')


def naming(options: argparse.Namespace) -> Naming:
    """Return what the options say; raises NamingError."""
    return naming_of(options.topic, (options.link_topic, options.motor_topic), options.name,
                     even=options.even_stamps)


def opener(options: argparse.Namespace) -> Callable[[Path], Recording]:
    """Return what opens a recording as the options say; raises NamingError."""
    chosen = naming(options)
    return lambda path: open_named(path, chosen)
