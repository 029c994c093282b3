"""Many bags in one call: each gets its own diagnosis, the same wherever it is made."""

import argparse
import json
import os
from pathlib import Path
import signal
import subprocess
import sys
import time

from hda_msgs_json.bag import BagWriter
from hda_msgs_json.samples import JointSamples
from hda_msgs_json.topics import JOINT_STATES
from hda_torque_estimator.cli import main
from hda_torque_estimator.commands.fleet import execute
from hda_torque_estimator.commands.fleet_bags import bags_in, FleetError
from hda_torque_estimator.commands.outcome import Outcome
from hda_torque_estimator.fleet.fleet_page import fleet_page
from hda_torque_estimator.fleet.fleet_report import fleet_document
from hda_torque_estimator.fleet.lines import BagLine, NamedCause
from hda_torque_estimator.fleet.spread import (
    machine_memory, over_machines, over_processes, SpreadError)
from hda_torque_estimator.measurements.recording_checks import GateError
import numpy as np
from project_files import ROOT
import pytest

PATIENCE = 60.0         # of a process for another: nothing is measured by it [s]
LINES = [BagLine('a', 'a', 'explained', (NamedCause('payload', None, 0.99),), 2.0),
         BagLine('b', 'b', 'no_discrepancy', (), 1.0),
         BagLine('c', 'c', None, error='c: 1 s are too short & no more')]


def pretended(options):
    """Stand for a diagnosis: write a report, or fail as an unusable bag does."""
    bag = options.bags[0]
    if bag.name == 'broken':
        raise GateError(f'{bag}: no bag')
    if bag.name == 'greedy':
        kept = [np.empty(1 << 30, np.uint8) for _ in range(8 + (machine_memory() >> 30))]
        raise AssertionError(f'{len(kept)} GiB were there')
    if bag.name == 'deadly':
        os.kill(os.getpid(), signal.SIGSEGV)
    if bag.name == 'odd':
        raise KeyError('nobody thought of this')
    report = {'verdict': 'explained', 'seconds': 1.0, 'findings': [
        {'effect': 'payload', 'joint': None, 'gain': {'removed': len(bag.name) / 10.0}}]}
    options.out.mkdir()
    (options.out / 'report.json').write_text(json.dumps(report))
    return Outcome('', report)


def asked(bags, out, **others):
    """Return the options of a call."""
    return argparse.Namespace(**{'bags': [bags], 'out': out, 'arm': 'hda_arm.yaml', 'each': True,
                                 'workers': 1, 'scheduler': None, 'force': False, 'update': False,
                                 'alarm': None, 'json': True, **others})


@pytest.fixture(scope='module')
def bags(tmp_path_factory):
    """Return a directory that holds what looks like three bags."""
    place = tmp_path_factory.mktemp('bags')
    for name in ('broken', 'run1', 'run02'):
        (place / name).mkdir()
        (place / name / 'metadata.yaml').write_text('no bag')
    return place


def written(out):
    """Return all that a fleet wrote."""
    return {path.relative_to(out): path.read_text() for path in out.rglob('*.*')
            if path.is_file()}


def test_a_bag_that_fails_gives_its_line_and_stops_no_other(bags, tmp_path):
    found = execute(pretended, asked(bags, tmp_path / 'out'))
    assert [(line['directory'], line['verdict']) for line in found.report['bags']] == [
        ('broken', None), ('run02', 'explained'), ('run1', 'explained')]
    assert found.report['verdicts'] == {'explained': 2, 'not diagnosed': 1}
    assert found.text.splitlines()[2] == 'run1: explained: payload at the arm'
    assert 'no bag' in found.text.splitlines()[0]
    assert json.loads((tmp_path / 'out' / 'fleet.json').read_text()) == found.report
    assert 'run1/report.html' in (tmp_path / 'out' / 'fleet.html').read_text()


