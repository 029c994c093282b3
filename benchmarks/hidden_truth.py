"""The independent truth of the tests, for benchmarks; `test/` is no package."""

import importlib
from pathlib import Path
import sys

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / 'test'))
_truth = importlib.import_module('truth')
_numbers = importlib.import_module('truth_numbers')
_world_samples = importlib.import_module('world_samples')
worlds = importlib.import_module('truth.worlds')
layout = importlib.import_module('truth.layout')
built = importlib.import_module('truth.arms').built
published = importlib.import_module('truth_samples').published
arm_of, logged = _world_samples.arm_of, _world_samples.logged
CATALOGUE, OUTSIDE, EFFECTS, draw, record = (
    _truth.CATALOGUE, _truth.OUTSIDE, _truth.EFFECTS, _truth.draw, _truth.record)
Device, Reference = _truth.Device, _truth.Reference
Hidden, TruthRecord, TruthError = _truth.Hidden, _truth.TruthRecord, _truth.TruthError
MOTIONS = importlib.import_module('truth.motions')
ASKED, ONE_EQUATION = _numbers.ASKED, _numbers.ONE_EQUATION
ADDED, SAME, SCALED = _numbers.ADDED, _numbers.SAME, _numbers.SCALED
expected, scattered = _numbers.expected, _numbers.scattered
