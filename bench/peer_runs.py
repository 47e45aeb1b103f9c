"""What the benches of Python packages share: timed runs, each in a process, and their rows."""

import ctypes
import io
import os
import pickle
import statistics
import sys
import time
from pathlib import Path

ENVIRONMENT = Path(__file__).resolve().parent.parent / "build" / "bench-venv"
HEADER = ("commit,machine,threads,data_set,operation,runs,median_s,spread_s,bytes,raw_bytes,ratio,"
          "MB_per_s,Mvoxel_per_s,peak_memory_bytes,bits_per_voxel,max_error,measured_error,psnr_db")


def enter_environment():
    """Starts the program again in the environment that bench/setup makes."""
    name = Path(sys.argv[0]).name
    python = ENVIRONMENT / "bin" / "python"
    if not python.exists() or Path(sys.prefix) == ENVIRONMENT:
        sys.exit(f"bench/{name}: {ENVIRONMENT} is not there or not complete: run bench/setup")
    os.execv(python, [str(python), *sys.argv])


def memory(key):
    """VmRSS or VmHWM of this process, bytes."""
    for line in open("/proc/self/status"):
        if line.startswith(key):
            return int(line.split()[1]) * 1024
    return 0


def measured(work):
    """(result, seconds of the processor, growth of resident memory in bytes) of work()."""
    ctypes.CDLL(None).malloc_trim(0)  # memory that was freed before would hide what work() needs
    with open("/proc/self/clear_refs", "w") as file:
        file.write("5\n")
    before = memory("VmRSS")
    start = time.process_time()
    result = work()
    seconds = time.process_time() - start
    return result, seconds, max(memory("VmHWM") - before, 0)


def in_child(work, name):
    """What work() returns in a process of its own; ends the program where that fails."""
    source, target = os.pipe()
    child = os.fork()
    if child == 0:
        status = 1
        try:
            with io.open(target, "wb") as file:
                pickle.dump(work(), file)
            status = 0
        except BaseException as error:
            print(error, file=sys.stderr)
        os._exit(status)
    os.close(target)
    with io.open(source, "rb") as file:
        answer = file.read()
    if os.waitpid(child, 0)[1] != 0:
        sys.exit(f"bench/{Path(sys.argv[0]).name}: {name} failed")
    return pickle.loads(answer)


def machine_name():
    for line in open("/proc/cpuinfo"):
        if line.startswith("model name"):
            name = line.split(":", 1)[1].strip().replace(",", " ")
            return f"{name} / {os.cpu_count()} cores"
    return "unknown"


def lines_of(path):
    """The fields of the lines of a list of volumes: name, path, layout, spacing."""
    for line in open(path):
        if line.strip() and not line.startswith("#"):
            yield line.split()


def print_row(commit, data_set, operation, voxel_count, raw_bytes, length, runs):
    """A row of runs [(seconds, peak bytes)] over voxels that `length` bytes stand for."""
    seconds = [run[0] for run in runs]
    middle = statistics.median(seconds)
    print(commit, machine_name(), 1, data_set, operation, len(runs), f"{middle:.6f}",
          f"{max(seconds) - min(seconds):.6f}", length, raw_bytes, f"{raw_bytes / length:.4f}",
          f"{raw_bytes / middle / 1e6:.2f}", f"{voxel_count / middle / 1e6:.2f}",
          max(run[1] for run in runs), f"{length * 8 / voxel_count:.4f}", 0, 0, "", sep=",",
          flush=True)
