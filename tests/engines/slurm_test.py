#!/usr/bin/env python3
"""Builds a scan as a job array of a Slurm cluster of one node, which the test starts.

usage: slurm_test.py OCTAVO [unittest arguments]
"""

import os
import pathlib
import pwd
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

import engine_scan

SECONDS_TO_WAIT = 300  # only for what hangs

CONFIGURATION = """
ClusterName=one
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller_port}
SlurmdPort={node_port}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
ReturnToService=2
SlurmdParameters=config_overrides
MailProg=/bin/true
SchedulerParameters=sched_interval=1,batch_sched_delay=0
MinJobAge=3600
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 RealMemory=4000 State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE OverSubscribe=FORCE:4 State=UP
"""


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for each in sockets:
        each.bind(("127.0.0.1", 0))
    ports = [each.getsockname()[1] for each in sockets]
    for each in sockets:
        each.close()
    return ports


class Cluster:
    """Daemons of its own in a folder of its own; those of the machine are left alone."""

    def __init__(self):
        # The way to a socket must be short.
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="slurm-", dir="/tmp"))
        self.folder.chmod(0o755)
        for name in ("state", "spool"):
            (self.folder / name).mkdir()
        (self.folder / "munge.key").write_bytes(os.urandom(128))
        (self.folder / "munge.key").chmod(0o400)
        controller_port, node_port = free_ports(2)
        (self.folder / "slurm.conf").write_text(CONFIGURATION.format(
            host=socket.gethostname().split(".")[0], folder=self.folder,
            user=pwd.getpwuid(os.getuid()).pw_name, controller_port=controller_port,
            node_port=node_port))
        os.environ["SLURM_CONF"] = str(self.folder / "slurm.conf")
        self.daemons = []

    def start(self):
        self.daemon("munged", "--foreground", "--force", f"--key-file={self.folder}/munge.key",
                    f"--socket={self.folder}/munge.socket", f"--pid-file={self.folder}/munge.pid",
                    f"--seed-file={self.folder}/munge.seed", f"--log-file={self.folder}/munge.log")
        self.wait_until(lambda: (self.folder / "munge.socket").exists(), "munged")
        self.daemon("slurmctld", "-D")
        self.daemon("slurmd", "-D")
        self.wait_until(lambda: self.asked("sinfo", "-h", "-o", "%T") == "idle", "slurmd")

    def daemon(self, *command):
        log = open(self.folder / f"{command[0]}.out", "wb")
        self.daemons.append(subprocess.Popen(["/usr/sbin/" + command[0], *command[1:]],
                                             stdout=log, stderr=log, cwd=self.folder))
        log.close()

    @staticmethod
    def asked(*command):
        return subprocess.run(command, capture_output=True, text=True,
                              check=False).stdout.strip()

    def wait_until(self, true, what):
        end = time.monotonic() + SECONDS_TO_WAIT
        while not true():
            if time.monotonic() > end:
                logs = [path.read_text(errors="replace")[-3000:]
                        for path in self.folder.iterdir() if path.suffix in (".log", ".out")]
                raise AssertionError("\n".join([f"waited in vain: {what}", *logs]))
            time.sleep(0.2)

    def stop(self):
        for daemon in reversed(self.daemons):
            daemon.send_signal(signal.SIGTERM)
            daemon.wait()
        shutil.rmtree(self.folder, ignore_errors=True)


class OnSlurm(engine_scan.OfScan):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.cluster = Cluster()
        cls.addClassCleanup(cls.cluster.stop)
        cls.cluster.start()

    def setUp(self):
        super().setUp()
        self.octavo("plan", *engine_scan.PLAN_OPTIONS, "-o", "scan.plan")

    def submit(self, *options, wrap, path=None):
        result = subprocess.run(
            ["sbatch", "--parsable", "--mem=400M", "--output=%A-%a.log", *options, "--wrap", wrap],
            cwd=self.folder, capture_output=True, text=True, check=False,
            env={**os.environ, **({"PATH": f"{path}:{os.environ['PATH']}"} if path else {})})
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout.strip()

    def states(self, job):
        listed = self.cluster.asked("squeue", "-h", "-r", "-t", "all", "-j", job, "-o", "%K %T")
        return dict(line.split() for line in listed.splitlines())

    def wait_for(self, job, state):
        self.cluster.wait_until(lambda: set(self.states(job).values()) == {state},
                                f"{job} {state}: {self.states(job)}")

    def submit_array(self, *options, path=None):
        return self.submit("--array=0-2", *options, path=path,
                           wrap="octavo part scan.plan -j 1 -o parts/")

    def submit_join(self, after):
        return self.submit(f"--dependency=afterok:{after}",
                           wrap="octavo join scan.plan parts/ -o scan.8vo")

    def test_an_array_and_a_join_that_depends_on_it_make_the_file_of_one_machine(self):
        self.wait_for(self.submit_join(self.submit_array()), "COMPLETED")
        self.check_joined()

    def held(self):
        """A program whose first `octavo part` of part 1 waits where it has begun."""
        return self.stand_in('if [ "$1" = part ] && [ "$SLURM_ARRAY_TASK_ID" = 1 ] && mkdir held; '
                             "then sleep 1000; fi")

    def wait_until_held(self):
        self.cluster.wait_until((self.folder / "held").exists, "part 1 begins")

    def test_a_task_that_is_requeued_is_made_again_and_the_join_waits_for_it(self):
        parts = self.submit_array("--requeue", path=self.held())
        join = self.submit_join(parts)
        self.wait_until_held()
        subprocess.run(["scontrol", "requeue", f"{parts}_1"], check=True)
        self.assertEqual(set(self.states(join).values()), {"PENDING"})
        # A requeued task is held back for two minutes unless its time is set.
        self.cluster.wait_until(lambda: self.states(parts).get("1") == "PENDING", "requeued")
        subprocess.run(["scontrol", "update", f"jobid={parts}_1", "starttime=now"], check=True)
        self.wait_for(join, "COMPLETED")
        self.check_joined()

    def test_after_a_task_was_killed_an_array_of_what_is_missing_completes_the_file(self):
        parts = self.submit_array(path=self.held())
        self.wait_until_held()
        subprocess.run(["scancel", "--signal=KILL", f"{parts}_1"], check=True)
        self.cluster.wait_until(
            lambda: sorted(self.states(parts).values()) in (
                ["CANCELLED", "COMPLETED", "COMPLETED"], ["COMPLETED", "COMPLETED", "FAILED"]),
            "the array ends")
        missing = subprocess.run(["octavo", "join", "scan.plan", "parts/", "--missing"], text=True,
                                 cwd=self.folder, stdout=subprocess.PIPE, check=False)
        self.assertEqual((missing.returncode, missing.stdout), (1, "1\n"))
        again = self.submit(f"--array={missing.stdout.strip()}",
                            wrap="octavo part scan.plan -j 1 -o parts/")
        self.wait_for(self.submit_join(again), "COMPLETED")
        self.check_joined()


if __name__ == "__main__":
    OCTAVO = sys.argv.pop(1)
    engine_scan.use(OCTAVO)
    unittest.main()
