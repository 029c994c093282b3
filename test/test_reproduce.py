"""The paper's numbers come out again, printed ones as printed and consistent ones as derived."""

from functools import cache
import json
import math
from pathlib import Path

from hda_arm_sim.model.files import read_arm
from hda_torque_estimator.cli import main
from hda_torque_estimator.reproduction.catalogue import chosen, FIGURES
from hda_torque_estimator.reproduction.figures.table_two import quintic_share
from hda_torque_estimator.reproduction.page import PAPER
from hda_torque_estimator.reproduction.report import document
from hda_torque_estimator.reproduction.rig.exhibit import Arms, ReproductionError
from hda_torque_estimator.reproduction.rig.imperfections import imperfect, TOGETHER
from hda_torque_estimator.reproduction.rig.rig_calibration import calibrated
from project_files import ROOT
import pytest

pytestmark = pytest.mark.xdist_group('reproduce')       # figures are made once per process

ARMS = Arms(read_arm('paper_single_axis.yaml'), read_arm('hda_arm.yaml'),
            read_arm('paper_table1.yaml'))


@cache
def made(figure):
    """Return the exhibit of a figure, made once."""
    return FIGURES[figure].build(ARMS)


def number(figure, name):
    """Return the one number of this name."""
    found, = (each for each in made(figure).numbers if each.name == name)
    return found


@pytest.mark.parametrize(('figure', 'name', 'column', 'expected'), [
    ('table1', 'c_w from K_w0 and psi', 'printed', 1.0 / 0.037),
    ('table1', 'psi from K_w0 and T_fs', 'printed', 0.997),
    ('table1', 'K_w0 from psi = 1 arcmin', 'printed', 2.5439),
    ('table1', 'the same at the output', 'printed', 1.450e-4),
    ('table1', 'share of it reached at N T_fs', 'consistent', 100.0 * (1.0 - math.exp(-1.0))),
    ('table1', 'tangent law at the second knee', 'printed', 12.007),
    ('table1', 'pole of the tangent law', 'printed', 1.940),
    ('table1', 'torque at which the gear gets there', 'consistent', 27.54),
    ('table1', 'stiffness at small torque, with the wave generator', 'printed', 7051.0),
    ('table1', 'torsion at 12 N*m, with the wave generator', 'printed', 1108.0),
    ('equation_a1', 'r_m of the arm files', 'consistent', 5.96e-5),
    ('table2', 'the same as a disc off its axis', 'printed', 45.0),
    ('table2', 'the term 0.0018 alone, as rad per rad of the link', 'printed', 113.1),
    ('fig2', 'link 1 from gear torque 1', 'printed', 1.0 / 0.876),
    ('fig2', 'link 1 from gear torque 2', 'consistent', -0.25 / (0.876 * 0.25 - 0.25 ** 2)),
    ('fig2', 'shaft from gear torque', 'consistent', -0.01 / 1.289e-4),
    ('fig3', 'K_P at the shaft', 'consistent', 0.003),
    ('fig3', 'K_D at the shaft', 'consistent', 0.01),
    ('fig3', 'feedback of the estimated torque, K_J = 0.1', 'consistent', 0.001),
    ('fig5', 'acceleration of an idle motor by (1)', 'printed', 306.0),
    ('fig5', 'real pole by (3) and (4) as printed', 'printed', 106.8),
    ('fig5', 'resonance, motor held, one axis', 'printed', 17.0),
    ('fig6', 'estimate of 5 N*m', 'printed', 5.157),
    ('fig6', 'estimate of 8 N*m', 'printed', 9.106),
    ('fig6', 'estimate of 12 N*m', 'printed', 17.62),
    ('fig6', '(13) with tau_w = +tau/N at 5 N*m', 'printed', 7.68),
    ('fig6', '(13) with tau_w = +tau/N at 12 N*m', 'printed', 19.15),
    ('fig7', 'stick band T_fs/K_P, at the link', 'consistent', 7.066),
    ('fig7', 'largest push that the motor does not feel at all, K_J = 0.1', 'consistent', 4.111),
    ('fig7', 'largest K_J, link held', 'consistent', 1.0),
    ('fig14', 'one count of the motor encoder', 'consistent', 0.1534),
    ('fig14', 'torque of 2.66e-2 N*m at joint 2', 'consistent', 2.66),
    ('equation_14', 'direction of the example, elbow at 69 deg', 'consistent', 30.67),
    ('equation_14', 'the same by (15) with 1 + cos', 'printed', -30.67),
    ('equation_14', 'noise of the axial force, elbow at 90 deg', 'consistent', 9.43),
    ('equation_14', 'noise of the axial force, elbow at 1 deg', 'consistent', 854.0),
])
def test_numbers_are_those_derived_by_hand(figure, name, column, expected):
    assert getattr(number(figure, name), column) == pytest.approx(expected, rel=1.5e-3)


