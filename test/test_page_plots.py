"""The plots of a diagnosis: what they hold, and that a page runs nothing but their two scripts."""

from base64 import b64encode
from dataclasses import replace
from hashlib import sha256
import json
import re

from hda_torque_estimator.diagnosis.findings.report import Diagnosis
from hda_torque_estimator.diagnosis.reporting.curves import charts, through_time
from hda_torque_estimator.diagnosis.reporting.dependence import against
from hda_torque_estimator.diagnosis.reporting.exhibits import Exhibits
from hda_torque_estimator.diagnosis.reporting.following import Following
from hda_torque_estimator.diagnosis.reporting.page import page
import numpy as np
from test_page import coordinates, diagnosis, exhibits_of, FREE_TEXT, loaded, RATIO, Reader


def shown_exhibits() -> Exhibits:
    """Return exhibits of a joint with a name that a page must not obey, and its torques."""
    moved = coordinates(0)
    made = exhibits_of(np.cos(2.0 * moved['motor_angle']), moved)
    return replace(made, labels=(FREE_TEXT,), commanded=RATIO * moved['motor_torque'][:, None])


def shown_diagnosis(verdict: str = 'explained') -> Diagnosis:
    """Return a diagnosis of the joint of `shown_exhibits`."""
    plain = diagnosis(verdict)
    return replace(plain, findings=tuple(
        replace(found, joint=found.joint and FREE_TEXT) for found in plain.findings),
        unexplained=replace(plain.unexplained, joint=FREE_TEXT), ambiguous=tuple(
            replace(alike, candidates=tuple(replace(one, joint=FREE_TEXT)
                                            for one in alike.candidates))
            for alike in plain.ambiguous))


def test_page_with_plots_holds_its_scripts_and_no_other_may_run():
    text = page(shown_diagnosis(), {}, shown_exhibits())
    read = Reader(text)
    assert read.open == []
    assert {'link', 'iframe', 'img', 'object'}.isdisjoint(read.names)
    assert loaded(read) == []
    scripts = re.findall(r'<script>(.*?)</script>', text, re.DOTALL)
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', text)[1]
    assert len(scripts) == 2
    assert policy.startswith("default-src 'none'; script-src 'sha256-")
    for script in scripts:
        digest = b64encode(sha256(script.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in policy
    assert len(text) < 3e6
    assert 'Copyright (c) ' in text and 'Leon Sorokin' in text      # its licence stays with it


def test_data_of_plots_ends_no_element():
    judged = replace(shown_diagnosis(), findings=(), ambiguous=(), unexplained=None)
    text = page(judged, {}, replace(shown_exhibits(), labels=('</script><b>',)))
    data = re.search(r'<script type="application/json" id="plots">(.*?)</script>', text)[1]
    assert any('</script><b>' in name for chart in json.loads(data).values() for name in chart)


def test_every_cause_is_shown_over_time_and_over_what_gives_it_away():
    plots = charts(shown_diagnosis('ambiguous'), shown_exhibits())
    assert {'overview', 'prediction', 'through_time', 'giveaway_1', 'giveaway_2',
            'through_time_1', 'through_time_2', f'giveaway_alike_clock_skew_{FREE_TEXT}',
            'rest_curve', 'rest_spectrum'} <= plots.keys()
    for name in ('through_time_1', 'through_time_2'):
        for plot in plots[name].plots.values():
            assert [line.look for line in plot.lines] == ['measured', 'before', 'after']


def test_without_a_cause_no_arm_is_called_extended():
    """What a healthy arm is compared with is itself, with numbers within their tolerances."""
    healthy = replace(shown_diagnosis('no_discrepancy'), findings=(), ambiguous=(),
                      unexplained=None)
    text = page(healthy, {}, shown_exhibits())
    main = text[text.index('<main'):text.index('</main>')]
    assert 'extended arm' not in main.replace('the arm as given with the causes', '')
    names = {line.name for plot in charts(healthy, shown_exhibits())['overview'].plots.values()
             for line in plot.lines}
    assert {'arm as given', 'within its tolerances'} <= names
    assert 'extended arm' in page(shown_diagnosis(), {}, shown_exhibits())


def test_simulated_torque_departs_from_the_measured_by_the_residual():
    """At the motor and the links the model needs more; in the torsion its gear gives less."""
    shown = shown_exhibits()
    for columns, site, sign, base in (((0,), 'motor', 1.0, 0.0), ((1,), 'link', 1.0, 0.0),
                                      ((1,), 'torsion', -1.0, 1.0)):
        plot, = through_time(shown, columns, ('before', 'after'), site).plots.values()
        measured, before, after = (line.values for line in plot.lines)
        rows = shown.valid[:, columns[0]]
        gear = shown.coordinates['joint_torque'][:, 0] if columns[0] else shown.commanded[:, 0]
        np.testing.assert_allclose(measured, gear + base * shown.after[:, columns[0]])
        np.testing.assert_allclose((before - measured)[rows],
                                   sign * shown.before[rows, columns[0]], atol=1e-9)
        np.testing.assert_allclose((after - measured)[rows],
                                   sign * shown.after[rows, columns[0]], atol=1e-9)


def test_seven_joints_of_a_minute_are_a_page_of_two_million_letters():
    """Every balance of a minute as it is, before and after, and every torque: 7 joints."""
    random, count, joints = np.random.default_rng(0), 7500, 7
    plain = shown_exhibits()
    wide = Exhibits(
        np.arange(count) / 125.0, tuple(f'joint{k + 1}' for k in range(joints)),
        *(random.normal(size=(count, 2 * joints)) for _ in range(2)),
        np.ones((count, 2 * joints), bool), np.ones(2 * joints),
        {name: random.normal(size=(count, joints)) for name in plain.coordinates},
        plain.horizons, plain.predicted_before, plain.predicted_after, plain.predicted_floor,
        commanded=random.normal(size=(count, joints)))
    report = replace(diagnosis('explained'), ambiguous=(), unexplained=None)
    text = page(report, {}, wide)
    assert len(text) < 2e6
    plots = json.loads(re.search(r'id="plots">(.*?)</script>', text)[1])
    assert {plot['count'] for plot in plots['overview'].values()} == {count}


def test_the_waves_of_a_fine_cogging_are_laid_over_each_other_where_they_pass_the_filter():
    """A wave of 14 per turn fills 8 bins of a turn; fast turns are filtered out of the balance."""
    moved = coordinates(0)
    speed, filtered = moved['motor_velocity'], 14.0 * np.abs(moved['motor_velocity']) < 250.0
    wave = np.cos(14.0 * moved['motor_angle'] + 1.0) * filtered
    shown = exhibits_of(wave, moved)
    plot = against(Following('motor_angle', '', 0.5, 14.0), 1, (('rest', shown.missed(), 'a'),))
    assert plot.scale == 'linear'
    assert plot.x_label == 'motor angle in its wave, 14 per turn [rad]'
    assert 0.0 < plot.x[0] < plot.x[-1] < 2.0 * np.pi / 14.0
    size = 1.0 / wave.std()
    slow = 14.0 * np.abs(speed) < 0.5 * 40.0 * 2.0 * np.pi
    assert slow.sum() > 240
    np.testing.assert_allclose(plot.lines[0].values, size * np.cos(14.0 * plot.x + 1.0),
                               atol=0.25 * size)
    coarse = against(Following('motor_angle', '', 0.5, 2.0), 1, (('rest', shown.missed(), 'a'),))
    assert (coarse.scale, coarse.x[-1] > 6.0) == ('turn', True)
