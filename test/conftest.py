"""Keep a run of the tests to itself: its own ROS domain, this machine only, no windows."""

from collections.abc import Iterator
import os
import signal
import socket

from hypothesis import settings
import pytest

DOMAINS = range(1, 102)  # beyond 101 the ports of DDS run into those of everybody else
LEFT_BY_THE_USER = ('FASTDDS_', 'FASTRTPS_', 'RMW_', 'ROS_LOCALHOST_ONLY', 'ROS_SECURITY_',
                    'ROS_STATIC_PEERS')

claimed = pytest.StashKey[socket.socket]()

settings.register_profile('tests', deadline=None)
settings.register_profile('fuzz', deadline=None, max_examples=5000)
settings.load_profile('tests')


def pytest_configure(config: pytest.Config) -> None:
    """Set what ROS and matplotlib read when they are imported, here and in child processes."""
    for name in [name for name in os.environ if name.startswith(LEFT_BY_THE_USER)]:
        del os.environ[name]
    domain, config.stash[claimed] = claim_domain()
    os.environ.update(
        MPLBACKEND='Agg', ROS_AUTOMATIC_DISCOVERY_RANGE='LOCALHOST', ROS_DOMAIN_ID=str(domain),
        ROS_PYTHON_CHECK_FIELDS='1')


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
