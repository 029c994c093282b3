"""The page of the real recordings is what its numbers make of its template, to the last bit."""

import json
import re

from project_files import ROOT
import pytest
from real_page import (
    document, figures, fixed, listed, NUMBERS, PAGE, page, ProseError, small)
from recordings import asked_for

KNOWN = json.loads(NUMBERS.read_text(encoding='utf-8'))


def test_the_page_is_what_its_numbers_make_of_it():
    assert page(KNOWN) == PAGE.read_text(encoding='utf-8'), (
        'docs/real_data.md is written by benchmarks/recordings.py: change its template')


def test_the_numbers_are_stored_as_they_are_written():
    assert document(KNOWN) == NUMBERS.read_text(encoding='utf-8')


def test_the_worked_robot_has_the_same_numbers():
    joint = KNOWN['yucobot']['joints'][0]
    shown = (ROOT / 'docs' / 'your_robot.md').read_text(encoding='utf-8')
    assert f'joint1: error {joint["before"]:.3g} -> {joint["after"]:.3g} N*m rms' in shown
    for name in ('torsion.flexspline_stiffness', 'torsional_hysteresis.level'):
        value, low, high = (f'{number:.4g}' for number in joint['numbers'][name])
        assert re.search(f'{name} = {value} \\S+ \\({low} .. {high}\\)', shown)


def changed(*path: object, value: object) -> dict:
    """Return the numbers with one of them changed."""
    numbers = json.loads(json.dumps(KNOWN))
    inner = numbers
    for step in path[:-1]:
        inner = inner[step]
    inner[path[-1]] = value
    return numbers


@pytest.mark.parametrize('path, value', [
    (('lara8', 'diagnosis', 'named'), ['backlash']),
    (('bench', 'together', 'named'), {}),
    (('yucobot', 'refused'), None)])
def test_a_sentence_that_is_not_true_any_more_stops_the_page(path, value):
    with pytest.raises(ProseError, match='no longer true'):
        page(changed(*path, value=value))


def test_a_number_that_changes_changes_the_page():
    assert page(changed('lara8', 'seconds', value=9.87)) != page(KNOWN)


@pytest.mark.parametrize('shown, expected', [
    (figures(0.0422), '0.042'), (figures(0.0999), '0.10'), (figures(3122.4), '3100'),
    (figures(1.0), '1.0'), (figures(0.0), '0'), (fixed(0.125, 1), '0.1'),
    (small(1.78e-4), '1.8e-4'), (listed([1, 2, 3]), '1, 2 and 3'),
    (listed([6]), '6'), (listed([]), 'none')])
def test_numbers_are_shown_with_their_digits(shown, expected):
    assert shown == expected


@pytest.mark.parametrize('words', [[], [''], ['absent']])
def test_a_folder_without_the_recordings_is_refused_before_anything_is_done(words, capsys):
    with pytest.raises(SystemExit):
        asked_for(words)
    assert 'name the folder of the recordings' in capsys.readouterr().err
