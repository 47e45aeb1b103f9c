#!/usr/bin/env python3
"""Builds a scan with the ranks of an MPI job, and ends ranks in the middle of it.

usage: mpi_test.py OCTAVO OCTAVO_MPI [unittest arguments]

The volume has five groups of planes; everything is generated. With OCTAVO_NIGHTLY_SHARE set, 100
times that share jobs lose a rank, and 7 ranks build.
"""

import array
import json
import os
import pathlib
import random
import re
import signal
import subprocess
import sys
import time

import cli_test
import render_test
from shared_folder import folder_of

OCTAVO_MPI = ""
SIZE = (512, 512, 268)  # of uint16: four groups of 64 planes and one of 12
SECONDS_TO_END = 10
LONGEST_HEAD = 4096  # bytes of a journal before its first group

NIGHTLY = float(os.environ.get("OCTAVO_NIGHTLY_SHARE", 0))
KILLED_JOBS = max(2, int(100 * NIGHTLY))
RANKS = (1, 3, 7) if NIGHTLY else (1, 3)


def voxels():
    """Planes that differ in a quarter, of few values, so that they are encoded fast."""
    numbers = random.Random(7)
    rest = bytes(SIZE[0])
    rows = [array.array("H", (x // 8 * y % 97 for x in range(SIZE[0] // 2))).tobytes() + rest
            for y in range(97)]
    quarters = bytes(SIZE[0] * SIZE[1])
    planes = []
    for _ in range(SIZE[2]):
        shift = numbers.randrange(97)
        planes.append(b"".join(rows[(y // 4 + shift) % 97] for y in range(SIZE[1] // 2)) + quarters)
    return b"".join(planes)


VOXELS = voxels()
SOURCE = ("scan.raw", "--raw", "512,512,268,uint16", "--spacing", "1", "--preset", "fast")
# Training on a group of it takes a second: who stops a job of it is in time.
SLOW_SOURCE = (*SOURCE[:-1], "small")


def environment():
    kept = {name: value for name, value in os.environ.items()
            if not name.startswith(("OMPI_", "PMI", "SLURM_"))}
    # Only this machine, which may have fewer cores than ranks.
    return {**kept, "OMPI_MCA_plm": "isolated", "OMPI_MCA_btl_vader_single_copy_mechanism": "none"}


def parent_of(process):
    try:
        return int(pathlib.Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[1])
    except (OSError, IndexError):
        return 0


def is_running(process):
    """Not once it waits for nothing but init."""
    try:
        stat = pathlib.Path(f"/proc/{process}/stat").read_text()
    except OSError:
        return False
    return "(octavo-mpi)" in stat and stat.rpartition(")")[2].split()[0] != "Z"


def ranks_of(job):
    """The processes that mpirun has started, by their numbers."""
    found = {}
    for path in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            name = (path / "comm").read_text().strip()
            variables = (path / "environ").read_bytes().split(b"\0")
        except OSError:
            continue
        if name != "octavo-mpi" or parent_of(path.name) != job.pid:
            continue
        for variable in variables:
            if variable.startswith(b"OMPI_COMM_WORLD_RANK="):
                found[int(variable.partition(b"=")[2])] = int(path.name)
    return found


class ByRanks(cli_test.InFolder):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.shared = folder_of(cls)
        (cls.shared / "scan.raw").write_bytes(VOXELS)

    def setUp(self):
        super().setUp()
        os.link(self.shared / "scan.raw", self.folder / "scan.raw")

    def start(self, ranks, *arguments, program=None):
        return subprocess.Popen(
            ["mpirun", "--oversubscribe", "--allow-run-as-root", "--bind-to", "none",
             "-n", str(ranks), *(program or [OCTAVO_MPI]), *arguments],
            cwd=self.folder, env=environment(), stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def build(self, ranks, *options, code=0):
        job = self.start(ranks, "build", *SOURCE, *options, "-o", "scan.8vo")
        out, error = job.communicate()
        self.assertEqual(job.returncode, code, error)
        return out, error

    def expected(self):
        """The file of one process, made once for all tests of a class."""
        whole = self.shared / "whole.8vo"
        if not whole.exists():
            self.expect(0, "build", *SOURCE, "-q", "-o", whole)
        return whole.read_bytes()

    def bytes_built(self):
        data = (self.folder / "scan.8vo").read_bytes()
        (self.folder / "scan.8vo").unlink()
        return data

    def left(self):
        """What a job left beside the file."""
        return [path.name for path in self.folder.glob(".scan.8vo.*")]


class BuildByRanks(ByRanks):
    def test_the_file_is_that_of_one_process(self):
        expected = self.expected()
        for ranks in RANKS:
            # A single rank sends nothing, whatever the plan.
            for plan in ("tree", "mesh") if ranks > 1 else ("tree",):
                with self.subTest(ranks=ranks, plan=plan):
                    self.build(ranks, "--gather", plan)
                    self.assertEqual(self.bytes_built(), expected)
                    self.assertEqual(self.left(), [])

    def test_the_report_stands_beside_the_model(self):
        out, _ = self.build(3, "--report=json")
        result = json.loads(out)
        report = result["report"]
        self.assertEqual(result["file_bytes"], (self.folder / "scan.8vo").stat().st_size)
        self.assertEqual(report["ranks"], 3)
        self.assertEqual(report["levels"][0]["codes"], 512 * 512 * 268)
        # Of ranks 1 and 2, which have groups 1, 4 and 2, each brick gives one code.
        sent = {row["level"]: row["sent"] for row in report["levels"] if row["sent"]}
        self.assertEqual(sent, {6: 3 * 64})
        self.assertEqual(sum(share["groups"] for share in report["shares"]), 5)
        self.assertLessEqual(report["codes_sent"], report["codes_sent_thesis"])
        self.assertLess(report["held_bytes"], report["held_thesis"])
        text, _ = self.build(1, "--report", "--force")
        self.assertIn("thesis 2.8", text)
        self.assertIn("thesis 2.9", text)

    def test_a_limit_below_a_group_says_what_needs_less(self):
        needed = set()
        for limit in "290M", "1M":
            _, error = self.build(2, "--max-memory", limit, code=6)
            words = r"the build needs about (\d+) MiB of memory; the limit is \d+ MiB"
            self.assertRegex(error, words)
            needed.add(re.search(words, error).group(1))
            self.assertIn("ranks encode whole groups; the parts of a plan may encode bands", error)
        self.assertEqual(len(needed), 1, "the whole need at once")
        self.assertEqual(self.left(), [])

    def test_failures_name_rank_and_cause(self):
        (self.folder / "scan.8vo").write_bytes(b"somebody's")
        _, error = self.build(3, code=5)
        self.assertIn("exists already", error)
        self.assertIn("rank 0 of 3", error)
        self.assertEqual((self.folder / "scan.8vo").read_bytes(), b"somebody's")
        # One sentence for all ranks, also where the first of them begins last.
        late = ("sh", "-c", '[ "$OMPI_COMM_WORLD_RANK" != 0 ] || sleep 1; exec "$0" "$@"',
                OCTAVO_MPI)
        for program in None, late:
            job = self.start(3, "build", "--no-such-option", program=program)
            self.assertEqual(job.communicate()[1].count("octavo: "), 1)
            self.assertEqual(job.returncode, 2)


class PagesOfRanks(cli_test.InFolder):
    def told(self, *arguments):
        return subprocess.run([OCTAVO_MPI, *arguments], cwd=self.folder, capture_output=True,
                              text=True, check=True).stdout

    def test_program_and_verbs_have_manual_pages(self):
        self.told("manual", "-o", "pages")
        self.assertEqual(sorted(path.name for path in (self.folder / "pages").iterdir()),
                         sorted(["octavo-mpi.1"] + [f"octavo-mpi-{verb}.1" for verb in
                                                    ("build", "codes", "completion", "manual",
                                                     "render")]))
        page = self.told("manual", "build")
        self.assertIn("\\fB\\-\\-silent\\-limit\\fR", page)
        for section in ("SYNOPSIS\n\\fBoctavo\\-mpi build\\fR", "EXAMPLES\n", "EXIT STATUS\n"):
            self.assertIn(f".SH {section}", page)

    def test_shells_complete_verbs_and_options(self):
        (self.folder / "script").write_text(self.told("completion", "bash"))
        asked = ("source ./script; COMP_WORDS=(octavo-mpi build --sil); COMP_CWORD=2; "
                 "_octavo_mpi; echo ${COMPREPLY[@]}; complete -p octavo-mpi")
        offered = subprocess.run(["bash", "-c", asked], cwd=self.folder, capture_output=True,
                                 text=True, check=True).stdout
        self.assertEqual(offered, "--silent-limit\ncomplete -F _octavo_mpi octavo-mpi\n")
        self.assertTrue(self.told("completion", "zsh").startswith("#compdef octavo-mpi\n"))
        self.assertIn("complete -c octavo-mpi -n", self.told("completion", "fish"))


class CodesByRanks(ByRanks):
    def test_codes_are_those_of_one_process(self):
        size = (40, 36, 50)
        labels = bytes((x // 9 + y // 12 + z // 16) % 3
                       for z in range(size[2]) for y in range(size[1]) for x in range(size[0]))
        (self.folder / "labels.raw").write_bytes(labels)
        self.expect(0, "build", "labels.raw", "--raw", "40,36,50,uint8", "--spacing", "1",
                    "--labels", "-q", "-o", "labels.8vo")
        jobs = [(3, "tree"), (3, "mesh"), (1, "tree")]
        forms = ([], ["--list"], ["--list", "--notation", "linear"], ["--counts"],
                 ["--label", "2", "--list"], ["--range", "1:1", "--list"],
                 ["--level", "1", "--list"], ["--neighbors", "-"], ["--json"])
        for number, options in enumerate(forms):
            expected = self.expect(0, "codes", "labels.8vo", *options).stdout
            # What is printed depends on options, the octree on ranks and plan: all jobs make the
            # list of leaves, and each form is printed by one of them.
            is_list = options == ["--list"]
            for ranks, plan in jobs if NIGHTLY or is_list else [jobs[number % len(jobs)]]:
                job = self.start(ranks, "codes", "labels.8vo", *options, "--gather", plan)
                out, error = job.communicate()
                self.assertEqual(job.returncode, 0, error)
                self.assertEqual(out, expected, (options, ranks, plan))
        job = self.start(3, "codes", "labels.8vo", "--report=json")
        report = json.loads(job.communicate()[0])["report"]
        self.assertEqual(sum(share["planes"] for share in report["shares"]), size[2])
        self.assertGreater(report["codes_sent"], 0)


class PicturesByRanks(ByRanks):
    def test_pictures_are_those_of_one_process(self):
        self.expect(0, "phantom", "--size", "140,130,100", "--noise", "5", "-o", "head.mhd")
        self.expect(0, "build", "head.mhd", "--preset", "fast", "-q", "-o", "head.8vo")
        view = ("--azimuth", "150", "--size", "160x120", "--transfer", "bone")
        self.expect(0, "render", "head.8vo", "--mode", "volume", *view, "-o", "one.png")
        for ranks in (1, 3):
            job = self.start(ranks, "render", "head.8vo", *view, "--force", "--json", "-o",
                             "ranks.png")
            out, error = job.communicate()
            self.assertEqual(job.returncode, 0, error)
            report = json.loads(out)
            self.assertEqual(report["ranks"], ranks)
            self.assertGreater(report["fps"], 0)
            one, parts = ([channel for row in render_test.read_png(self.folder / name)
                           for pixel in row for channel in pixel]
                          for name in ("one.png", "ranks.png"))
            self.assertGreater(max(one), 100)
            self.assertLessEqual(max(abs(a - b) for a, b in zip(one, parts)), 1)

    def test_meshes_are_in_the_picture_of_ranks_as_in_that_of_one_process(self):
        self.expect(0, "phantom", "--size", "140,130,100", "-o", "head.mhd")
        self.expect(0, "build", "head.mhd", "--preset", "fast", "-q", "-o", "head.8vo")
        # A bar from one side of the head to the other, which sticks out of the volume.
        (self.folder / "bar.obj").write_text(
            "v -40 60 40\nv 180 66 52\nv 180 66 60\nv -40 60 48\n"
            "v -40 72 44\nv 180 78 56\nf 1 2 3 4\nf 4 3 6 5\nf 5 6 2 1\n")
        view = ("--azimuth", "200", "--size", "160x120", "--transfer", "skin",
                "--mesh", "bar.obj=red:0.7", "--mark", "70,65,95=top")
        self.expect(0, "render", "head.8vo", "--mode", "volume", *view, "-o", "one.png")
        job = self.start(3, "render", "head.8vo", *view, "-o", "ranks.png")
        _, error = job.communicate()
        self.assertEqual(job.returncode, 0, error)
        self.assertEqual(error.count("does not say how the patient lies"), 1, error)
        one, parts = (render_test.read_png(self.folder / name) for name in
                      ("one.png", "ranks.png"))
        red = [pixel for row in one for pixel in row if pixel[0] > 100 > 2 * pixel[1]]
        self.assertGreater(len(red), 100)
        self.assertLessEqual(max(abs(a - b) for row, other in zip(one, parts)
                                 for pixel, at in zip(row, other)
                                 for a, b in zip(pixel, at)), 1)

    def test_what_ranks_do_not_draw_is_rejected(self):
        self.expect(0, "phantom", "--size", "20,20,20", "-o", "head.mhd")
        self.expect(0, "build", "head.mhd", "-q", "-o", "head.8vo")
        job = self.start(2, "render", "head.8vo", "--mode", "cubes", "-o", "cubes.png")
        _, error = job.communicate()
        self.assertEqual(job.returncode, 2, error)
        self.assertIn("ranks draw modes volume", error)
        self.assertFalse((self.folder / "cubes.png").exists())


class LostRanks(ByRanks):
    def wait_for_work(self, job, ranks, for_a_group=False):
        """Until the ranks write into the growing file, or have put the first group into it."""
        awaited = self.folder / (".scan.8vo.ranks-0.journal" if for_a_group else ".scan.8vo.ranks")
        longer_than = LONGEST_HEAD if for_a_group else -1
        while job.poll() is None:
            found = ranks_of(job)
            if len(found) == ranks and awaited.exists():
                if awaited.stat().st_size > longer_than:
                    return found
            time.sleep(0.01)
        if for_a_group and job.returncode == 0:
            return {}
        self.fail("the job ended before a rank could be lost: " + job.communicate()[1])

    def lose(self, ranks, rank, how, *options, source=SOURCE, after=0.0, for_a_group=False):
        """A job of which one rank gets a signal; returns what it said."""
        job = self.start(ranks, "build", *source, *options, "-o", "scan.8vo")
        found = self.wait_for_work(job, ranks, for_a_group)
        time.sleep(after)
        try:
            os.kill(found[rank], how)
        except (KeyError, ProcessLookupError):
            pass
        lost = time.monotonic()
        out, error = job.communicate()
        if (self.folder / "scan.8vo").exists():
            return None  # it was done before
        self.assertNotEqual(job.returncode, 0, error)
        self.expect_no_orphans(found, lost)
        return out + error

    def expect_no_orphans(self, found, lost):
        while any(is_running(process) for process in found.values()):
            self.assertLess(time.monotonic() - lost, SECONDS_TO_END, "an orphan")
            time.sleep(0.05)
        self.assertLess(time.monotonic() - lost, SECONDS_TO_END)

    def test_a_killed_rank_ends_the_job_and_the_next_one_goes_on(self):
        expected = self.expected()
        numbers = random.Random(3)
        resumed = lost_late = 0
        for number in range(KILLED_JOBS):
            ranks = numbers.choice((2, 3, 4))
            is_late = number % 2 == 0
            self.lose(ranks, numbers.randrange(ranks), signal.SIGKILL,
                      after=numbers.random() * (0.1 if is_late else 1.5), for_a_group=is_late)
            if not (self.folder / "scan.8vo").exists():
                _, error = self.build(numbers.choice((1, 3)))
                resumed += "continued behind plane" in error
                lost_late += is_late
            self.assertEqual(self.bytes_built(), expected)
            self.assertEqual(self.left(), [])
        # A rank that is lost while its record is being written leaves no whole group.
        self.assertGreaterEqual(2 * resumed, lost_late)
        print(f"goal R2: {KILLED_JOBS} of {KILLED_JOBS} jobs that lost a rank, "
              f"{resumed} continued")

    def test_a_rank_that_hangs_ends_the_job(self):
        said = self.lose(3, 1, signal.SIGSTOP, "--silent-limit", "3", source=SLOW_SOURCE)
        self.assertIn("rank 1 has been silent for 3 s", said)

    def test_a_rank_whose_work_stands_still_ends_the_job(self):
        # Training on a group takes several times the time between two looks at the work.
        job = self.start(2, "build", *SLOW_SOURCE, "--stall-limit", "0.01", "-o", "scan.8vo")
        _, error = job.communicate()
        self.assertNotEqual(job.returncode, 0, error)
        self.assertRegex(error, r"the work of rank [01] has stood still for \d+ s; the job ends")
        self.assertFalse((self.folder / "scan.8vo").exists())

    def test_without_a_limit_work_may_stand_still(self):
        expected = self.expected()
        self.build(2, "--stall-limit", "0")
        self.assertEqual(self.bytes_built(), expected)

    def test_a_signal_ends_the_job(self):
        job = self.start(2, "build", *SLOW_SOURCE, "-o", "scan.8vo")
        found = self.wait_for_work(job, 2)
        ended = time.monotonic()
        job.send_signal(signal.SIGTERM)
        job.communicate()
        self.assertNotEqual(job.returncode, 0)
        self.assertFalse((self.folder / "scan.8vo").exists())
        self.expect_no_orphans(found, ended)


if __name__ == "__main__":
    OCTAVO_MPI = os.path.abspath(sys.argv.pop(2))
    cli_test.OCTAVO = os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
