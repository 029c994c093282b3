"""Compiled code is never stale: a module's cache folder follows all that it may call."""

import importlib
import pkgutil
import sys

import hda_arm_sim
from hda_arm_sim.foundation import compiled
import hda_torque_estimator
import numba
import pytest

ROOTS = (hda_arm_sim, hda_torque_estimator)


def compiled_functions():
    """Return every compiled function of the packages, by module and name."""
    for root in ROOTS:
        for found in pkgutil.walk_packages(root.__path__, f'{root.__name__}.'):
            if not found.name.endswith('__main__'):
                importlib.import_module(found.name)
    return {(name, key): law for name, module in list(sys.modules.items())
            if name.startswith(('hda_arm_sim', 'hda_torque_estimator'))
            for key, law in vars(module).items()
            if isinstance(law, numba.core.registry.CPUDispatcher)}


@pytest.fixture
def edited(tmp_path, monkeypatch):
    """Return a copy of two modules, of which one imports the other, that may be edited."""
    package = tmp_path / 'hda_arm_sim'
    package.mkdir()
    (package / '__init__.py').write_text('')
    (package / 'law.py').write_text('def law(x):\n    return x\n')
    (package / 'user.py').write_text('from .law import law\n\nANSWER = law(1)\n')
    (package / 'stranger.py').write_text('ANSWER = 2\n')
    monkeypatch.setattr(compiled, '_PACKAGES', tmp_path)
    forget_sources()
    yield package
    forget_sources()


def forget_sources():
    """Have sources looked at anew."""
    for remembers in (compiled.source_digest, compiled._imports, compiled._path):
        remembers.cache_clear()


def test_edit_of_a_law_moves_those_who_can_call_it_and_nobody_else(edited):
    names = [f'hda_arm_sim.{name}' for name in ('law', 'user', 'stranger')]
    before = [compiled.source_digest(name) for name in names]
    (edited / 'law.py').write_text('def law(x):\n    return 2 * x\n')
    forget_sources()
    after = [compiled.source_digest(name) for name in names]
    assert [one != other for one, other in zip(before, after)] == [True, True, False]


def test_module_of_somebody_else_follows_every_source(edited):
    before = compiled.source_digest('strange')
    (edited / 'stranger.py').write_text('ANSWER = 3\n')
    forget_sources()
    assert compiled.source_digest('strange') != before


def test_every_name_a_compiled_function_uses_comes_from_a_digested_module():
    """What numba freezes into the code: globals of the function, and functions it calls."""
    for (module, _), law in compiled_functions().items():
        covered = compiled.digested(module)
        for name in law.py_func.__code__.co_names:
            used = getattr(law.py_func.__globals__.get(name), '__module__', None)
            if used and used.startswith(('hda_arm_sim', 'hda_torque_estimator')):
                assert used in covered, (module, name)
