"""Arrays and files that the tests of the package share."""

import os
import signal
import subprocess

import numpy as np
import pytest

import octavo


def steps(shape, dtype, seed=1):
    """Voxels that follow one another along x, as those of scans do."""
    random = np.random.default_rng(seed)
    return random.integers(-40, 41, shape).cumsum(2).astype(dtype)


@pytest.fixture(scope="session")
def voxels():
    return steps((130, 97, 150), np.int16)


@pytest.fixture(scope="session")
def path(voxels, tmp_path_factory):
    path = tmp_path_factory.mktemp("scan") / "scan.8vo"
    octavo.build(voxels, path, spacing=(2, 0.5, 0.25), origin=(30, 20, 10), unit="HU", slope=2,
                 intercept=-1000).close()
    return str(path)


@pytest.fixture
def volume(path):
    with octavo.open(path) as volume:
        yield volume


@pytest.fixture
def with_interrupts():
    """A process that a shell started in the background does not get them."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(scope="session")
def run():
    def run(*words):
        return subprocess.run([os.environ["OCTAVO"], *map(str, words)], capture_output=True,
                              text=True, check=False)
    return run


def pytest_sessionfinish(session):
    """Where all peers are installed, a test that is skipped has failed."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if os.environ.get("OCTAVO_PEERS") and reporter.stats.get("skipped"):
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
