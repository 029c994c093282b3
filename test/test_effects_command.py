"""`hda effects` shows the catalogue as it is declared, on 80 columns."""

from io import StringIO
import json

from hda_arm_sim.model.effects import effect_named, EFFECTS
from hda_arm_sim.model.typical_sizes import SIZED
from hda_torque_estimator.cli import main
from hda_torque_estimator.commands.effects_command import WIDTH
from hda_torque_estimator.commands.terminal import show
import pytest


def shown(capsys, *words):
    """Return what `hda effects` prints."""
    assert main(['effects', *words]) == 0
    return capsys.readouterr().out


def test_every_effect_has_one_line_with_its_parameters_sizes_and_units(capsys):
    lines = shown(capsys).partition('\n\n')[0].splitlines()[1:]
    assert [line.split()[0] for line in lines] == [effect.name for effect in EFFECTS]
    for effect, line in zip(EFFECTS, lines):
        parts = line.removeprefix(effect.name).strip().split(', ')
        told = [part.split() for part in parts]
        rules = {rule.name: rule for rule in effect.declarations()}
        if not rules:
            assert parts == ['none: an arm has it', 'or not']
            continue
        for name, size, *unit in told:
            assert unit == [rules[name].unit] if rules[name].unit else not unit
            assert size == '-' or float(size) == (effect.typical.more | effect.typical.shape)[name]
        assert {name for name, *_ in told} == {*rules}


def test_an_effect_that_is_named_has_its_cause_and_all_its_parameters(capsys):
    text = shown(capsys, *(effect.name for effect in EFFECTS))
    blocks = {block.partition(':')[0]: block for block in text.split('\n\n')}
    for effect in EFFECTS:
        block = blocks[effect.name]
        assert ' '.join(effect.cause.split()) in ' '.join(block.split())
        rows = [line.split() for line in block.splitlines()]
        for rule in effect.declarations():
            row = next(words for words in rows if words[:1] == [rule.name])
            assert f'{rule.low:g} .. {rule.high:g}' in ' '.join(row)
            assert not rule.unit or row[1] == rule.unit


@pytest.mark.parametrize('names', [(), tuple(effect.name for effect in EFFECTS)])
def test_lines_fit_a_plain_terminal(names, capsys, monkeypatch):
    """A pipe has a whole line for each effect, a terminal wraps it behind a margin."""
    text = shown(capsys, *names)
    assert text.isascii()
    assert '\x1b' not in text
    if names:
        assert [line for line in text.splitlines() if len(line) > WIDTH] == []
    monkeypatch.setenv('COLUMNS', str(WIDTH))
    terminal = StringIO()
    monkeypatch.setattr(terminal, 'isatty', lambda: True)
    show(text, {}, terminal)
    lines = terminal.getvalue().splitlines()
    assert [line for line in lines if len(line) > WIDTH] == []
    assert ' '.join(terminal.getvalue().split()) == ' '.join(text.split())
    if not names:
        begun = [line.split()[0] for line in lines if line[:1].strip()]
        assert [name for name in begun if name in {one.name for one in EFFECTS}] == [
            one.name for one in EFFECTS]


def test_a_name_alone_is_explained_parameter_by_parameter(capsys):
    text = shown(capsys, 'backlash', 'backlash')
    assert text.count('backlash:') == 1
    assert effect_named('backlash').declaration('half_width').meaning in text
    assert 'payload' not in text


def test_json_holds_the_declarations(capsys):
    assert main(['effects', '--json']) == 0
    listed = json.loads(capsys.readouterr().out)['effects']
    assert [one['name'] for one in listed] == [effect.name for effect in EFFECTS]
    sized = {one['name'] for one in listed
             if any(rule['typical'] is not None for rule in one['parameters'])}
    assert sized == {name for name in SIZED if effect_named(name).declarations()}
    play = next(one for one in listed if one['name'] == 'backlash')['parameters'][0]
    assert (play['name'], play['unit'], play['low'], play['high'], play['default']) == (
        'half_width', 'rad', 0.0, 0.01, 0.0)
    assert play['typical'] > 0.0
    assert play['on_top']


def test_an_unknown_name_is_one_line_with_the_valid_ones(capsys):
    assert main(['effects', 'backlash', 'magic\n']) == 2
    said = capsys.readouterr()
    assert said.out == ''
    assert len(said.err.splitlines()) == 1
    assert "'magic" in said.err
    assert 'bearing_crosstalk' in said.err
