"""A recording gives the same bits again: by the command, and played into a live estimator."""

from functools import partial
import json
import signal

from hda_arm_sim.foundation.parameter import ParameterError
from hda_arm_sim.health import Refused
from hda_arm_sim.model.files import read_arm
from hda_arm_sim.model.writing import arm_to_text
from hda_msgs_json.bag import BagWriter, open_recording
from hda_msgs_json.cdr import decode_joint_state, encode_joint_state
from hda_msgs_json.topics import ESTIMATOR_STATE, JOINT_STATES, JOINT_TORQUES
from hda_torque_estimator.cli import main
from hda_torque_estimator.estimating.estimate_messages import estimate_topics
from hda_torque_estimator.estimating.estimator import EstimatorSettings
from hda_torque_estimator.estimating.live_estimator import LiveEstimator, StateSettings
from hda_torque_estimator.estimating.number_messages import number_topics
from hda_torque_estimator.estimating.recorded_settings import (recorded_settings, RecordedSettings,
                                                               RecordedSettingsError)
from moving_arm import moving
from node_processes import running, watching
import numpy as np
import pytest

ARM = read_arm('hda_arm.yaml')
SETTINGS = RecordedSettings(
    EstimatorSettings(velocity_bandwidth=20.0), StateSettings(state_rate=200.0))
GIVEN = ('velocity_bandwidth:=20', 'state_rate:=200')
NUMBERS = number_topics(ARM)
TOPICS = [topic.name for topic in (*estimate_topics(ARM), ESTIMATOR_STATE, *NUMBERS)]
pytestmark = pytest.mark.xdist_group('nodes')


@pytest.fixture(scope='module')
def sent():
    """Return 0.6 s of joint states of a moving arm, and what a careless driver makes of them."""
    messages = moving(ARM)
    states = [decode_joint_state(message) for message in messages]
    for at, spoil in enumerate((broken, repeated, without_velocities, shuffled, unknown,
                                too_short, named_twice)):
        messages[50 + 60 * at] = spoil(states[50 + 60 * at])
    return messages[:500] + messages[560:]              # and a gap


def broken(_):
    """Return bytes that are no message."""
    return b'\x00\x01\x00\x00 no message!'         # a multiple of four: DDS would fill it up


def repeated(state):
    """Return a sample with a stamp of the past."""
    return encode_joint_state(state.stamp_ns - 5_000_000, '', state.names, *state.numbers)


def without_velocities(state):
    """Return a sample without velocities and efforts."""
    return encode_joint_state(state.stamp_ns, 'base', state.names, state.position)


def shuffled(state):
    """Return a sample with another order of names, and one more."""
    return encode_joint_state(
        state.stamp_ns, '', ('gripper', *state.names[::-1]),
        *([9.0, *values[::-1]] for values in state.numbers))


def unknown(state):
    """Return a sample with an angle that is not known."""
    return encode_joint_state(
        state.stamp_ns, '', state.names, [np.nan, *state.position[1:]], *state.numbers[1:])


def too_short(state):
    """Return a sample that lacks a velocity."""
    return encode_joint_state(state.stamp_ns, '', state.names, state.position,
                              state.velocity[1:], state.effort)


def named_twice(state):
    """Return a good sample that names something else twice."""
    return encode_joint_state(state.stamp_ns, '', ('lamp', 'lamp', *state.names),
                              *([0.0, 0.0, *values] for values in state.numbers))


def answered(messages):
    """Return what a live estimator with these settings publishes by topic."""
    live = LiveEstimator(ARM, SETTINGS.estimator, SETTINGS.state, SETTINGS.unobserved)
    found = {name: [] for name in TOPICS}
    for message in messages:
        try:
            answer = live(message)
        except Refused:
            continue
        for name, part in zip(TOPICS, [*answer.messages, answer.state, *answer.numbers]):
            if part is not None:
                found[name].append(part)
    return found


def estimates(bag):
    """Return what a bag holds of an estimator's topics."""
    recording = open_recording(bag)
    return {name: recording.raw(name)[1] for name in TOPICS}


def write(path, messages, metadata):
    """Write joint states to a bag."""
    with BagWriter(path, metadata) as bag:
        for number, message in enumerate(messages):
            bag.write(JOINT_STATES, 10**9 + number, message)


def at_least(heard, count):
    """Return whether so many messages have come."""
    return len(heard) >= count


