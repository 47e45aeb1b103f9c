"""Files that the workers of a Dask cluster build: a plan, its parts and their join, as futures.

    from distributed import Client
    import octavo.dask
    with Client("tcp://head:8786"):
        octavo.dask.build("slices/", "scan.8vo", spacing=(0.02, 0.02, 0.02), part_size="4G")

    python -m octavo.dask tcp://head:8786 scan.8vo slices/ --spacing 0.02 --part-size 4G

Workers run the program `octavo`, which is on the PATH of each, and need no Octavo in their Python.
All nodes see source and output by the same paths.
"""

import contextlib
import json
import os
import subprocess
import sys
import warnings

from ._building import _given, _output, _reporter, _words_of
from ._errors import ArgumentError, Error, StorageError
from ._program import error_of_program
from ._sources import require_free, require_name, require_there
from ._volume import Volume
from ._work import several_of, warn_of, whole_number


def build(source, path, *, client=None, parts=None, part_size=None, bands=None, retries=3,
          joins_side_by_side=False, kind=None, spacing=None, preset="small", access=None,
          max_error=0.0, keep_details=0, nan=None, inf=None, thumbnail=False, overwrite=False,
          threads=1, max_memory=0, progress=None, plan_options=()):
    """Build an .8vo file of a scan on disk, in parts that workers make side by side.

    The file is that of `octavo.build`, byte for byte. Until it stands under its name, plan and
    parts lie in the folder PATH.parts; where a build fails or is killed, the same call goes on with
    them. A hidden mark of 116 bytes stays beside the file, by which a task that is run once more
    knows that all is done.

    Parameters
    ----------
    source : path, or a list of them
        What the program `octavo` reads: a folder of DICOM or TIFF slices, NIfTI and others.
    path : str or os.PathLike
        Ends in .8vo.
    client : distributed.Client, optional
        None: the one that was opened last; without any, what `dask.config` names as the scheduler
        of this machine ("threads", "processes", "synchronous").
    parts, part_size, bands : int; int or str; int, optional
        At most one of them: how many parts, how many bytes of voxels a part has at most ("4G"),
        how many parts share a group of slices.
    retries : int
        How often a part that fails is tried again. One whose worker dies is given to another one,
        as often as the cluster allows.
    joins_side_by_side : bool
        Parts are copied into the file by as many workers as there are. Else one worker copies all.
    kind, spacing, preset, access, max_error, keep_details, nan, inf, thumbnail, overwrite
        As of `octavo.build`.
    threads : int
        Of each part. A worker makes as many parts at a time as it has threads.
    max_memory : int
        Of each part, in bytes; 0: no limit.
    progress : callable or True, optional
        Called as progress(done, total, what), what being "parts" or "copies"; True shows a bar.
    plan_options : sequence of str
        More options of `octavo plan`, as words: ("--raw", "512,512,140,uint16").

    Returns
    -------
    Volume
        The file, opened.

    Raises
    ------
    octavo.MissingError
        Where there is no source.
    octavo.Error
        Of the kind that the program names. distributed.KilledWorker, where worker after worker
        dies.
    """
    given = _given(preset, access, max_error, keep_details, nan, inf, thumbnail, overwrite, False,
                   threads, max_memory)
    output = os.path.abspath(_output(path))
    retries = whole_number(retries, "retries", 0)
    words = [*_words_of({"kind": kind, "spacing": spacing}, given),
             *_division(parts, part_size, bands), *map(str, plan_options)]
    sources = _sources(source)
    require_free(output, overwrite)
    limits = ["-j", str(max(given["threads"], 1))]
    if given["max_memory"]:
        limits += ["--max-memory", str(given["max_memory"])]
    work = _Work(_cluster(client), retries, limits)
    with _reporter(progress) as report:
        _build(work, [*sources, *words], output, bool(overwrite), bool(joins_side_by_side),
               report or (lambda *_: None))
    warn_of(work.warnings)
    return Volume(output)


def _build(work, planned, output, overwrite, joins_side_by_side, report):
    folder = output + ".parts"
    plan = os.path.join(folder, "scan.plan")
    goes_on = os.path.exists(plan)
    try:
        with contextlib.suppress(FileExistsError):
            os.mkdir(folder)
    except OSError as error:
        raise StorageError(f"{folder}: {error.strerror}", path=folder) from None
    # The same source and options make the same plan, so that its parts are kept.
    try:
        count = work.one("plan", *planned, "-f", "-o", plan)["parts"]
    except BaseException:
        # Of a build that has not begun nothing is left.
        with contextlib.suppress(OSError):
            os.rmdir(folder)
        raise
    numbers = list(range(count))
    if goes_on:
        # Those that a join has taken up already are not missing.
        said = work.one("join", plan, folder, "--missing", "-o", output, codes=(0, 1))
        numbers = [row["part"] for row in said["missing"]]
    there = count - len(numbers)
    report(there, count, "parts")
    work.each([("part", plan, "--part", n, "-o", folder) for n in numbers],
              lambda done: report(there + done, count, "parts"))
    join = ["join", plan, folder, "-o", output, *(["-f"] if overwrite else [])]
    if joins_side_by_side:
        work.one(*join, "--step", "layout")
        report(0, count, "copies")
        work.each([(*join, "--step", "copy", "--consume", "--part", n) for n in range(count)],
                  lambda done: report(done, count, "copies"))
        work.one(*join, "--step", "seal")
    else:
        work.one(*join, "--consume")
    os.unlink(plan)
    # What others have put into the folder stays.
    with contextlib.suppress(OSError):
        os.rmdir(folder)


