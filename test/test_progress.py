"""A terminal sees what a command is doing; a pipe and a machine see nothing of it."""

from contextlib import contextmanager, suppress
import os
import re
import sys
from threading import Thread
import time

from hda_torque_estimator.cli import main
from hda_torque_estimator.commands import fleet
from hda_torque_estimator.commands.progress import progress, starting
from hda_torque_estimator.fleet.lines import BagLine
import pytest
from test_fleet import asked


def read_on(end, heard):
    """Take down what comes out of a terminal or a pipe until nobody writes to it any more."""
    with os.fdopen(end, 'rb', buffering=0) as stream, suppress(OSError):    # so ends a terminal
        while some := stream.read(1 << 16):
            heard.append(some.decode())


@contextmanager
def stderr_of(monkeypatch, pair):
    """Let the other end of a terminal or a pipe be stderr; yields a list of what comes out."""
    heard = []
    monkeypatch.setenv('TERM', 'xterm')
    reader = Thread(target=read_on, args=(pair[0], heard))
    reader.start()
    with os.fdopen(pair[1], 'w') as said:
        monkeypatch.setattr(sys, 'stderr', said)
        yield heard
    reader.join()


def test_a_terminal_sees_the_text_and_nothing_stays(monkeypatch):
    with stderr_of(monkeypatch, os.openpty()) as heard, progress(quiet=False) as notify:
        notify('weighing [1] \x1b[31m of 2')
    shown = ''.join(heard)
    assert 'weighing [1] ' in shown
    assert '\x1b[31m' not in shown
    assert shown.endswith('\x1b[2K')            # the line is erased


@pytest.mark.parametrize(('pair', 'quiet'), [(os.pipe, False), (os.openpty, True)])
def test_a_pipe_and_a_machine_see_nothing(monkeypatch, pair, quiet):
    with stderr_of(monkeypatch, pair()) as heard, progress(quiet=quiet) as notify:
        notify('weighing')
    assert heard == []


@pytest.mark.parametrize(('pair', 'lasts', 'shown'), [
    (os.openpty, 0.3, '  starting hda plan\r\x1b[K'), (os.openpty, 0.0, ''), (os.pipe, 0.3, '')])
def test_a_terminal_hears_of_a_slow_start(monkeypatch, pair, lasts, shown):
    monkeypatch.setattr('hda_torque_estimator.commands.progress._AT_ONCE', 0.1)
    with stderr_of(monkeypatch, pair()) as heard, starting('plan'):
        time.sleep(lasts)
    assert ''.join(heard) == shown


@pytest.fixture(scope='module')
def bag(tmp_path_factory):
    """Return a short bag in which something is to be found."""
    folder = tmp_path_factory.mktemp('bags')
    (folder / 'hidden.yaml').write_text('- {effect: viscous_friction, joint: joint1}\n')
    assert main(['simulate', '--arm', 'hda_arm.yaml', '--effects', str(folder / 'hidden.yaml'),
                 '--motion', 'rich', '--duration', '10', '--seed', '3',
                 '--out', str(folder / 'bag')]) == 0
    return folder / 'bag'


@pytest.mark.parametrize('pair', [os.openpty, os.pipe])
def test_a_diagnosis_says_what_it_does_on_a_terminal_alone(bag, tmp_path, monkeypatch, capsys,
                                                           pair):
    capsys.readouterr()
    with stderr_of(monkeypatch, pair()) as heard:
        assert main(['diagnose', str(bag), '--arm', 'hda_arm.yaml', '--out',
                     str(tmp_path / 'out')]) == 0
    shown = ''.join(heard)
    stages = ('looking at the raw readings', 'fitting the arm', 'looking for cause 1',
              'judging the causes', 'measuring the gain', 'drawing')
    places = [shown.find(stage) for stage in stages if stage in shown]  # short ones may not be
    assert ('looking for cause 1' in shown) == (pair is os.openpty)
    assert places == sorted(places)
    assert pair is os.openpty or shown == ''
    assert '\x1b' not in capsys.readouterr().out


MOTOR = '--gear CSG-17-100 --motor-inertia 5e-6 --motor-torque 0.3'
COMMANDS = {
    'simulating 60 s': 'simulate --arm hda_arm.yaml --motion sine --duration 60 --out {}',
    'estimating': 'estimate {bag} --arm hda_arm.yaml --out {}',
    'comparing': 'compare {bag} {bag} --out {}',
    'reading bag': 'info {bag}',
    'exporting bag': 'export {bag} --out {}.csv',
    'drawing fig7': 'reproduce fig7 --out {}',
    'reading ': f'new --from {{bag}} {MOTOR} --out {{}}'}


@pytest.mark.parametrize('said', COMMANDS)
def test_a_command_that_may_take_a_while_says_what_it_does(said, bag, tmp_path, monkeypatch,
                                                           capsys):
    with stderr_of(monkeypatch, os.openpty()) as heard:
        assert main(COMMANDS[said].format(tmp_path / 'made', bag=bag).split()) == 0
    assert said in ''.join(heard)


def test_a_fleet_shows_the_time_that_is_left(tmp_path, monkeypatch):
    for name in 'abc':
        (tmp_path / 'bags' / name).mkdir(parents=True)
        (tmp_path / 'bags' / name / 'metadata.yaml').touch()

    def slow(work, jobs, workers, *, failed, heard, needed):
        for job in jobs:
            time.sleep(0.3)         # longer than the terminal is drawn anew
            heard(BagLine(job.bag.path.name, job.bag.directory, 'no_discrepancy', severity=1.0))
        return []

    monkeypatch.setattr(fleet, 'over_processes', slow)
    with stderr_of(monkeypatch, os.openpty()) as heard:
        fleet.execute(lambda options: None, asked(
            tmp_path / 'bags', tmp_path / 'out', json=False))
    shown = ''.join(heard)
    places = [shown.index(f'diagnosing {done} of 3') for done in range(3)]
    assert places == sorted(places)
    assert re.search(r'1 of 3, \d+ s left', shown)
