"""`hda estimate` and `hda calibrate` write a page if asked, whole or not at all."""

from pathlib import Path

from hda_torque_estimator.cli import main
from hda_torque_estimator.commands import calibrate_command
import pytest
from test_page import Reader
from test_page_layout import calibrated

ARM = ('--arm', 'hda_arm.yaml')


@pytest.fixture(scope='module')
def bag(tmp_path_factory) -> str:
    """Return a short bag of a moving arm, with the truth of the simulator."""
    out = tmp_path_factory.mktemp('bags') / 'pushed'
    assert main(['simulate', *ARM, '--motion', 'push', '--duration', '4', '--out', str(out)]) == 0
    return str(out)


def test_an_estimate_has_a_page_with_truths_and_errors(bag, tmp_path):
    out, page = tmp_path / 'out', tmp_path / 'page.html'
    assert main(['estimate', bag, *ARM, '--out', str(out), '--page', str(page)]) == 0
    read = Reader(page.read_text(encoding='utf-8'))
    assert read.open == []
    for said in ('Joint 1 carried up to', 'truth/joint1/torque', 'truth/tip/wrench.x',
                 'Force on the tip', '4,001'):
        assert said in read.text, said
    assert {'measured', 'after'} <= set(read.text.replace('"', ' ').split())
    assert sorted(path.name for path in tmp_path.iterdir()) == ['out', 'page.html']


def test_without_the_option_there_is_no_page(bag, tmp_path):
    assert main(['estimate', bag, *ARM, '--out', str(tmp_path / 'out')]) == 0
    assert list(tmp_path.rglob('*.html')) == []


@pytest.mark.parametrize('place', ['taken.html', 'out', 'folder'])
def test_a_page_takes_no_place_that_is_taken_and_leaves_nothing(bag, place, tmp_path, capsys):
    (tmp_path / 'taken.html').write_text('mine')
    (tmp_path / 'folder').mkdir()
    before = sorted(tmp_path.rglob('*'))
    assert main(['estimate', bag, *ARM, '--out', str(tmp_path / 'out'),
                 '--page', str(tmp_path / place)]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert sorted(tmp_path.rglob('*')) == before
    assert (tmp_path / 'taken.html').read_text() == 'mine'


def test_force_replaces_the_page_too(bag, tmp_path):
    page = tmp_path / 'page.html'
    words = ['estimate', bag, *ARM, '--out', str(tmp_path / 'out'), '--page', str(page)]
    assert main(words) == 0
    first = page.read_bytes()
    assert main([*words, '--force']) == 0
    assert page.read_bytes() == first


def test_a_calibration_writes_its_page(tmp_path, monkeypatch):
    """The calibration itself is tested elsewhere; here it is its page that counts."""
    made = []

    def run(bags, arm, out: Path, **_):
        made.append(out)
        return type('Found', (), {
            'text': lambda self: 'found', 'report': lambda self: {'joints': []}})()
    monkeypatch.setattr(calibrate_command, 'run_calibration', run)
    page = tmp_path / 'page.html'
    words = ['calibrate', 'bag', *ARM, '--out', str(tmp_path / 'new.yaml'), '--page', str(page)]
    assert main(words) == 0
    assert str(tmp_path / 'new.yaml') in page.read_text(encoding='utf-8')
    assert main(words) == 2                                 # refused before anything is computed
    assert len(made) == 1


def test_a_page_of_a_calibration_tells_numbers_bounds_and_what_stays():
    text = Reader(calibrated()).text.replace('\N{NO-BREAK SPACE}', ' ')
    for said in ('torsion.flexspline_stiffness', 'at its bound', 'its reference torque never',
                 'Partly calibrated', 'The torque of joint 1 is off by 0.3 N·m instead of 0.8'):
        assert said in text, said