def test_a_quintic_holds_one_wave_per_turn_and_not_two_hundred():
    assert quintic_share(1.0) > 0.99
    assert quintic_share(200.0) < 1e-3


def test_printed_links_do_not_feel_each_other():
    assert number('fig2', 'link 1 from gear torque 2').printed == 0.0


def test_only_a_driving_starting_torque_moves_an_arm_without_current():
    idle = number('fig5', 'link angle of joint 1 after 4 s without current')
    assert idle.printed > 5.0
    assert idle.consistent == 0.0


@pytest.mark.parametrize('figure', FIGURES)
def test_every_figure_has_numbers_sentences_and_strict_json(figure):
    exhibit = made(figure)
    assert exhibit.numbers
    assert exhibit.findings
    names = [each.name for each in exhibit.numbers]
    assert len(names) == len(set(names))
    assert all(any(value is not None for value in each[2:5]) for each in exhibit.numbers)
    json.dumps(document({figure: exhibit}, '0', 0.0), allow_nan=False)


def test_estimate_changes_its_sign_beyond_the_pole():
    assert number('fig6', 'estimate of 20 N*m').printed < 0.0


@pytest.mark.parametrize('shape', ['step', 'sine'])
@pytest.mark.parametrize('arm', [1, 2])
def test_one_law_for_arm_and_estimator_leaves_the_counts_alone(arm, shape):
    mean = number('fig6', f'mean error, arm {arm}, {shape} of 8 N*m')
    assert mean.consistent < 0.03 < 0.2 < mean.printed


def test_feedback_follows_with_minus_one_and_rejects_between_zero_and_one():
    without = number('fig7', 'link during the push: 3 A, push of 12 N*m, without feedback')
    follows = number('fig7', 'link during the push: 3 A, push of 12 N*m, K_J = -1')
    assert without.consistent > 1.0
    assert follows.consistent < -1.0
    yielded = [number('fig7', f'position mode, link pushed off by 6 N*m, K_J = {gain}').consistent
               for gain in ('0.9', '0.1', '0', '-1')]
    assert yielded == sorted(yielded)
    assert yielded[0] < 0.1 * yielded[2]


def test_feedback_gain_may_be_larger_with_a_free_link_than_with_a_held_one():
    free, held = (number('fig7', f'largest K_J, link {link}') for link in ('free', 'held'))
    assert free.consistent > 2.0 * held.consistent


@pytest.mark.parametrize(('load', 'mean', 'largest'), [
    ('step', 1.27, 5.89), ('periodic', 1.33, 4.5)])
def test_named_causes_of_usual_size_explain_the_errors_of_the_paper(load, mean, largest):
    found = number('fig11', f'{load}: mean error, together')
    worst = number('fig11', f'{load}: largest error, together')
    assert (found.paper, worst.paper) == (mean, largest)
    assert found.printed == pytest.approx(mean, rel=0.35)
    assert worst.printed == pytest.approx(largest, rel=0.35)


@pytest.mark.parametrize('load', ['step', 'periodic'])
@pytest.mark.parametrize('figure', ['fig9', 'fig11'])
def test_calibration_leaves_two_counts_of_the_motor_encoder(figure, load):
    count = 2.0 * math.pi / 4096.0 / 100.0 * 1e4
    against_gear = number(figure, f'{load}: mean error against the gear')
    assert against_gear.consistent < 2.0 * count < 0.5 * against_gear.printed


def test_kinematic_error_costs_more_than_backlash_where_the_rig_turns():
    by = {name: number('fig11', f'step: mean error by {name}').printed
          for name in ('kinematic error', 'backlash', 'counts of the encoders alone')}
    assert by['kinematic error'] > 3.0 * by['backlash'] > 6.0 * by['counts of the encoders alone']


