"""The program octavo, which reads the scans that this package does not."""

import json
import os
import shutil
import signal
import subprocess
import threading

from ._errors import _CLASSES, ArgumentError, Error

_SECONDS_TO_TIDY_UP = 10
_KIND_OF_EXIT = {2: "invalid_argument", 3: "unsupported_version", 4: "corrupt", 5: "io",
                 6: "limit_exceeded", 7: "source_rejected"}


def build_by_program(source, path, words, given, report):
    """Builds the file; returns what the program warns of.

    Parameters
    ----------
    words : list of str
        What the program is told of the bytes to make.
    given : dict
        threads, max_memory, overwrite and resume, as of `octavo.build`.
    report : callable or None
    """
    program = _program()
    command = [program, "build", _no_option(source), "-o", _no_option(path), "--json",
               "--progress", "json" if report else "none", *words]
    for name, flag in (("threads", "--threads"), ("max_memory", "--max-memory")):
        if given[name]:
            command += [flag, repr(given[name])]
    for name, flag in (("overwrite", "--force"), ("resume", "--resume")):
        if given[name]:
            command.append(flag)
    done = _ran(command, report)
    if done.returncode != 0:
        raise error_of_program(done)
    return json.loads(done.stdout).get("warnings", ())


def error_of_program(done):
    """The exception for what a program ended with."""
    lines = [line for line in done.stderr.splitlines() if line.strip()]
    said = {}
    if lines and lines[-1].startswith('{"error":'):
        said = json.loads(lines.pop())["error"]
    text = "\n".join(lines).removeprefix("octavo: ").removeprefix("error: ")
    kind = said.get("kind") or _KIND_OF_EXIT.get(done.returncode, "internal")
    return _CLASSES.get(kind, Error)(text or f"octavo ended with {done.returncode}",
                                     said.get("detail", ""), said.get("path", ""),
                                     said.get("offset"))


def _program():
    program = shutil.which("octavo")
    if program is None:
        raise ArgumentError("files and folders are read by the program octavo, which is not on "
                            "PATH; install it, or give an array")
    from . import __version__
    said = subprocess.run([program, "--version"], capture_output=True, text=True).stdout.split()
    if __version__ not in said:
        raise ArgumentError(f"{program} is another version than this package, {__version__}")
    return program


def _no_option(path):
    """The path in a form that no program takes for an option."""
    return os.path.join(os.curdir, path) if path.startswith("-") else path


def _ran(command, report=None):
    """As subprocess.run. What ends the wait, as Ctrl-C does, ends the program as well: once it has
    tidied up.

    Parameters
    ----------
    report : callable, optional
        Called as (done, total, what); may raise to end the program.
    """
    # A terminal sends Ctrl-C to both, and a second signal would end the program at once.
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        running = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   text=True, errors="replace")
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    with running:
        try:
            if report:
                said, warned = _followed(running, report)
            else:
                said, warned = running.communicate()
        except BaseException:
            running.terminate()
            try:
                (running.wait if report else running.communicate)(timeout=_SECONDS_TO_TIDY_UP)
            except BaseException:
                running.kill()
            raise
    return subprocess.CompletedProcess(command, running.returncode, said, warned)


def _followed(running, report):
    """What a process says and warns of; lines of progress go to `report`."""
    said, warned = [], []
    listener = threading.Thread(target=lambda: said.append(running.stdout.read()), daemon=True)
    listener.start()
    for line in running.stderr:
        if line.startswith('{"progress":'):
            now = json.loads(line)["progress"]
            report(now["done"], now["total"], now["what"])
        else:
            warned.append(line)
    listener.join()
    running.wait()
    return said[0], "".join(warned)
