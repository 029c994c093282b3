"""Which angle it was that a link encoder with a steep wave over its lines showed."""

from hda_torque_estimator.diagnosis.readings.raw_readings import raw_readings
from hda_torque_estimator.measurements.even_grid import on_grid
import numpy as np
import pytest
from test_raw_readings import ARM, measured
from truth.forms import formed
from truth_cases import hide


@pytest.mark.parametrize(('amplitude', 'form'), [(6e-5, ''), (2e-4, 'third_harmonic'), (4e-4, '')])
def test_a_wave_so_steep_that_one_reading_is_of_several_angles_is_taken_out(amplitude, form):
    """The motor shows which angle it was; where no wave passes nobody knows."""
    wave = hide('encoder_interpolation_error', 'joint2', amplitude=amplitude, lines=9000.0,
                phase=-1.8)
    if form:
        wave = formed(wave, form, np.random.default_rng(109))
    whole, found = measured([], 109, duration=30.0), measured([wave], 109, duration=30.0)
    raw = raw_readings(found, ARM)
    cause, = raw.causes
    assert cause.numbers['amplitude'].value == pytest.approx(amplitude, rel=0.01)
    assert cause.numbers['lines'].value == pytest.approx(9000.0, abs=0.05)
    assert len(cause.forms) == (2 if form else 0)
    blind, true = raw.measurement.is_blind, on_grid(whole).reading[:, 1, 1]
    assert not blind[np.abs(np.gradient(true, 1e-3)) > 0.2].any()
    assert (raw.measurement.reading[:, 1, 1] - true)[~blind].std() < 0.1 * amplitude