def test_calibration_finds_what_was_put_into_the_rig():
    found = calibrated(imperfect(ARMS.rig, TOGETHER), ARMS.rig)
    assert found.effect('clock_skew', 'joint1').skew == pytest.approx(1e-4, rel=0.1)
    assert found.effect('kinematic_error', 'joint1').amplitude_2 == pytest.approx(1.1e-4, rel=0.15)
    scale = found.effect('link_encoder_eccentricity', 'joint1')
    assert scale.amplitude_1 == pytest.approx(8e-5, rel=0.1)


def test_a_fourier_series_of_both_angles_holds_what_a_quintic_cannot():
    quintic = number('fig10', 'quintic (10), left held out').printed
    series = number('fig10', 'Fourier, link and shaft orders, left held out').consistent
    assert series < 0.15 < 0.8 < quintic


def test_kinematic_torsion_is_unique_to_the_angles():
    for what in ('both directions', 'two torques'):
        assert number('fig10', f'difference of {what}, same angle').consistent < 0.1


def test_pushes_below_friction_move_the_arm_with_feedback_only():
    travel = [number('fig12', f'first experiment, travel of the link, K_J = {gain}').consistent
              for gain in ('0', '-1')]
    assert travel[0] < 0.1 < 90.0 < travel[1]


def test_every_slip_of_a_pushed_motor_has_a_peak_of_its_own_sign():
    for motor in (1, 2):
        assert number('fig14', f'slips of motor {motor}').consistent >= 5
        assert number('fig14', f'slips of motor {motor} with a peak of the sign of the motion'
                      ).consistent == 100.0
        gives_way = number('fig14', f'torque at which motor {motor} gives way, median')
        assert 3.7 < gives_way.consistent < 5.0


def test_corrected_tip_force_is_exact_where_the_printed_one_is_not():
    error = number('equation_14', 'median error of the size over the workspace')
    assert error.consistent < 1e-9 < 10.0 < error.printed


def test_names_are_taken_in_the_order_of_the_paper():
    assert list(chosen([])) == list(FIGURES)
    assert list(chosen(['fig5', 'table1'])) == ['table1', 'fig5']
    with pytest.raises(ReproductionError, match='valid names: table1'):
        chosen(['fig99'])


def test_the_command_writes_a_page_numbers_and_figures(tmp_path, capsys):
    out = tmp_path / 'paper'
    assert main(['reproduce', 'table1', 'equation_a1', '--out', str(out), '--json']) == 0
    report = json.loads(capsys.readouterr().out)
    assert json.loads((out / 'paper.json').read_text()) == report
    assert set(report['figures']) == {'table1', 'equation_a1'}
    for figure in report['figures'].values():
        for name in figure['drawings']:
            assert (out / f'{name}.png').read_bytes().startswith(b'\x89PNG')
            assert '<svg' in (out / f'{name}.svg').read_text()
    page = (out / 'paper.html').read_text()
    assert page.count('<svg xmlns') == sum(len(f['drawings']) for f in report['figures'].values())
    assert 'src="http' not in page
    assert PAPER in page
    assert [path.name for path in tmp_path.iterdir()] == ['paper']


@pytest.mark.parametrize('name', ['README.md', 'docs/errata.md', 'docs/reproduction.md'])
def test_texts_name_the_paper(name):
    assert PAPER in (ROOT / name).read_text(encoding='utf-8')


@pytest.mark.parametrize(('words', 'says'), [
    (['fig99', '--out', 'new'], "no figure 'fig99'"),
    (['table1', '--out', 'there'], 'there exists'),
    (['table1', '--out', 'file/new'], 'cannot be written'),
])
def test_bad_use_is_one_line_and_leaves_nothing(words, says, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path('there').mkdir()
    Path('there', 'kept').touch()
    Path('file').write_text('')
    assert main(['reproduce', *words]) == 2
    said = capsys.readouterr()
    assert said.out == ''
    assert len(said.err.splitlines()) == 1
    assert says in said.err
    assert sorted(path.name for path in tmp_path.iterdir()) == ['file', 'there']
