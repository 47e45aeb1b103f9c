"""Processor time of running programs: moments and limits that do not depend on what else runs."""

import resource
import time

# The kernel's number for "time that the threads of a process ran", as clock_getcpuclockid makes it.
CLOCK_OF_PROCESS = 2


def of_children():
    """Seconds that all children used that were waited for."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def of_process(process):
    """Seconds that a started process has used so far; None once it has been waited for."""
    try:
        return time.clock_gettime(~process.pid << 3 | CLOCK_OF_PROCESS)
    except OSError:
        return None


def wait_until(holds):
    """Returns once `holds()` is true; what hangs is ended by the test runner."""
    while not holds():
        time.sleep(0.001)


def let_run(process, seconds):
    """Returns once a started process has used `seconds`, or has ended."""
    wait_until(lambda: process.poll() is not None or (of_process(process) or 0) >= seconds)
