"""Joint states of ordinary drivers: their names, and a topic for each side, paired by stamp."""

from collections.abc import Iterator
import json
import signal

from hda_arm_sim.health import Refused
from hda_arm_sim.model.files import read_arm
from hda_msgs_json.bag import BagWriter, open_recording
from hda_msgs_json.cdr import decode_joint_state, encode_joint_state
from hda_msgs_json.topics import JOINT_STATES, JOINT_TORQUES, MOTOR_COMMAND, Topic
from hda_torque_estimator import cli
from hda_torque_estimator.estimating.live_estimator import LiveEstimator
from hda_torque_estimator.samples.driver_states import (Driver, DriverError, DriverStates,
                                                        MOST_WAITING)
from moving_arm import moving
from node_processes import running, watching
import numpy as np
import pytest

ARM = read_arm('hda_arm.yaml')
NAMED = Driver(link=('shoulder', 'elbow'), motor=('m1', 'm2'))
APART = Driver(link=('a1', 'a2'), motor=('a1', 'a2'), link_topic='links', motor_topic='motors')
PARAMETERS = {NAMED: ('link:=[shoulder, elbow]', 'motor:=[m1, m2]'),
              APART: ('link:=[a1, a2]', 'motor:=[a1, a2]', 'link_topic:=links',
                      'motor_topic:=motors')}
Sent = list[tuple[str, bytes]]


@pytest.fixture(scope='module')
def usual() -> list[bytes]:
    """Return the messages of an arm that moves, with the usual names."""
    return moving(ARM)[:200]


def as_sent(driver: Driver, messages: list[bytes]) -> Sent:
    """Return what a driver would publish of the same samples, others than its joints among it."""
    return [each for message in messages for each in _sides(driver, message)]


def _sides(driver: Driver, message: bytes) -> Iterator[tuple[str, bytes]]:
    state = decode_joint_state(message)
    order = [state.names.index(name) for name in (*ARM.labels, 'joint1_motor', 'joint2_motor')]
    numbers = [values[order] for values in state.numbers]
    if driver.link_topic:
        for topic, names, part in (('links', driver.link, slice(0, 2)),
                                   ('motors', driver.motor, slice(2, 4))):
            yield topic, encode_joint_state(
                state.stamp_ns, 'world', names[::-1], *(values[part][::-1] for values in numbers))
    else:
        names = ('gripper', *driver.link, *driver.motor)
        yield 'joint_states', encode_joint_state(
            state.stamp_ns, '', names, *(np.append(9.0, values) for values in numbers))


@pytest.mark.parametrize('driver', [NAMED, APART])
def test_the_estimates_are_those_of_the_usual_names(driver, usual):
    states = DriverStates(ARM.labels, driver)
    samples = [states(topic, message) for topic, message in as_sent(driver, usual)]
    paired = [sample for sample in samples if sample is not None]
    assert len(paired) == len(usual)
    live, plain = LiveEstimator(ARM), LiveEstimator(ARM)
    assert [live(sample) for sample in paired] == [plain(message) for message in usual]


def test_the_usual_names_stay_as_they_are(usual):
    states = DriverStates(ARM.labels)
    assert states.topics == (JOINT_STATES,)
    assert all(states('joint_states', message) is message for message in usual[:3])
    assert states.command(usual[0]) is usual[0]


def test_sides_come_in_any_order_and_pair_by_stamp(usual):
    states, sent = DriverStates(ARM.labels, APART), as_sent(APART, usual[:20])
    links = [each for each in sent if each[0] == 'links']
    motors = [each for each in sent if each[0] == 'motors']
    assert [states(*each) for each in links[:10]] == [None] * 10
    found = [states(*each) for each in motors[:12]]
    assert found[10:] == [None, None]
    assert [decode_joint_state(each).stamp_ns for each in found[:10]] == [
        decode_joint_state(message).stamp_ns for message in usual[:10]]
    assert states(*links[11]) is not None
    assert states(*links[10]) is None                   # older than one that is answered