def test_recording_gives_the_bits_of_the_live_run_by_command_and_played(sent, tmp_path):
    """Nothing that a driver sends makes a difference between live, offline and replay."""
    expected = answered(sent)
    assert len(expected['joint_torques']) == len(sent) - 4
    live, again, replayed = (tmp_path / name for name in ('live', 'again', 'replayed'))
    with watching() as watcher, running(
            tmp_path, torque_estimator=GIVEN, bag_recorder=(f'output:={live}',)) as nodes:
        torques, state = watcher.hear(JOINT_TORQUES), watcher.hear(ESTIMATOR_STATE)
        send = watcher.send(JOINT_STATES, 2)
        watcher.until_read({**dict.fromkeys((*estimate_topics(ARM), *NUMBERS), 1),
                            JOINT_TORQUES: 2, ESTIMATOR_STATE: 2})
        watcher.until(partial(recorded, live, 'velocity_bandwidth'), 'the settings')
        for first in range(0, len(sent), 100):          # never more on their way than queues hold
            watcher.until(partial(at_least, torques, first - 100), 'estimates')
            for message in sent[first:first + 100]:
                send(message)
        watcher.until(lambda: len(torques) == len(expected['joint_torques']), 'all estimates')
        watcher.until(lambda: len(state) == len(expected['estimator_state']), 'all states')
        end(nodes)
    assert open_recording(live).raw('joint_states')[1] == sent
    assert estimates(live) == expected
    assert main(['estimate', str(live), '--arm', 'hda_arm.yaml', '--out', str(again)]) == 0
    assert estimates(again) == expected
    with watching() as watcher, running(
            tmp_path, torque_estimator=GIVEN, bag_recorder=(f'output:={replayed}',)) as nodes:
        watcher.until_read({**dict.fromkeys((*estimate_topics(ARM), *NUMBERS), 1),
                            JOINT_STATES: 2, ESTIMATOR_STATE: 1})
        watcher.until(partial(recorded, replayed, 'velocity_bandwidth'), 'the settings')
        with running(tmp_path, bag_player=(             # both readers, on a stalled machine too
                f'bag:={live}', 'topics:=[joint_states]', 'settle_time:=10')) as player:
            assert player['bag_player'].wait() == 0, player['bag_player'].said
        watcher.until(lambda: counted(replayed) == len(expected['joint_torques']), 'the end')
        end(nodes)
    assert open_recording(replayed).raw('joint_states')[1] == sent
    assert estimates(replayed) == expected


def recorded(bag, word):
    """Return whether a word is in the metadata of a bag that is being recorded."""
    return (bag / 'metadata.yaml').exists() and word in open_recording(bag).metadata['parameters']


def counted(bag):
    """Return how many joint torques are in a bag that is being recorded."""
    topics = open_recording(bag).topics
    return topics['/joint_torques'].count if '/joint_torques' in topics else 0


def end(nodes):
    """End nodes one after the other, and see that they end well."""
    for node in nodes.values():
        node.send(signal.SIGINT)
        assert node.wait() == 0, node.said


@pytest.mark.parametrize('chosen', [slice(0, 40), slice(45, 55), slice(None)],
                         ids=['sound', 'one broken', 'all'])
def test_command_refuses_what_the_node_refuses(sent, tmp_path, chosen, capsys):
    write(tmp_path / 'bag', sent[chosen], SETTINGS.to_metadata())
    out = tmp_path / 'out'
    assert main(['estimate', str(tmp_path / 'bag'), '--arm', 'hda_arm.yaml', '--out', str(out),
                 '--json']) == 0
    expected = answered(sent[chosen])
    assert estimates(out) == expected
    report = json.loads(capsys.readouterr().out)
    assert report['samples'] == len(expected['joint_torques'])
    assert report['samples'] + report['refused'] == len(sent[chosen])


def test_settings_can_be_left_aside(sent, tmp_path):
    for name, metadata in (('stated', SETTINGS.to_metadata()), ('unstated', {})):
        write(tmp_path / name, sent[:40], metadata)
        assert main(['estimate', str(tmp_path / name), '--arm', 'hda_arm.yaml',
                     '--out', str(tmp_path / f'{name}_out'), '--default-settings']) == 0
    assert estimates(tmp_path / 'stated_out') == estimates(tmp_path / 'unstated_out')
    assert estimates(tmp_path / 'stated_out') != answered(sent[:40])


def test_settings_come_back_from_metadata():
    assert recorded_settings(SETTINGS.to_metadata()) == SETTINGS
    assert recorded_settings({'arm': arm_to_text(ARM)}) == RecordedSettings()
    assert recorded_settings({'parameters': '{"arm_sim": {"rate": 5}}'}) == RecordedSettings()


@pytest.mark.parametrize(('text', 'error'), [
    ('{', RecordedSettingsError), ('[]', RecordedSettingsError),
    ('{"torque_estimator": 3}', RecordedSettingsError),
    ('{"torque_estimator": {"state_rate": -1}}', ParameterError),
    ('{"torque_estimator": {"state_rate": "fast"}}', ParameterError)])
def test_settings_that_cannot_be_read_are_named(text, error):
    with pytest.raises(error, match='torque_estimator|state_rate|JSON'):
        recorded_settings({'parameters': text})


def test_nothing_readable_is_said_as_before(sent, tmp_path, capsys):
    write(tmp_path / 'bag', [encode_joint_state(1, '', ('a',), (0.0,))], {})
    assert main(['estimate', str(tmp_path / 'bag'), '--arm', 'hda_arm.yaml',
                 '--out', str(tmp_path / 'out')]) == 2
    said = capsys.readouterr().err
    assert len(said.splitlines()) == 1
    assert 'the names must hold joint1_motor' in said
