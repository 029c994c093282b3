"""Every constant of judgement says what it means and where it comes from, in source and docs."""

import constants_table
from hypothesis_table import numeric_fields, thresholds
import pytest

ROWS = list(constants_table.rows())
NAMED = [pytest.param(constant, id=f'{module}.{constant.names[0]}')
         for module, constant, _ in ROWS]


def test_the_table_is_that_of_the_source():
    assert constants_table.PAGE.read_text() == constants_table.page(), 'run make docs'


@pytest.mark.parametrize('constant', NAMED)
def test_a_constant_has_a_meaning_and_an_origin(constant):
    assert constant.meaning
    assert constant.origin, 'mark its comment with (choice), (null: ...), (measured: ...) ' \
                            'or (source: ...)'


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
        'MEMORY = 4  # (layout)\nLEFT, RIGHT = 0, 1\nLAST = MEMORY + 1\n'))
    assert reported == [(('FAR',), '2.0', 'm', 'distance, at which one waves', 'choice'),
                        (('FARTHER',), '3.0', 'm', 'likewise', 'null: 1 of 100 is further'),
                        (('WIDE',), '1.0', '', 'gap', '')]
