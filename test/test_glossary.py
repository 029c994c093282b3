"""docs/glossary.md: sorted, each term once and short; every effect has a section."""

import re

from hda_arm_sim.model.effects import EFFECTS
from project_files import ROOT
import prose
import pytest

TEXT = (ROOT / 'docs' / 'glossary.md').read_text()
TERMS = re.findall(r'^- \*\*(.+?)\*\*: ', TEXT, re.MULTILINE)
MODEL = (ROOT / 'docs' / 'model.md').read_text()


def test_terms_are_in_alphabetical_order_and_unique():
    assert sorted(set(TERMS), key=str.lower) == TERMS


def test_every_entry_is_a_term_with_its_meaning():
    assert len(re.findall(r'^- ', TEXT, re.MULTILINE)) == len(TERMS)


@pytest.mark.parametrize('name', [effect.name for effect in EFFECTS])
def test_every_effect_has_a_section(name):
    assert f'\n### `{name}`\n' in MODEL


def test_every_part_of_the_judgement_is_a_term():
    stems = {path.stem.replace('_', ' ') for path in
             (ROOT / 'hda_torque_estimator' / 'diagnosis' / 'judging').glob('[a-z]*.py')}
    words = [term.replace('-', ' ') for term in TERMS]          # no file has a hyphen
    assert stems - {*words, *(f'{term}s' for term in words)} == set()


@pytest.mark.parametrize('name', ['README.md', 'docs/model.md'])
def test_the_glossary_is_linked(name):
    assert re.search(r'\]\((?:docs/)?glossary\.md\)', (ROOT / name).read_text())


def test_sentences_are_short():
    assert [sentence for sentence in prose.of_page(TEXT)
            if prose.words(sentence) > prose.LONGEST] == []
