"""What is typed: mistakes get the word that was meant, help has examples that can be typed."""

from contextlib import suppress
import json
import os
import shlex
import subprocess
import sys

from command_line import complaint_of
from hda_msgs_json.nearest import did_you_mean
from hda_torque_estimator import cli
from hda_torque_estimator.cli import COMMANDS, main
from hda_torque_estimator.commands.progress import duration, how_far
from hda_torque_estimator.commands.terminal import fitted, show
from hda_torque_estimator.comparison.report import table
import pytest

OUT = ['--out', 'nothing']


@pytest.mark.parametrize(('words', 'meant'), [
    (['dignose'], 'diagnose'),
    (['help', 'calibrat'], 'calibrate'),
    (['diagnose', 'bag', '--amr', 'hda_arm.yaml', *OUT], '--arm'),
    (['info', 'bag', '--jsno'], '--json'),
    (['compare', 'one', 'two', '--align', 'drfit', *OUT], 'drift'),
    (['effects', 'backlsh'], 'backlash'),
    (['simulate', '--arm', 'hda_arm.yaml', '--motion', 'rihc', *OUT], 'rich'),
    (['simulate', '--arm', 'hda_arm', '--motion', 'rich', *OUT], 'hda_arm.yaml'),
    (['plan', '--arm', 'hda_arm.yaml', '--between', 'backlash', 'kinematic_eror', *OUT],
     'kinematic_error'),
    (['reproduce', 'fig77', *OUT], 'fig7'),
    (['completion', 'bsh'], 'bash'),
])
def test_a_mistyped_word_gets_the_one_that_was_meant(words, meant, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert f'did you mean {meant}' in complaint_of(capsys, *words)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize('words', [
    ['simulate', '--arm', 'hda_arm.yaml', '--motoin', 'rich', *OUT],
    ['simulate', '--arm', 'hda_arm.yaml', '--motion', 'rihc', *OUT]])
def test_a_complaint_ends_its_lines_between_words_on_a_terminal(words, capsys, monkeypatch,
                                                                tmp_path):
    """A terminal would cut them anywhere; a pipe gets one line."""
    monkeypatch.chdir(tmp_path)
    plain = complaint_of(capsys, *words)
    assert len(plain) > 80
    monkeypatch.setattr(sys.stderr, 'isatty', lambda: True)
    monkeypatch.setenv('COLUMNS', '80')
    with suppress(SystemExit):
        main(words)
    lines = [line for line in capsys.readouterr().err.splitlines() if line.strip()]
    assert len(lines) > 1 and max(map(len, lines)) <= 80
    assert ' '.join(line.strip() for line in lines) == plain.strip()


def test_a_table_is_no_wider_than_its_screen():
    """A line that goes on below its row cannot be read by columns."""
    row = ('joint_states/joint1_motor/position', 'rad', '0.0121', '0.126', '-0.000899', '20.7 %',
           '0.00153', '29.036 s', '2.68 Hz (0.001)')
    rows = [('signal', 'unit', 'rms', 'max', 'mean', 'of motion', 'noise', 'starts', 'lines'), row]
    whole = table(rows)
    assert [line.split()[0] for line in whole] == ['signal', row[0]]
    assert whole[1].endswith(row[-1])
    narrow = table(rows, 80)
    assert max(map(len, narrow)) <= 80
    assert narrow[0].split() == ['signal', 'unit', 'rms', 'max', 'of', 'motion', 'starts']
    assert narrow[1].split()[-1] == 's' and narrow[-1] == '  compare.html has 3 more columns'
    assert table(rows, 200) == whole
    assert len({len(line) for line in narrow[:2]}) == 1


def test_words_far_from_all_names_get_no_advice():
    assert did_you_mean('waltz', COMMANDS) == ''
    assert did_you_mean('DIAGNOSE', COMMANDS) == '; did you mean diagnose?'


@pytest.mark.parametrize('command', COMMANDS)
def test_every_example_is_a_call_that_can_be_read(command, capsys):
    assert main_help(['help', command]) == 0
    shown = capsys.readouterr().out
    examples = cli._module(command).EXAMPLES
    assert all(line in shown for example in examples for line in example.splitlines())
    assert max(map(len, shown.splitlines())) <= 80
    for example in examples:
        words = shlex.split(example.replace('\\\n', ' ').replace('eval "$(', '').replace(')"', ''),
                            comments=True)
        words = words[1:words.index('>')] if '>' in words else words[1:]
        cli.parser_of(words[0]).parse_args(words)


def main_help(words):
    """Return the code with which help ends."""
    with pytest.raises(SystemExit) as stop:
        main(words)
    return stop.value.code


def test_help_without_a_command_is_that_of_hda(capsys):
    assert main_help(['help']) == 0
    shown = capsys.readouterr().out
    assert all(name in shown for name in COMMANDS)


@pytest.mark.parametrize(('typed', 'offered'), [
    ('hda dia', {'diagnose'}),
    ('hda plan --betw', {'--between'}),
    ('hda effects torque_', {'torque_ripple', 'torque_constant_error', 'torque_saturation'}),
    ('hda simulate --motion slow', {'slow_sine'}),
    ('hda import log.csv --map kin', {'kinova_gen3.yaml'}),
    ('hda diagnose bag --arm paper_s', {'paper_single_axis.yaml'}),
    ('hda compare a b --align ', {'drift', 'offset', 'none'}),
])
def test_a_shell_is_offered_what_may_follow(typed, offered, tmp_path):
    done = subprocess.run(
        ['sh', '-c', f'exec "{sys.executable}" -m hda_torque_estimator.cli 8>&1 9>/dev/null'],
        capture_output=True, text=True, cwd=tmp_path, env={
            **os.environ, '_ARGCOMPLETE': '1', 'COMP_LINE': typed, 'COMP_POINT': str(len(typed)),
            '_ARGCOMPLETE_IFS': '\n',
            'PYTHONPATH': os.pathsep.join(filter(None, sys.path))})
    assert {word.strip() for word in done.stdout.split('\n')} - {''} == offered


@pytest.mark.parametrize('shell', ['bash', 'zsh', 'fish', 'tcsh'])
def test_every_shell_gets_its_lines(shell, capsys):
    assert main(['completion', shell]) == 0
    assert 'hda' in capsys.readouterr().out


def test_bash_takes_its_lines(capsys, tmp_path):
    assert main(['completion', 'bash', '--json']) == 0
    (tmp_path / 'lines').write_text(json.loads(capsys.readouterr().out)['script'])
    asked = subprocess.run(['bash', '-ec', f'. {tmp_path}/lines; complete -p hda'],
                           capture_output=True, text=True)
    assert asked.stdout.strip().endswith(' hda') and asked.stderr == ''


def test_an_unknown_shell_is_one_line(monkeypatch, capsys):
    monkeypatch.setenv('SHELL', '/bin/dash')
    assert 'name one of bash, zsh, fish, tcsh' in complaint_of(capsys, 'completion')


def test_long_lines_go_on_behind_a_margin():
    line = '  ' + 'word ' * 40
    parts = fitted(line, 30)
    assert all(len(part) <= 30 for part in parts)
    assert parts[1].startswith('      word') and ' '.join(parts).split() == line.split()
    assert fitted('short', 30) == ['short']
    assert fitted('x' * 99, 30) == ['x' * 99]       # a path that is cut could not be copied


@pytest.mark.parametrize(('environment', 'coloured'), [({}, True), ({'NO_COLOR': '1'}, False)])
def test_a_verdict_has_its_colour_on_a_terminal(environment, coloured, monkeypatch, tmp_path):
    for name, value in {'TERM': 'xterm', 'COLUMNS': '40', **environment}.items():
        monkeypatch.setenv(name, value)
    text, report = 'explained: ' + 'why ' * 20 + '\nmore', {'verdict': 'explained'}
    leader, follower = os.openpty()
    with os.fdopen(follower, 'w') as terminal:
        show(text, report, terminal)
    with os.fdopen(leader, 'rb', buffering=0) as screen:
        shown = screen.read(4096).decode()
    assert ('\x1b[' in shown and '36m' in shown) == coloured
    assert 'more' in shown and 'more' not in shown.partition('\x1b[0m')[0] * coloured
    with (tmp_path / 'piped').open('w') as pipe:
        show(text, report, pipe)
    assert (tmp_path / 'piped').read_text() == text + '\n'


def test_time_left_is_worded_as_people_say_it(monkeypatch):
    monkeypatch.setattr('time.monotonic', lambda: 100.0)
    assert how_far(10, 40, 0.0) == '10 of 40, 5 min left'
    assert how_far(0, 40, 0.0) == '0 of 40' and how_far(40, 40, 0.0) == '40 of 40'
    assert [duration(seconds) for seconds in (0.2, 59.0, 3000.0, 9000.0)] == [
        '1 s', '59 s', '50 min', '2 h 30 min']