def test_a_side_that_never_finds_its_other_is_refused():
    states = DriverStates(ARM.labels, APART)

    def send(stamp: int) -> None:
        states('links', encode_joint_state(stamp, '', ('a1', 'a2'), (0.0, 0.0)))

    for stamp in range(MOST_WAITING):
        send(stamp)
    with pytest.raises(Refused, match='motors has none at 0.000000000 s') as refused:
        send(MOST_WAITING)
    assert refused.value.reason == 'without its other side'


@pytest.mark.parametrize('message', [b'no message', encode_joint_state(1, '', ('a1',), (0.0,)),
                                     encode_joint_state(1, '', ('a1', 'a2'), (0.0,))])
def test_what_cannot_be_read_is_refused(message):
    with pytest.raises(Refused):
        DriverStates(ARM.labels, APART)('links', message)


@pytest.mark.parametrize(('driver', 'said'), [
    (Driver(link=('a',)), 'link must name each of joint1, joint2 once, in this order, got a'),
    (Driver(motor=('a', 'a')), 'motor must name each'),
    (Driver(link_topic='links'), 'must be given together'),
    (Driver(link_topic='x', motor_topic='x'), "must differ, got 'x' twice"),
    (Driver(link=('a', 'b'), motor=('b', 'c')), 'must have different names on one topic, got b')])
def test_names_that_do_not_fit_are_reported(driver, said):
    with pytest.raises(DriverError, match=said):
        DriverStates(ARM.labels, driver)


@pytest.mark.parametrize('driver', [NAMED, APART])
def test_the_command_gives_the_bits_of_the_node(driver, usual, tmp_path, capsys):
    """The recording states which names the node was given."""
    given = json.dumps({'torque_estimator': {**driver._asdict(), 'unobserved': 'zero'}})
    with BagWriter(tmp_path / 'bag', {'parameters': given}) as bag:
        for number, (topic, message) in enumerate(as_sent(driver, usual)):
            bag.write(Topic(topic, JOINT_STATES.message_type, 10), number, message)
    assert cli.main(['estimate', str(tmp_path / 'bag'), '--arm', 'hda_arm.yaml', '--out',
                     str(tmp_path / 'out')]) == 0
    capsys.readouterr()
    live, made = LiveEstimator(ARM, unobserved='zero'), open_recording(tmp_path / 'out')
    answers = [live(message).messages for message in usual]
    for column, topic in enumerate(('joint1/torque', 'joint2/torque', 'joint_torques',
                                    'tip/wrench', 'tip/wrench_tool')):
        assert made.raw(topic)[1] == [answer[column] for answer in answers]


@pytest.mark.xdist_group('nodes')
@pytest.mark.parametrize('driver', [NAMED, APART])
def test_nodes_work_with_a_driver(driver, usual, tmp_path):
    """Estimates and commands come, with the names that the driver has for its motors."""
    with watching() as watcher, running(
            tmp_path, torque_estimator=PARAMETERS[driver],
            jtf_controller=(*PARAMETERS[driver], 'enabled:=true', 'sample_timeout:=1.0')) as nodes:
        torques, commands = watcher.hear(JOINT_TORQUES), watcher.hear(MOTOR_COMMAND)
        sends = {topic: watcher.send(Topic(topic, JOINT_STATES.message_type, 100), 2)
                 for topic, _ in as_sent(driver, usual[:1])}
        left = iter(as_sent(driver, usual * 5))

        def answered() -> bool:
            topic, message = next(left)
            sends[topic](message)
            return bool(torques and commands)

        watcher.until(answered, 'estimates and commands')
        assert decode_joint_state(commands[0]).names == driver.motor
        nodes['torque_estimator'].send(signal.SIGINT)
        assert nodes['torque_estimator'].wait() == 0
