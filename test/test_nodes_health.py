"""Nodes count what they refuse, are brief in the log, and say how they are doing."""

from hda_arm_sim.health import Level, PAUSE, Refusals, Stopwatch
from hda_arm_sim.model.files import read_arm
from hda_msgs_json import topics
from hda_msgs_json.cdr import encode_joint_state
from hda_torque_estimator.controlling.controller_report import controller_report
from hda_torque_estimator.controlling.live_controller import LiveController
from hda_torque_estimator.estimating.estimator_report import estimator_report
from hda_torque_estimator.estimating.live_estimator import LiveEstimator
from hda_torque_estimator.estimating.number_messages import number_topics
from hda_torque_estimator.recording.recorded_topics import awaited, chosen_topics, system_topics
from hda_torque_estimator.samples.readings import reading_names
import pytest

ARM = read_arm('hda_arm.yaml')
SAMPLE = encode_joint_state(10**9, '', reading_names(ARM.labels), [30.0, 0.3, 120.0, 1.2])
NONE_YET = Stopwatch(0.0).take(1.0)


def paced(*answers: tuple[float, float]):
    """Return the pace of a second with these (work, latency) in seconds."""
    stopwatch = Stopwatch(0.0)
    for answer in answers:
        stopwatch.add(*answer)
    return stopwatch.take(1.0)


def test_each_reason_is_reported_once_in_a_while():
    refusals = Refusals()
    reported = [refusals.add('names', k * 0.1) for k in range(100)]
    assert sum(reported) == round(10.0 / PAUSE)
    assert reported[0]
    assert refusals.add('lengths', 0.05)                # another reason does not wait
    assert refusals.counts == {'names': 100, 'lengths': 1}


def test_new_refusals_are_those_since_the_last_report():
    refusals = Refusals()
    refusals.add('names', 0.0)
    assert refusals.take_new() == 1
    assert refusals.take_new() == 0
    assert refusals.values() == {'refused: names': 1}


def test_pace_is_that_of_the_time_since_it_was_asked():
    stopwatch = Stopwatch(10.0)
    stopwatch.add(1e-4, 2e-3)
    stopwatch.add(3e-4, 4e-3)
    pace = stopwatch.take(10.5)
    assert pace == pytest.approx((4.0, 2e-4, 3e-4, 3e-3))
    assert stopwatch.take(11.5) == (0.0, 0.0, 0.0, 0.0)


def test_latency_is_not_guessed_from_stamps_of_another_clock():
    assert paced((1e-4, 2e-3)).values()['latency from the stamp [ms]'] == pytest.approx(2.0)
    replayed = paced((1e-4, 1e9)).values()['latency from the stamp [ms]']
    assert replayed == 'unknown: the stamps are of another clock'


def test_estimator_reports_silence_refusals_and_flags():
    live, refusals = LiveEstimator(ARM), Refusals()
    silent = estimator_report(live, NONE_YET, refusals)
    assert (silent.level, silent.message) == (Level.WARN, 'no joint_states that can be used')
    live(SAMPLE)
    well = estimator_report(live, paced((1e-4, 0.0)), refusals)
    assert (well.level, well.message) == (Level.OK, '1.0 Hz')
    assert well.values['samples answered'] == 1
    assert well.values['beyond the valid range'] == 'none'
    refusals.add('wrong names', 0.0)
    bad = estimator_report(live, paced((1e-4, 0.0)), refusals)
    assert (bad.level, bad.message) == (Level.WARN, '1 joint_states refused, 1.0 Hz')
    assert bad.values['refused: wrong names'] == 1


def test_estimator_names_the_joint_beyond_its_range():
    live = LiveEstimator(ARM)
    live(encode_joint_state(10**9, '', reading_names(ARM.labels), [30.0, 0.2, 120.0, 1.2]))
    report = estimator_report(live, NONE_YET, Refusals())
    assert report.values['beyond the valid range'] == 'joint1'


def test_controller_reports_why_it_stopped():
    live, refusals = LiveController(ARM), Refusals()
    assert controller_report(live, NONE_YET, refusals).message == 'disabled'
    live.sample(SAMPLE, 0.0)
    live.enable(0.0)
    assert controller_report(live, paced((1e-4, 0.0)), refusals).message == 'enabled, 1.0 Hz'
    live.watch(1.0)
    stopped = controller_report(live, NONE_YET, refusals)
    assert stopped.level is Level.ERROR
    assert stopped.message.startswith('stopped: no joint_states that can be used for 0.012 s')


def test_every_topic_of_the_system_is_recorded():
    """
    Each constant and each function of the topics module has its place in a recording.

    But for the description of the arm: whoever shows a recording has the model file.
    """
    constants = {topic for topic in vars(topics).values() if isinstance(topic, topics.Topic)}
    of_joints = {make(label) for label in ARM.labels
                 for make in (topics.joint_torque, topics.truth_joint_torque,
                              topics.reference_joint_torque)}
    recorded = system_topics(ARM)
    assert set(recorded) == (constants | of_joints | set(number_topics(ARM))) - {
        topics.ROBOT_DESCRIPTION}
    assert len(set(recorded)) == len(recorded)


def test_topics_are_chosen_by_name_and_pattern():
    assert chosen_topics(ARM, [], []) == list(system_topics(ARM))
    found = chosen_topics(ARM, ['/joint_states', 'tip/*', 'diagnostics', 'lidar'], ['*/wrench'])
    assert [topic.name for topic in found] == ['joint_states', 'tip/wrench_tool', '/diagnostics']
    assert awaited(found, ['/joint_states', 'lidar', 'camera/*']) == ['lidar']