class _Work:
    """Runs the program, on a cluster or by a scheduler of this machine."""

    def __init__(self, client, retries, limits):
        self._client = client
        self._retries = retries
        self._limits = limits
        self.warnings = {}

    def one(self, *words, codes=(0,)):
        """What a run of the program prints as JSON."""
        results = []
        self._run([words], codes, results.append)
        return results[0]

    def each(self, works, tell):
        """Runs works side by side; `tell` gets the number of those that are done."""
        done = []

        def count(result):
            done.append(result)
            tell(len(done))
        self._run(works, (0,), count)

    def _run(self, works, codes, take):
        commands = [["octavo", *map(str, words), *self._limits, "--json", "--progress", "none"]
                    for words in works]

        def take_json(done):
            if done.returncode not in codes:
                raise error_of_program(done)
            said = json.loads(done.stdout)
            self.warnings.update(dict.fromkeys(said.get("warnings", ())))
            take(said)

        try:
            if self._client is None:
                _run_here(commands, self._retries, codes, take_json)
            else:
                _run_on(self._client, commands, self._retries, codes, take_json)
        except subprocess.CalledProcessError as error:
            raise error_of_program(error) from None
        except FileNotFoundError:
            raise ArgumentError("the program octavo is not on PATH where the work is done; install "
                                "it on every node") from None


def _run_on(client, commands, retries, codes, take):
    from distributed import as_completed
    # A function that every worker has. What fails raises there, so that it is tried again.
    futures = client.map(subprocess.run, commands, capture_output=True, text=True,
                         check=codes == (0,), retries=retries, pure=False)
    try:
        for future in as_completed(futures):
            take(future.result())
    finally:
        client.cancel([future for future in futures if not future.done()])


def _run_here(commands, retries, codes, take):
    import dask
    from dask.callbacks import Callback
    run = dask.delayed(_repeated, pure=False)
    with Callback(posttask=lambda _key, done, *_: take(done)):
        dask.compute(*(run(tuple(command), retries, codes) for command in commands))


def _repeated(command, retries, codes):
    done = subprocess.run(command, capture_output=True, text=True)
    while done.returncode not in codes and retries > 0:
        retries -= 1
        done = subprocess.run(command, capture_output=True, text=True)
    return done


def _cluster(client):
    """The client that is given, else the one that was opened last, else None."""
    if client is None and "distributed" in sys.modules:
        with contextlib.suppress(ValueError):
            client = sys.modules["distributed"].default_client()
    if client is not None and client.asynchronous:
        raise ArgumentError("the client is an asynchronous one; give one that waits")
    return client


def _sources(source):
    paths = [source] if isinstance(source, (str, os.PathLike)) else several_of(source, "sources")
    if not paths or not all(isinstance(path, (str, os.PathLike)) for path in paths):
        raise ArgumentError("the source is a folder or files of a scan; arrays are built by "
                            "octavo.build")
    for path in map(os.fspath, paths):
        require_name(path)
        require_there(path)
    return list(map(os.path.abspath, paths))


def _division(parts, part_size, bands):
    if parts is not None:
        parts = whole_number(parts, "parts", 1)
    if bands is not None:
        bands = whole_number(bands, "bands", 1)
    if part_size is not None and not isinstance(part_size, str):
        part_size = whole_number(part_size, "part_size", 1)
    given = [(name, value) for name, value in
             (("--parts", parts), ("--part-size", part_size), ("--bands", bands))
             if value is not None]
    if len(given) > 1:
        raise ArgumentError("give one of parts, part_size and bands")
    return [f"{name}={value}" for name, value in given]


def _main(words):
    if len(words) < 3:
        sys.exit(__doc__)
    from distributed import Client
    scheduler, output, *rest = words
    options = next((i for i, word in enumerate(rest) if word.startswith("-")), len(rest))

    def tell(done, total, what):
        print(f"{done} of {total} {what}", flush=True)
    with Client(scheduler) as client, warnings.catch_warnings():
        warnings.showwarning = lambda text, *_: print(f"warning: {text}", file=sys.stderr)
        try:
            build(rest[:options], output, client=client, progress=tell,
                  plan_options=rest[options:]).close()
        except Error as error:
            sys.exit(str(error))
    print(f"{output} is there")


if __name__ == "__main__":
    _main(sys.argv[1:])
