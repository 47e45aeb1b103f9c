#!/usr/bin/env python3
"""Builds a scan on a Dask cluster of this machine, where workers are killed and parts fail.

usage: dask_test.py OCTAVO BUILD_ON_DASK [unittest arguments]
"""

import os
import shutil
import subprocess
import sys
import unittest
import unittest.mock

from distributed import LocalCluster

import engine_scan

BUILD_ON_DASK = ""


class OnDask(engine_scan.OfScan):
    def build(self, before_part=":"):
        """Runs the example; `before_part` is what `octavo part` does before its work."""
        programs = self.stand_in(f'if [ "$1" = part ]; then {before_part}; fi')
        path = f"{programs}:{os.environ['PATH']}"
        with unittest.mock.patch.dict(os.environ, PATH=path), LocalCluster(
                n_workers=2, threads_per_worker=1, dashboard_address=None, protocol="tcp",
                local_directory=self.folder / "dask") as cluster:
            result = subprocess.run(
                [sys.executable, BUILD_ON_DASK, cluster.scheduler_address, "scan.8vo",
                 *engine_scan.PLAN_OPTIONS], cwd=self.folder, capture_output=True, text=True,
                check=False)
        for leftover in ("bin", "once", "dask"):
            shutil.rmtree(self.folder / leftover, ignore_errors=True)
        return result

    def check_built(self, result):
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stdout.splitlines(), [
            "1 of 3 parts", "2 of 3 parts", "3 of 3 parts", "scan.8vo is there"])
        self.check_joined()
        self.assertEqual(self.files(), ["scan.8vo", "scan.raw"])

    def test_the_file_is_that_of_one_machine(self):
        self.check_built(self.build())

    def test_a_worker_that_is_killed_is_replaced(self):
        # The part goes on beside its repetition, as it does where only a connection breaks.
        self.check_built(self.build("mkdir once && kill -9 $PPID"))

    def test_a_part_that_fails_once_is_made_again(self):
        self.check_built(self.build("mkdir once && exit 5"))

    def test_a_part_that_always_fails_is_an_error_and_the_next_run_goes_on(self):
        result = self.build('[ "$4" = 2 ] && echo no disk >&2 && exit 5')
        self.assertEqual(result.returncode, 1)
        self.assertEqual(result.stderr.splitlines()[-1], "octavo part ended with 5: no disk")
        self.assertNotIn("scan.8vo", self.files())
        self.check_built(self.build())


if __name__ == "__main__":
    OCTAVO, BUILD_ON_DASK = map(os.path.abspath, sys.argv[1:3])
    del sys.argv[1:3]
    engine_scan.use(OCTAVO)
    unittest.main()
