"""The proof that a change moved no number can fail: it sees what differs, and only that."""

import importlib.util
import json

from project_files import ROOT
import pytest

SPEC = importlib.util.spec_from_file_location('golden', ROOT / 'benchmarks' / 'golden.py')
golden = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(golden)

FOUND = {'stiffness': 9743.939, 'names': ['backlash'], 'seconds': 12.0, 'none': None}


def folder(path, **found):
    """Write a part into a folder and return that."""
    path.mkdir()
    (path / 'calibrate.json').write_text(json.dumps({**FOUND, **found}))
    return path


@pytest.mark.parametrize('changed', [{}, {'seconds': 99.0}, {'stiffness': 9743.939 * (1 + 1e-12)}])
def test_rounding_and_times_are_no_difference(tmp_path, changed):
    assert golden.compare(folder(tmp_path / 'a'), folder(tmp_path / 'b', **changed)) == []


@pytest.mark.parametrize('changed', [
    {'stiffness': 9743.94}, {'names': ['play']}, {'names': []}, {'none': 0.0}, {'new': 1}])
def test_another_number_name_or_count_is_a_difference(tmp_path, changed):
    found = golden.compare(folder(tmp_path / 'a'), folder(tmp_path / 'b', **changed))
    assert len(found) == 1 and next(iter(changed)) in found[0]


def test_a_part_that_is_missing_is_a_difference(tmp_path):
    (tmp_path / 'b').mkdir()
    assert len(golden.compare(folder(tmp_path / 'a'), tmp_path / 'b')) == 1


def test_two_empty_folders_prove_nothing(tmp_path):
    with pytest.raises(SystemExit, match='no numbers'):
        golden.compare(tmp_path, tmp_path)
