#!/usr/bin/env python3
"""Takes the numbers of parts from the variables of schedulers.

usage: part_numbers_test.py OCTAVO [unittest arguments]
"""

import json
import os
import sys

import cli_test
import parts_test


class Scheduled(parts_test.InParts):
    def setUp(self):
        super().setUp()
        self.plan("--parts", "3")

    def made_by(self, **variables):
        said = self.part(0, "--json", **variables)
        told = json.loads(said.stdout)
        name = told["number_from"]
        self.assertIn(f"octavo: {name} is {variables[name]}", said.stderr)
        return name, [part["part"] for part in told["parts"]]

    def test_the_number_of_a_part_comes_from_the_scheduler(self):
        self.part(0, "--parts", "0-2", "-q")  # what is there is kept
        slurm = {"SLURM_ARRAY_TASK_MIN": "1", "SLURM_ARRAY_TASK_MAX": "3"}
        ranks = {"OMPI_COMM_WORLD_SIZE": "2"}
        for variables, name, parts in [
            ({"SLURM_ARRAY_TASK_ID": "2"}, "SLURM_ARRAY_TASK_ID", [2]),
            ({"SLURM_ARRAY_TASK_ID": "3", **slurm}, "SLURM_ARRAY_TASK_ID", [2]),
            ({"SLURM_ARRAY_TASK_ID": "1", "SLURM_ARRAY_TASK_MIN": "1",
              "SLURM_ARRAY_TASK_MAX": "2"}, "SLURM_ARRAY_TASK_ID", [1]),
            ({"SLURM_ARRAY_TASK_ID": "9", "SLURM_ARRAY_TASK_MIN": "0",
              "SLURM_ARRAY_TASK_MAX": "9"}, "SLURM_ARRAY_TASK_ID", []),
            ({"SLURM_ARRAY_TASK_ID": "6", "SLURM_ARRAY_TASK_MIN": "2",
              "SLURM_ARRAY_TASK_MAX": "6", "SLURM_ARRAY_TASK_STEP": "2",
              "SLURM_ARRAY_TASK_COUNT": "3"}, "SLURM_ARRAY_TASK_ID", [2]),
            ({"SLURM_ARRAY_TASK_ID": "2", "SLURM_ARRAY_TASK_MIN": "0",
              "SLURM_ARRAY_TASK_MAX": "2", "SLURM_ARRAY_TASK_STEP": "2",
              "SLURM_ARRAY_TASK_COUNT": "2"}, "SLURM_ARRAY_TASK_ID", [2]),
            ({"SGE_TASK_ID": "5", "SGE_TASK_FIRST": "1", "SGE_TASK_LAST": "5",
              "SGE_TASK_STEPSIZE": "2"}, "SGE_TASK_ID", [2]),
            ({"SLURM_ARRAY_TASK_ID": "", "PBS_ARRAY_INDEX": "1"}, "PBS_ARRAY_INDEX", [1]),
            ({"PBS_ARRAY_INDEX": "1"}, "PBS_ARRAY_INDEX", [1]),
            ({"LSB_JOBINDEX": "1"}, "LSB_JOBINDEX", [0]),
            ({"SGE_TASK_ID": "3"}, "SGE_TASK_ID", [2]),
            ({"AWS_BATCH_JOB_ARRAY_INDEX": "0"}, "AWS_BATCH_JOB_ARRAY_INDEX", [0]),
            ({"JOB_COMPLETION_INDEX": "2"}, "JOB_COMPLETION_INDEX", [2]),
            ({"OMPI_COMM_WORLD_RANK": "0", **ranks}, "OMPI_COMM_WORLD_RANK", [0, 2]),
            ({"OMPI_COMM_WORLD_RANK": "1", "SLURM_PROCID": "0", "SLURM_NTASKS": "1", **ranks},
             "OMPI_COMM_WORLD_RANK", [1]),
            ({"PMIX_RANK": "1", "SLURM_STEP_NUM_TASKS": "2"}, "PMIX_RANK", [1]),
            ({"SLURM_PROCID": "0", "SLURM_STEP_NUM_TASKS": "3"}, "SLURM_PROCID", [0]),
            ({"SLURM_PROCID": "7", "SLURM_STEP_NUM_TASKS": "8"}, "SLURM_PROCID", []),
            ({"PBS_ARRAY_INDEX": "3"}, "PBS_ARRAY_INDEX", []),
            ({"LSB_JOBINDEX": "4"}, "LSB_JOBINDEX", []),
            ({"AWS_BATCH_JOB_ARRAY_INDEX": "3"}, "AWS_BATCH_JOB_ARRAY_INDEX", []),
            ({"JOB_COMPLETION_INDEX": "9"}, "JOB_COMPLETION_INDEX", []),
            ({"LSB_JOBINDEX": "0", "SGE_TASK_ID": "undefined", "PBS_ARRAY_INDEX": "2"},
             "PBS_ARRAY_INDEX", [2]),
        ]:
            with self.subTest(variables):
                self.assertEqual(self.made_by(**variables), (name, parts))

    def test_a_number_without_a_part_is_rejected(self):
        for variables, words in [
            ({}, ["which of 3 parts", "--part"]),
            ({"SLURM_ARRAY_TASK_ID": "3"}, ["SLURM_ARRAY_TASK_ID is 3", "parts 0 to 2"]),
            ({"SLURM_PROCID": "0", "SLURM_NTASKS": "3"}, ["which of 3 parts", "--part"]),
            ({"SGE_TASK_ID": "4"}, ["SGE_TASK_ID is 4", "from 1"]),
            ({"LSB_JOBINDEX": "-4"}, ["'-4'"]),
            ({"PBS_ARRAY_INDEX": "two"}, ["'two'"]),
            ({"PMIX_RANK": "1"}, ["how many ranks"]),
            ({"OMPI_COMM_WORLD_RANK": "3", "OMPI_COMM_WORLD_SIZE": "3"},
             ["OMPI_COMM_WORLD_RANK is 3, but OMPI_COMM_WORLD_SIZE says 3"]),
            ({"SLURM_ARRAY_TASK_ID": "9", "SLURM_ARRAY_TASK_MIN": "1",
              "SLURM_ARRAY_TASK_MAX": "9", "SLURM_ARRAY_TASK_COUNT": "3"},
             ["SLURM_ARRAY_TASK_ID is 9", "parts 0 to 2"]),
        ]:
            with self.subTest(variables):
                said = self.part(2, **variables)
                for word in words:
                    self.assertIn(word, said.stderr)
        self.assertEqual(self.files(), ["scan.plan", "scan.raw"])

    def test_one_number_is_asked_for_where_one_part_is(self):
        for verb in ["part"], ["join", "--step", "copy", "-o", "scan.8vo"]:
            for number in "1.5", "-1", "0,1", "two":
                with self.subTest((verb[0], number)):
                    said = self.expect(2, *verb, "scan.plan", f"--part={number}")
                    self.assertIn(f"--part: {number}; expected a whole number of 0 or more",
                                  said.stderr)

    def test_a_number_that_is_given_counts_more_than_a_scheduler(self):
        told = json.loads(self.part(0, "--part", "1", "--json", SLURM_ARRAY_TASK_ID="2").stdout)
        self.assertIsNone(told["number_from"])
        self.assertEqual(told["parts"][0]["part"], 1)


if __name__ == "__main__":
    cli_test.OCTAVO = os.path.abspath(sys.argv.pop(1))
    cli_test.unittest.main()
