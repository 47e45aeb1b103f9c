"""What the programs that draw bench/results share: how pictures look, rows in, SVG out."""

import csv
from pathlib import Path

try:
    import matplotlib
except ImportError:
    from peer_runs import enter_environment
    enter_environment()

matplotlib.use("agg")
import matplotlib.pyplot as plt

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "bench" / "results"
DARK, QUIET = "#222222", "#666666"

plt.rcParams.update({
    "svg.hashsalt": "octavo", "svg.fonttype": "none", "font.size": 10,
    "font.family": "DejaVu Sans",
    "axes.spines.top": False, "axes.spines.right": False, "axes.edgecolor": "#777777",
    "axes.grid": True, "grid.color": "#e4e4e4", "axes.axisbelow": True, "legend.frameon": False})


def rows_of(name):
    path = RESULTS / name
    if not path.exists():
        return []
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def save(figure, folder, name):
    """Writes an SVG: the same rows give the same bytes."""
    path = folder / name
    figure.savefig(path, metadata={"Date": None, "Creator": None}, facecolor="white")
    text = path.read_text().replace("'DejaVu Sans'", "'DejaVu Sans', Verdana, Arial, sans-serif")
    lines = [line.rstrip() for line in text.splitlines()]
    path.write_text("\n".join(lines) + "\n")
    print(path)
