"""Numbers, names and terms of pages as people read them."""

import re

from hda_torque_estimator.pages.glossary import terms_in
from hda_torque_estimator.pages.render import asset, breakable
from hda_torque_estimator.pages.wording import percent, ranged
import pytest
from test_page_layout import calibrated, PAGES

# Heads of tables that say no more than their words do.
PLAIN = {
    'parameter', 'value', 'unit', 'where', 'number', 'signal', 'starts', 'lines', 'mean',
    'largest', 'noise', 'rms of motion', 'bag', 'topic', 'lost', 'device', 'latest', 'recording',
    'recordings', 'seconds', 'known signal', 'without its mean', 'quantity', 'paper', 'printed',
    'consistent', 'remark', 'samples', 'rate [Hz]', 'longest gap [ms]'}


@pytest.mark.parametrize(('low', 'high', 'scale', 'said'), [
    (9e-5, 1.1e-4, 'rad', '0.09 and 0.11 mrad (0.31 and 0.38 arcmin)'),
    (0.5, 0.6, 'rad', '29° and 34°'), (2.99e-3, 3.03e-3, 'N*m', '2.99 and 3.03 mN·m'),
    (0.11, 0.13, '1', '11 % and 13 %'), (1.0, 2.0, 'kg', '1 and 2 kg'),
    (9.99e-5, 1.0e-4, 'rad', '0.0999 and 0.1 mrad (0.34 arcmin)'),
    (-2e-6, 3e-4, 's', '-0.002 and 0.3 ms')])
def test_both_ends_of_an_interval_have_one_unit(low, high, scale, said):
    assert ranged(low, high, scale) == said


def test_nothing_is_minus_zero():
    assert percent(-1e-5) == '0.0 %'
    assert percent(-0.01) == '-1.0 %'


def test_the_glossary_knows_the_heads_of_all_tables():
    heads = {re.sub(r'<[^>]+>', '', head) for made in PAGES.values()
             for head in re.findall(r'<th scope="col">(.*?)</th>', made())}
    unknown = {head for head in heads - PLAIN if not terms_in(head, asset('glossary.md'))}
    assert unknown == set()
    assert heads >= PLAIN


def test_a_line_may_end_between_the_parts_of_a_name_only():
    text = calibrated()
    assert 'torsion.<wbr>flexspline_<wbr>stiffness' in text
    assert breakable('a<b_c/') == 'a&lt;b_<wbr>c/'
    assert breakable('a_b/c.d') == 'a_b/<wbr>c.d'
    assert 'K_f0, flexspline at zero torque, output side' in text
    named = [term.name for term in terms_in('Two verdicts on a flexspline.', asset('glossary.md'))]
    assert named == ['flexspline', 'verdict']
    for term in terms_in(asset('glossary.md'), asset('glossary.md')):
        assert not set('$`\\') & set(term.meaning)
