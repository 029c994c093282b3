"""Keep a run of the tests to itself: its own ROS domain, this machine only, no windows."""

from collections.abc import Iterator
from functools import cache
import gc
import os
import signal
import socket

from hda_torque_estimator.cli import THREADS
from hypothesis import settings
import pytest

DOMAINS = range(1, 102)  # beyond 101 the ports of DDS run into those of everybody else
LEFT_BY_THE_USER = ('FASTDDS_', 'FASTRTPS_', 'RMW_', 'ROS_LOCALHOST_ONLY', 'ROS_SECURITY_',
                    'ROS_STATIC_PEERS')

REMEMBERS = type(cache(len))

claimed = pytest.StashKey[socket.socket]()

settings.register_profile('tests', deadline=None)
settings.register_profile('fuzz', deadline=None, max_examples=5000)
settings.load_profile('tests')


def pytest_configure(config: pytest.Config) -> None:
    """Set what ROS, matplotlib and numpy read when they are imported, here and in children."""
    for name in [name for name in os.environ if name.startswith(LEFT_BY_THE_USER)]:
        del os.environ[name]
    domain, config.stash[claimed] = claim_domain()
    os.environ.update(
        MPLBACKEND='Agg', ROS_AUTOMATIC_DISCOVERY_RANGE='LOCALHOST', ROS_DOMAIN_ID=str(domain),
        ROS_PYTHON_CHECK_FIELDS='1')
    os.environ.update(dict.fromkeys(THREADS, '1'))      # as `hda` does: more take twice as long


@pytest.hookimpl(hookwrapper=True)
def pytest_collection() -> Iterator[None]:
    """Look for no garbage among all that is imported and collected, now or later: it stays."""
    gc.disable()
    yield
    gc.freeze()
    gc.enable()


@pytest.hookimpl(tryfirst=True)         # before xdist reads the groups
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Keep tests that share what is made once for them in one worker, or each makes it anew."""
    for item in items:
        if item.get_closest_marker('xdist_group') is None and shares(item):
            item.add_marker(pytest.mark.xdist_group(item.path.stem))


def shares(item: pytest.Item) -> bool:
    """Return whether a test uses a fixture of its module, or its module remembers results."""
    known = getattr(item, '_fixtureinfo', None)
    fixtures = known.name2fixturedefs if known else {}
    laws = vars(getattr(item, 'module', item)).values()
    return (any(made[-1].scope == 'module' for made in fixtures.values())
            or any(isinstance(law, REMEMBERS) and law.__module__ == item.path.stem
                   for law in laws))


def claim_domain() -> tuple[int, socket.socket]:
    """
    Return a ROS domain that no other run on this machine has, and the claim to hold on to.

    The claim is the name of an abstract socket: the kernel lets one process bind it and forgets
    it when that process ends, however it ends.
    """
    for domain in DOMAINS:
        claim = socket.socket(socket.AF_UNIX)
        try:
            claim.bind(f'\0hda_torque_estimator/ros_domain/{domain}')
        except OSError:
            claim.close()
        else:
            return domain, claim
    raise pytest.UsageError(f'all {len(DOMAINS)} ROS domains are in use by other test runs')


@pytest.fixture(scope='session', autouse=True)
def ros_log(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Send the log files of the nodes to the directory of the run."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv('ROS_LOG_DIR', str(tmp_path_factory.mktemp('ros_log')))
        yield


@pytest.fixture
def signals() -> Iterator[None]:
    """Leave the signal handlers of this run as they were."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)
