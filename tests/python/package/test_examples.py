"""The examples in Python, run as a newcomer would."""

import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest

import octavo

EXAMPLES = pathlib.Path(__file__).parents[3] / "examples/python"


def run(name, *words):
    done = subprocess.run([sys.executable, EXAMPLES / name, *map(str, words)],
                          capture_output=True, text=True, env=os.environ, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def shell():
    """A hollow ball of 1000 in air of -1000, with two pores in its wall."""
    z, y, x = np.ogrid[-30:30, -32:32, -34:34]
    distance = np.sqrt(z * z + y * y + x * x)
    voxels = np.where((distance < 28) & (distance > 16), 1000, -1000).astype(np.int16)
    voxels[30 + 21:30 + 24, 32:34, 34:38] = -1000
    voxels[8:10, 32:33, 34:37] = -1000
    return voxels


def test_a_head_becomes_a_file_for_printers(shell, tmp_path):
    octavo.build(shell, tmp_path / "head.8vo", spacing=(1, 1, 1), unit="HU").close()
    said = run("skull_to_stl.py", tmp_path / "head.8vo", tmp_path / "skull.stl")
    assert "closed: True" in said and "mean 1000" in said
    count = int.from_bytes((tmp_path / "skull.stl").read_bytes()[80:84], "little")
    assert f"{count:,} of" in said and count > 100


def test_pores_are_counted_and_listed(shell, tmp_path):
    octavo.build(shell, tmp_path / "foam.8vo", spacing=(1, 1, 1)).close()
    said = run("pore_statistics.py", tmp_path / "foam.8vo", 0, tmp_path / "pores.csv")
    z, y, x = np.ogrid[-30:30, -32:32, -34:34]
    cavity = int((z * z + y * y + x * x <= 16 * 16).sum())
    assert said.startswith("3 pores") and "the largest has" in said
    rows = (tmp_path / "pores.csv").read_text().splitlines()
    assert rows[0].startswith("label,name,voxels") and len(rows) == 4
    voxels = [int(row.split(",")[2]) for row in rows[1:]]
    assert voxels == [cavity, 24, 6]


def test_means_of_a_folder_are_those_of_numpy(shell, tmp_path):
    pytest.importorskip("dask.array")
    for name, factor in (("a", 1), ("b", 2)):
        octavo.build(shell // factor, tmp_path / f"{name}.8vo", slope=2).close()
    lines = run("folder_means.py", tmp_path).splitlines()
    for line, factor in zip(lines, (1, 2)):
        assert float(line.split()[1]) == pytest.approx((shell // factor).mean() * 2, abs=1e-3)
