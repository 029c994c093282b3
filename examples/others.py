"""
Record the joint states of a bag as somebody else's driver would: a topic for each side.

    others.py BAG OUT
"""

from dataclasses import replace
from pathlib import Path
import sys

from hda_msgs_json.bag import BagWriter, open_recording
from hda_msgs_json.topics import JOINT_STATES

samples = open_recording(Path(sys.argv[1])).joint_states()
with BagWriter(Path(sys.argv[2]), {}) as bag:
    for side, name in (('load', 'joint1'), ('drive', 'joint1_motor')):
        topic = replace(JOINT_STATES, name=f'robot/{side}')
        bag.write_joint_states(topic, replace(samples.select([name]), names=('axis_1',)))
