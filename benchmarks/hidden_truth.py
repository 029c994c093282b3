"""The independent truth of the tests, for benchmarks; `test/` is no package."""

import importlib
from pathlib import Path
import sys

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / 'test'))
_truth = importlib.import_module('truth')
_layout = importlib.import_module('truth.layout')
CATALOGUE, OUTSIDE, EFFECTS, draw, record = (
    _truth.CATALOGUE, _truth.OUTSIDE, _truth.EFFECTS, _truth.draw, _truth.record)
Hidden, TruthRecord = _truth.Hidden, _truth.TruthRecord


def scattered(seed: int) -> dict[str, list[float]]:
    """Return the numbers of the two joints of an arm over the nominal ones, by their names."""
    joints, arm = _layout.nominal_joints(), _layout.nominal_arm()
    given, body = joints.copy(), arm.copy()
    _layout.scatter(joints, arm, np.random.default_rng([seed, 0]))
    shares = {name: (joints[name] / given[name]).tolist()
              for name in ('dry', 'viscous', 'damping', 'stiffness', 'gain')}
    return {**shares, 'inertia': [float(arm[name][0] / body[name][0]) for name in ('p1', 'p2')]}
