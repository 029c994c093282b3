"""The independent truth of the tests, for benchmarks; `test/` is no package."""

import importlib
from pathlib import Path
import sys

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / 'test'))
_truth = importlib.import_module('truth')
_numbers = importlib.import_module('truth_numbers')
published = importlib.import_module('truth_samples').published
CATALOGUE, OUTSIDE, EFFECTS, draw, record = (
    _truth.CATALOGUE, _truth.OUTSIDE, _truth.EFFECTS, _truth.draw, _truth.record)
Hidden, TruthRecord = _truth.Hidden, _truth.TruthRecord
ASKED, ONE_EQUATION = _numbers.ASKED, _numbers.ONE_EQUATION
expected, scattered = _numbers.expected, _numbers.scattered