@pytest.mark.parametrize('workers', [1, 2])
def test_no_bag_ends_a_fleet(workers, tmp_path):
    for name in ('deadly', 'greedy', 'odd', 'run1'):
        (tmp_path / 'bags' / name).mkdir(parents=True)
        (tmp_path / 'bags' / name / 'metadata.yaml').write_text('no bag')
    found = execute(pretended, asked(tmp_path / 'bags', tmp_path / 'out', workers=workers))
    deadly, greedy, odd, good = found.report['bags']
    assert deadly['error'] == 'its process was ended by SIGSEGV'
    assert 'it needs more memory than there is' in greedy['error']
    assert 'unforeseen KeyError' in odd['error']
    assert good['verdict'] == 'explained'


def test_processes_and_machines_give_the_answers_of_one_core(bags, tmp_path):
    alone = execute(pretended, asked(bags, tmp_path / 'alone'))
    assert execute(pretended, asked(bags, tmp_path / 'two', workers=2)) == alone
    assert written(tmp_path / 'two') == written(tmp_path / 'alone')
    distributed = pytest.importorskip('distributed')
    with distributed.LocalCluster(n_workers=1, threads_per_worker=1, processes=False,
                                  dashboard_address=None) as cluster:
        spread = execute(pretended, asked(bags, tmp_path / 'dask',
                                          scheduler=cluster.scheduler_address))
    assert spread == alone
    assert written(tmp_path / 'dask') == written(tmp_path / 'alone')


def motor_bag(path, level):
    """Write a recording of a motor alone, with so much friction."""
    time = 1e-3 * np.arange(8000)
    speed = 40.0 * np.sin(2.0 * np.pi * time / 4.0)
    torque = level * np.sign(speed) + 2e-3 * np.random.default_rng(1).standard_normal(len(time))
    with BagWriter(path, {}) as bag:
        bag.write_joint_states(JOINT_STATES, JointSamples(
            1 + 1_000_000 * np.arange(len(time)), ('joint1_motor',),
            np.cumsum(speed)[:, None] * 1e-3, np.full((len(time), 1), np.nan), torque[:, None]))


def test_bags_are_diagnosed_as_they_are_alone(tmp_path):
    for name, level in (('run1', 0.05), ('run2', 0.08)):
        motor_bag(tmp_path / 'bags' / name, level)
    bag, out = tmp_path / 'bags' / 'run1', tmp_path / 'out'
    assert main(['diagnose', '--each', str(bag.parent), '--arm', 'kinova_gen3.yaml', '--out',
                 str(out), '--workers', '2']) == 0
    assert main(['diagnose', str(bag), '--arm', 'kinova_gen3.yaml', '--out',
                 str(tmp_path / 'alone')]) == 0
    alone, fleet = (json.loads((place / 'report.json').read_text())
                    for place in (tmp_path / 'alone', out / 'run1'))
    assert [cause['effect'] for cause in fleet['findings']] == ['coulomb_friction']
    del alone['seconds'], fleet['seconds']
    assert fleet == alone
    assert sorted(path.name for path in out.iterdir()) == [
        'fleet.html', 'fleet.json', 'run1', 'run2']


@pytest.mark.parametrize(('words', 'says'), [
    (['--workers', '2'], '--workers is for the diagnoses of --each'),
    (['--each', '--workers', '0'], '--workers must be at least 1, got 0'),
    (['--each', '--scheduler', 'tcp://127.0.0.1:9'], 'no Dask scheduler answers'),
])
def test_workers_that_cannot_be_had_are_one_line(words, says, bags, tmp_path, capsys, monkeypatch):
    if '--scheduler' in words:
        pytest.importorskip('distributed')
    monkeypatch.setattr('hda_torque_estimator.fleet.spread.PATIENCE', 0.5)
    out = tmp_path / 'out'
    assert main(['diagnose', str(bags), '--arm', 'hda_arm.yaml', '--out', str(out), *words]) == 2
    said = capsys.readouterr().err.splitlines()
    assert says in said[-1]
    assert list(tmp_path.iterdir()) == []


