"""Every constant says what it means and where it comes from, those of a diagnosis what kind."""

import constants_table
from hypothesis_table import numeric_fields, thresholds
import pytest

ROWS = list(constants_table.rows())
NAMED = [pytest.param(constant, id=f'{module}.{constant.names[0]}')
         for module, constant, _ in ROWS]


OF_A_DIAGNOSIS = [pytest.param(module, constant, id=f'{module}.{constant.names[0]}')
                  for module, constant, _ in ROWS if constants_table.tells_kinds(module)]

# Of a diagnosis. Whoever adds one says here that it is one more.
JUDGEMENTS = 12


def test_the_table_is_that_of_the_source():
    assert constants_table.PAGE.read_text() == constants_table.page(), 'run make docs'


@pytest.mark.parametrize('constant', NAMED)
def test_a_constant_has_a_meaning_and_an_origin(constant):
    assert constant.meaning
    assert constant.origin, 'mark its comment with (choice), (null: ...), (measured: ...) ' \
                            'or (source: ...)'


@pytest.mark.parametrize('module, constant', OF_A_DIAGNOSIS)
def test_a_constant_of_a_diagnosis_is_a_judgement_or_numerics(module, constant):
    assert constant.kind, f'state its kind at the head of its group in {module}'


def test_no_judgement_is_added_unseen():
    judged = [constant for _, constant, _ in ROWS if constant.kind == 'judgement']
    assert len(judged) == JUDGEMENTS, 'does it follow from one that is there (significance.py)?'


def test_every_threshold_of_a_hypothesis_has_a_meaning_and_an_origin():
    assert numeric_fields() <= {name for name, meaning, _ in thresholds() if meaning}


def test_every_constant_is_reached_by_a_test():
    assert [module for module, _, tests in ROWS if not tests] == []


def test_folders_and_modules_that_judge_are_found():
    names = {part for name in constants_table.judging() for part in name.split('.')}
    assert names >= constants_table.FOLDERS | constants_table.MODULES


def test_a_comment_is_read():
    reported = list(constants_table.constants(
        '\n# Choices unless stated otherwise.\nFAR = 2.0  # distance, at which one waves [m]\n'
        '# (null: 1 of 100 is further)\nFARTHER = 3.0  # likewise [m]\n\nWIDE = 1.0  # gap\n'
        'MEMORY = 4  # (layout)\nLEFT, RIGHT = 0, 1\nLAST = MEMORY + 1\n'
        '\n# Judgement; choices unless stated otherwise.\nSURE = 9.0  # odds\n'
        '\n# Numerics.\n# (source: a book)\nTAPS = 5  # of a filter\n'))
    assert reported == [(('FAR',), '2.0', 'm', 'distance, at which one waves', 'choice', ''),
                        (('FARTHER',), '3.0', 'm', 'likewise', 'null: 1 of 100 is further', ''),
                        (('WIDE',), '1.0', '', 'gap', '', ''),
                        (('SURE',), '9.0', '', 'odds', 'choice', 'judgement'),
                        (('TAPS',), '5', '', 'of a filter', 'source: a book', 'numerics')]
