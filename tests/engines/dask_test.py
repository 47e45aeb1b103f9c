#!/usr/bin/env python3
"""Builds a scan on a Dask cluster of this machine, where workers are killed and parts fail.

usage: dask_test.py OCTAVO PACKAGES [unittest arguments]

PACKAGES is the folder in which the Python package octavo is.
"""

import contextlib
import os
import shutil
import subprocess
import sys
import unittest
import unittest.mock

from distributed import Client, LocalCluster

import engine_scan


class OnDask(engine_scan.OfScan):
    @contextlib.contextmanager
    def cluster(self, script=":"):
        """Two workers, whose program runs `script` before its work; the verb is $1."""
        path = f"{self.stand_in(script)}:{os.environ['PATH']}"
        with unittest.mock.patch.dict(os.environ, PATH=path), LocalCluster(
                n_workers=2, threads_per_worker=1, dashboard_address=None, protocol="tcp",
                local_directory=self.folder / "dask") as cluster:
            yield cluster
        for leftover in ("bin", "once", "dask"):
            shutil.rmtree(self.folder / leftover, ignore_errors=True)

    def build(self, before_part=":"):
        """By the program; `before_part` is what `octavo part` does before its work."""
        with self.cluster(f'if [ "$1" = part ]; then {before_part}; fi') as cluster:
            return subprocess.run(
                [sys.executable, "-m", "octavo.dask", cluster.scheduler_address, "scan.8vo",
                 *engine_scan.PLAN_OPTIONS], cwd=self.folder, capture_output=True, text=True,
                check=False)

    def check_built(self, result):
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stdout.splitlines(), [
            *(f"{n} of 3 parts" for n in range(4)), "scan.8vo is there"])
        self.check_joined()
        self.assertEqual(self.files(), ["scan.8vo", "scan.raw"])

    def test_the_file_is_that_of_one_machine(self):
        self.check_built(self.build())

    def test_a_worker_that_is_killed_is_replaced(self):
        # The part goes on beside its repetition, as it does where only a connection breaks.
        self.check_built(self.build(f"mkdir {self.folder}/once 2>/dev/null && kill -9 $PPID"))

    def test_copies_of_workers_that_are_killed_are_made_again(self):
        script = ('case "$*" in *copy*) '
                  f'mkdir {self.folder}/once 2>/dev/null && kill -9 $PPID;; esac')
        told = []
        with self.cluster(script) as cluster, Client(cluster):
            # Without a word of the client: the one that is open counts.
            octavo.dask.build(
                self.folder / "scan.raw", self.folder / "scan.8vo", parts=3, preset="fast",
                spacing=(1, 1, 1), joins_side_by_side=True, plan_options=engine_scan.OPTIONS[1:3],
                progress=lambda *said: told.append(said))
            self.assertTrue(os.path.exists(self.folder / "once"))
        self.assertEqual(told, [(n, 3, what) for what in ("parts", "copies") for n in range(4)])
        self.check_joined()

    def test_a_part_that_fails_once_is_made_again(self):
        self.check_built(self.build(f"mkdir {self.folder}/once 2>/dev/null && exit 5"))

    def test_a_part_that_always_fails_is_an_error_and_the_next_run_goes_on(self):
        result = self.build('[ "$4" = 2 ] && echo no disk >&2 && exit 5')
        self.assertEqual(result.returncode, 1)
        self.assertEqual(result.stderr.splitlines()[-1], "no disk")
        self.assertNotIn("scan.8vo", self.files())
        result = self.build()
        self.assertEqual(result.stdout.splitlines(), [
            "2 of 3 parts", "3 of 3 parts", "scan.8vo is there"])
        self.check_joined()
        self.assertEqual(self.files(), ["scan.8vo", "scan.raw"])


if __name__ == "__main__":
    OCTAVO, PACKAGES = map(os.path.abspath, sys.argv[1:3])
    del sys.argv[1:3]
    engine_scan.use(OCTAVO)
    os.environ["PYTHONPATH"] = PACKAGES
    sys.path.append(PACKAGES)
    import octavo.dask
    unittest.main()