def test_a_fleet_of_unusable_bags_is_one_line(bags, tmp_path, capsys):
    assert main(['diagnose', '--each', str(bags / 'broken'), '--arm', 'hda_arm.yaml', '--out',
                 str(tmp_path / 'out')]) == 2
    assert 'none of 1 bags could be diagnosed' in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_dask_that_is_missing_is_one_line(monkeypatch):
    monkeypatch.setitem(sys.modules, 'distributed', None)
    with pytest.raises(SpreadError, match='install the extra "fleet"'):
        over_machines(abs, [1], 'tcp://127.0.0.1:9')


def killed(item):
    """End the own process, as a machine does where memory runs out."""
    os.kill(os.getpid(), signal.SIGKILL)


def test_how_a_process_ended_is_known_whichever_others_start_meanwhile():
    ends = over_processes(killed, range(60), 8, failed=lambda item, reason: reason)
    assert set(ends) == {'its process was ended by SIGKILL, as where memory runs out'}


def test_results_come_in_the_order_of_the_items():
    assert over_processes(abs, [-3, 1, -2], 2) == [3, 1, 2]
    assert over_processes(abs, []) == []


def test_workers_import_nothing_from_the_folder_where_they_are_started(tmp_path):
    (tmp_path / 'colorsys.py').write_text('open("imported", "x").close()\n')
    done = subprocess.run(
        [sys.executable, '-c', 'from hda_torque_estimator.fleet.spread import over_processes\n'
         'print(over_processes(abs, [-3], 1, needed=["colorsys"]))'],
        cwd=tmp_path, env={**os.environ, 'PYTHONPATH': str(ROOT)}, capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ('[3]\n', '')
    assert not (tmp_path / 'imported').exists()


def in_turn(place: Path) -> str:
    """Return the name of a recording; the slow one waits until the quick one was heard."""
    end = time.monotonic() + PATIENCE
    while place.name == 'slow' and not place.with_name('quick').exists():
        assert time.monotonic() < end, 'waited in vain for the quick one'
        time.sleep(0.01)
    return place.name


def test_a_result_is_heard_as_soon_as_it_is_there(tmp_path):
    """A slow recording holds up no news of the others; the answer keeps its order."""
    heard: list[str] = []

    def hear(name: str) -> None:
        heard.append(name)
        (tmp_path / name).touch()

    made = over_processes(in_turn, [tmp_path / 'slow', tmp_path / 'quick'], 2, heard=hear)
    assert (made, heard) == (['slow', 'quick'], ['quick', 'slow'])


def test_a_directory_of_bags_is_all_its_bags(bags, tmp_path):
    assert bags_in(bags) == [bags / name for name in ('broken', 'run02', 'run1')]
    assert bags_in(bags / 'run1') == [bags / 'run1']
    assert bags_in(Path('absent')) == [Path('absent')]
    with pytest.raises(FleetError, match='holds no bags'):
        bags_in(tmp_path)


def test_the_table_counts_verdicts_and_causes():
    report = fleet_document(LINES, 'arm.yaml', '1')
    assert report['verdicts'] == {'explained': 1, 'no_discrepancy': 1, 'not diagnosed': 1}
    assert report['effects'] == [{'effect': 'payload', 'joint': None, 'bags': 1}]
    shown = fleet_page(LINES, 'arm.yaml', '1')
    assert 'too short &amp; no more' in shown
    assert 'href="./a/report.html"' in shown and 'href="./c/report.html"' not in shown


@pytest.mark.parametrize(('name', 'link'), [
    ('javascript:alert(1)', './javascript%3Aalert%281%29/report.html'),
    ('a#b?c%d', './a%23b%3Fc%25d/report.html'), ('\udcff', './%FF/report.html'),
    ('"><script>', './%22%3E%3Cscript%3E/report.html')])
def test_a_link_leads_to_its_directory_whatever_its_name(name, link):
    shown = fleet_page([BagLine(name, name, 'explained')], 'arm.yaml', '1')
    assert f'href="{link}"' in shown
    assert shown.encode() and '<script>' not in shown
