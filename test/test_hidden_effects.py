"""
Every effect of the catalogue hidden in data: name, joint, numbers and gain are required.

One draw of each; `benchmarks/diagnosis.py` says how often it goes otherwise. The hidden truth is
`truth/`: other formulas, another integrator and step, its own scatter.
"""

from zlib import crc32

from hda_arm_sim.model.files import read_arm
from hda_torque_estimator.diagnosis.diagnose import diagnose
from hda_torque_estimator.measurements.sample_grid import measurement_from
import numpy as np
import pytest
from truth import CATALOGUE, draw
from truth_numbers import ASKED, expected, ONE_EQUATION, scattered
from truth_samples import published

ARM = read_arm('hda_arm.yaml')
NAMES = [effect.name for effect in CATALOGUE]
TOLERANCE = {
    **{name: asked for asked, names in ASKED.values() for name in names},
    'presliding_friction': 0.25}            # the bristles of the truth are another law
SIZES_OF_OTHER_KIND = {'coarse_quantisation'}
ALONE = 30.0            # of a record of one effect: harder to identify by than a minute [s]


def seed_of(name):
    """Return the seed of an effect's record, whatever else the catalogue has."""
    return crc32(name.encode())


def diagnosed(name):
    """Return what is hidden in a record of one effect, and its diagnosis."""
    seed = seed_of(name)
    hidden = draw(name, np.random.default_rng([seed, 1]))
    measurement = measurement_from(ARM.labels, published(ARM, [hidden], seed, seconds=ALONE))
    return hidden, diagnose(measurement, ARM).diagnosis


@pytest.mark.parametrize('name', [name for name in NAMES if name not in ONE_EQUATION])
def test_hidden_effect_is_named_and_sized(name):
    hidden, found = diagnosed(name)
    assert [(one.effect, one.joint) for one in found.findings] == [(name, hidden.joint)]
    assert found.verdict == 'explained'
    assert found.gain.removed > 0.9
    fitted = found.findings[0].parameters
    if 'order' in hidden.parameters:                        # chosen and reported, not fitted
        assert fitted['order'].value == hidden.parameters['order']
        assert fitted['order'].chosen
    wanted = expected(name, hidden.joint, hidden.parameters, scattered(seed_of(name)))
    compared = {number: (fitted[number], *wanted[number]) for number in wanted if number in fitted}
    assert (name in SIZES_OF_OTHER_KIND) == (compared == {})
    for number, (one, whole, size) in compared.items():
        close = abs(one.value - whole) <= TOLERANCE[name] * abs(size)
        assert close or one.low <= whole <= one.high, number


def more(*values):
    """Return a record that `make study` runs: of a statement near that of another one, or long."""
    return pytest.param(*values, marks=pytest.mark.study)


@pytest.mark.parametrize(('names', 'seed'), [
    # What is small beside the first, and what does not act where the other does.
    more(('inertial_coupling', 'stiffness_error'), 121605),     # a thousandth of the first
    more(('presliding_friction', 'inertial_coupling', 'stiffness_error'), 4818),    # at turns
    more(('clock_skew', 'torsional_hysteresis', 'bearing_crosstalk'), 4836),    # less than forms
    more(('backlash', 'structural_damping'), 121604),       # which does not act within the play
    # What is so quick that it passes for noise.
    more(('motor_cogging',), 121102),
    more(('torque_ripple', 'load_dependent_friction'), 151673),
    # Of which noise speaks for another cause.
    (('current_loop_lag',), 4529),                          # a delay
    more(('inertial_coupling', 'motor_encoder_eccentricity',    # less inertia
          'torque_constant_error'), 4812),
    # Near to another law of its own, or to its twin.
    (('wave_generator_compliance',), 5925),                 # near to a rigid one
    more(('stiffening_error',), 4462),                      # of which two steps like a wrong law
    more(('link_encoder_eccentricity', 'stiffening_error'), 151588),    # nearly lost to its twin
    # Whose form shows when the other is known.
    more(('clock_skew', 'wave_generator_compliance'), 5951),
    more(('base_vibration', 'stiffening_error', 'structural_damping'), 5989),
    # Whose order or waves show when the drag is known.
    more(('position_dependent_friction', 'viscous_friction'), 211582),
    more(('position_dependent_friction', 'stribeck_friction'), 201029),     # as good as each other
    more(('stribeck_friction', 'position_dependent_friction'), 211618),     # waves of the level
    # For which a third cause or a curve stands in at first.
    more(('bearing_crosstalk', 'encoder_scale_error'), 4602),   # a disc stands for both
    more(('bearing_crosstalk', 'link_bearing_friction'), 4446),     # a third only helps to it
    more(('bearing_crosstalk', 'wave_generator_compliance'), 4443),     # whose form is not its own
    more(('wave_generator_compliance', 'current_loop_lag'), 211669),    # a curve helps next door
    # Which nearly cancel, or together scale a balance.
    more(('link_inertia_error', 'payload', 'base_tilt'), 4802),
    more(('torsional_hysteresis', 'motor_inertia_error', 'torque_constant_error'), 191709),
    # Held out.
    more(('external_contact', 'bearing_crosstalk', 'load_dependent_friction'), 4810)])
def test_causes_that_hide_behind_others_or_noise_are_named(names, seed):
    random = np.random.default_rng([seed, 1])
    hidden = [draw(name, random) for name in names]
    found = diagnose(measurement_from(ARM.labels, published(ARM, hidden, seed)), ARM).diagnosis
    assert {(one.effect, one.joint) for one in found.findings} == {
        (one.effect, one.joint) for one in hidden}
    assert found.verdict == 'explained'


@pytest.mark.parametrize('name', ONE_EQUATION)
def test_two_that_no_motion_can_distinguish_are_ambiguous(name):
    """A constant bias and a friction that differs with direction are one torque while moving."""
    hidden, found = diagnosed(name)
    assert found.verdict == 'ambiguous'
    assert {place for alike in found.ambiguous for place in alike.effects} == {
        (effect, hidden.joint) for effect in ONE_EQUATION}
    assert 'dwell' in found.ambiguous[0].experiment
