"""Tests that share what is expensive run in one worker; all others go where there is time."""

from functools import cache

import pytest


@pytest.fixture(scope='module')
def dear():
    """Return what is made once for this module."""
    return object()


def group_of(request):
    """Return the group of the test that runs, None without one."""
    marker = request.node.get_closest_marker('xdist_group')
    return marker and marker.args[0]


def test_what_uses_a_fixture_of_its_module_has_a_group(request, dear):
    assert group_of(request) == 'test_groups'


@cache
def remembered():
    """Return what is made once in every worker that asks."""
    return object()


def test_a_module_that_remembers_is_one_group(request):
    assert group_of(request) == 'test_groups'


@pytest.mark.xdist_group('other')
def test_a_group_that_a_test_has_stays(request):
    assert group_of(request) == 'other'
