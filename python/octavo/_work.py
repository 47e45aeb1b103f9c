"""What every task gets beside its options, and the arguments that tasks share."""

import contextlib
import math
import numbers
import operator
import sys
import threading
import warnings

import numpy as np

from ._errors import ArgumentError, package_error

MOST_THREADS = 1 << 10
CONNECTIVITIES = (6, 18, 26)
AXES = {"z": 2, "y": 1, "x": 0}


def warn_of(texts, thread=None):
    """Warns who has called the package, on the thread of that number or on this one."""
    frame = sys._current_frames()[thread or threading.get_ident()]
    while frame.f_back and frame.f_globals.get("__name__", "").partition(".")[0] == __package__:
        frame = frame.f_back
    names = frame.f_globals
    for text in texts:
        warnings.warn_explicit(text, UserWarning, frame.f_code.co_filename, frame.f_lineno,
                               names.get("__name__"), names.setdefault("__warningregistry__", {}))


@contextlib.contextmanager
def work_of(threads=0, max_memory=0, progress=None):
    """The dictionary that tasks of the extension take."""
    with _reporter(progress) as report:
        yield dict(threads=whole_number(threads, "threads", 0, MOST_THREADS),
                   max_memory=whole_number(max_memory, "max_memory", 0), progress=report)


def connectivity_of(given):
    """6, 18 or 26. Raises ArgumentError for anything else."""
    if given not in CONNECTIVITIES or isinstance(given, bool):
        raise ArgumentError(f"connectivity is 6 (faces), 18 (edges) or 26 (corners), not {given!r}")
    return int(given)


def asked_labels(labels):
    """Labels by number and by name, from a number, a name or several of them; both empty for None.
    Raises ArgumentError for none at all, which would be taken for all."""
    if labels is None:
        return [], []
    if isinstance(labels, (str, numbers.Integral)):
        labels = [labels]
    labels = several_of(labels, "labels")
    if not labels:
        raise ArgumentError("labels holds none; leave it out for all labels")
    names = [label for label in labels if isinstance(label, str)]
    return [whole_number(label, "a label", -(1 << 62)) for label in labels
            if not isinstance(label, str)], names


def several_of(given, name):
    """A list of what can be gone through. Raises ArgumentError for anything else."""
    try:
        return list(given)
    except TypeError:
        raise ArgumentError(f"{name} are several, not {given!r}") from None


def text_of(given, name):
    """`given`, which is text. Raises ArgumentError for anything else."""
    if not isinstance(given, str):
        raise ArgumentError(f"{name} is text, not {given!r}")
    return given


def texts_of(given, name):
    """A list of texts, from one or several. Raises ArgumentError for anything else."""
    several = [given] if isinstance(given, str) else several_of(given, name)
    return [text_of(one, name) for one in several]


def level_of(given):
    """A level as an int; the file says whether it has that. Raises ArgumentError."""
    return whole_number(given, "level", 0, (1 << 31) - 1)


def three_of(given, name):
    """Three finite numbers, z, y, x. Raises ArgumentError for anything else."""
    try:
        numbers_given = [float(n) for n in given]
    except (TypeError, ValueError, OverflowError):
        numbers_given = []
    if len(numbers_given) != 3 or not all(map(math.isfinite, numbers_given)):
        raise ArgumentError(f"{name} is (z, y, x), not {given!r}")
    return numbers_given


def if_given(check, given, *rest):
    """What `check` makes of an argument that may be left out."""
    return None if given is None else check(given, *rest)


def number_of(given, name):
    """A finite number as a float. Raises ArgumentError for anything else."""
    try:
        number = float(given)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise ArgumentError(f"{name} is a number, not {given!r}")
    return number


def range_of(given, name="a range"):
    """(low, high) as floats; None is an open end."""
    try:
        low, high = given
        low = -math.inf if low is None else float(low)
        high = math.inf if high is None else float(high)
    except (TypeError, ValueError, OverflowError):
        raise ArgumentError(f"{name} is (low, high), not {given!r}") from None
    if math.isnan(low) or math.isnan(high):
        raise ArgumentError(f"{name} has no end that is NaN: {given!r}")
    if not low <= high:
        raise ArgumentError(f"{name} begins above its end: {given!r}")
    return low, high


def grid_affine(direction, spacing, origin):
    """4 x 4: the index (z, y, x, 1) of a voxel to its center in the world, LPS x, y, z, mm."""
    matrix = np.eye(4)
    matrix[:3, :3] = np.array(direction).reshape(3, 3)[:, ::-1] * np.array(spacing)
    matrix[:3, 3] = tuple(origin)[::-1]
    return matrix


def whole_number(given, name, lowest, highest=(1 << 63) - 1):
    """`given` as an int. Raises ArgumentError for other things and other numbers."""
    try:
        number = operator.index(given)
    except TypeError:
        number = None
    if number is None or not lowest <= number <= highest:
        raise ArgumentError(f"{name} is a whole number from {lowest} to {highest}, not {given!r}")
    return number


@contextlib.contextmanager
def _reporter(progress):
    if progress is not True:
        if progress is not None and progress is not False and not callable(progress):
            raise ArgumentError(f"progress is a function, or True, not {progress!r}")
        yield progress or None
        return
    try:
        from tqdm.auto import tqdm
    except ImportError as error:
        raise package_error("tqdm", "progress=True needs tqdm (pip install tqdm); a function "
                            "progress(done, total, what) does without it", error) from None
    with tqdm() as bar:
        def report(done, total, what):
            bar.total = total
            bar.set_description(what, refresh=False)
            bar.update(done - bar.n)
        yield report
