"""Builds and runs every peer, then prints the table of ratios and draws the work-precision diagram.

Other programs may hold the processors. Short runs dodge them in the median. Long ones would look slower than
they are, so peers with long runs count processor time.
"""

import argparse
import csv
import importlib.util
import io
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import time

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402 (the backend comes first)

from models import PEAK_N  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
# Accuracy of the reference itself; smaller errors are shown as this value.
REFERENCE_ERROR = 1e-11
SIMULATOR, YARDSTICK = ("feeler", "exact"), ("hand-written Rust", "RK4 with events")
MACHINES = ("M1", "M2", "M4", "loop")
TURNS = 3


def run(*command, **options):
    return subprocess.run(
        [str(part) for part in command], check=True, capture_output=True, text=True, cwd=ROOT, **options
    ).stdout


def cargo_target():
    return pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))


def simulator(into):
    """The simulator as anybody builds it, and the hand-written loops for this processor.

    They run in turns, since the machine may be busy.
    """
    run("cargo", "build", "--release", "-p", "feeler-benches", "--example", "work_precision")
    run(
        "rustc",
        "--edition=2024",
        "-Copt-level=3",
        "-Ctarget-cpu=native",
        HERE / "hand_written.rs",
        "-o",
        into / "hand_written",
    )
    return "".join(
        run(into / "hand_written") + run(cargo_target() / "release/examples/work_precision")
        for _ in range(TURNS)
    )


def build_mujoco(into):
    package = pathlib.Path(importlib.util.find_spec("mujoco").origin).parent
    library = next(package.glob("libmujoco.so*"))
    program = into / "mujoco_loop"
    run(
        "cc",
        "-O3",
        "-march=native",
        "-I",
        package / "include",
        HERE / "mujoco_loop.c",
        "-o",
        program,
        library,
        f"-Wl,-rpath,{package}",
        "-lm",
        "-lpthread",
    )
    return program


def mujoco(into):
    return run(build_mujoco(into), "rows")


def rapier(into):
    run(
        "cargo",
        "build",
        "--release",
        "--locked",
        "--manifest-path",
        HERE / "rapier/Cargo.toml",
        "--target-dir",
        into / "rapier",
    )
    return run(into / "rapier/release/rapier-loop")


def drake(_):
    return run(sys.executable, HERE / "drake_rows.py")


def scipy(_):
    return run(sys.executable, HERE / "scipy_rows.py")


def mujoco_map(into):
    """Seconds of the 64 x 64 map of M2 on two free processors.

    A sixteenth of it is run: every variant costs the same.
    """
    share = 16
    return share * float(run(build_mujoco(into), "map", 64 * 64 // share, 2))


def simulator_map(into):
    """Seconds of the same map by this simulator, with all measures, Parquet and page: the median of three."""
    run("cargo", "build", "--release", "-p", "feeler")
    seconds = []
    for _ in range(TURNS):
        shutil.rmtree(into / "map", ignore_errors=True)
        start = time.monotonic()
        run(
            cargo_target() / "release/feeler",
            "sweep",
            "scenarios/sweeps/flexible-map.toml",
            "--out",
            into / "map",
        )
        seconds.append(time.monotonic() - start)
    return statistics.median(seconds)


PEERS = {"simulator": simulator, "mujoco": mujoco, "rapier": rapier, "drake": drake, "scipy": scipy}


def read(text):
    """Rows of the common CSV; of a row that comes several times, the median time."""
    walls = {}
    for *key, wall, peak in csv.reader(io.StringIO(text)):
        walls.setdefault((*key, peak), []).append(float(wall))
    rows = []
    for (who, method, machine, step, peak), times in walls.items():
        error = max(REFERENCE_ERROR, abs(float(peak) / PEAK_N[machine] - 1.0))
        step_s = float(step) if step else None
        rows.append(
            {
                "who": who,
                "method": method,
                "machine": machine,
                "step_s": step_s,
                "wall_s": statistics.median(times),
                "error": error,
            }
        )
    return rows


def table(rows):
    """One line for each method at 0.1 ms, or at a tolerance.

    It says how many times longer the method takes than the exact integrator, and its error.
    """
    ours = {row["machine"]: row for row in rows if (row["who"], row["method"]) == SIMULATOR}
    yardstick = {
        row["machine"]: row
        for row in rows
        if (row["who"], row["method"]) == YARDSTICK and row["step_s"] == 1e-4
    }
    lines = [
        "| who | method, 0.1 ms | simulated s per s: "
        + " | ".join(MACHINES)
        + " | exact is faster: "
        + " | ".join(MACHINES)
        + " | peak force error: "
        + " | ".join(MACHINES)
        + " |"
    ]
    lines.append("|" + "---|" * (2 + 3 * len(MACHINES)))
    for who, method in dict.fromkeys((row["who"], row["method"]) for row in rows):
        found = {
            row["machine"]: row
            for row in rows
            if (row["who"], row["method"]) == (who, method)
            and (row["step_s"] is None or abs(row["step_s"] - 1e-4) < 1e-12)
        }
        own = "own contact" in method
        # Not every program has the whole force loop.
        cells = [f"{1 / found[m]['wall_s']:.3g}" if m in found else "" for m in MACHINES]
        cells += [f"{found[m]['wall_s'] / ours[m]['wall_s']:.2f}" if m in found else "" for m in MACHINES]
        cells += [
            "" if m not in found else "another problem" if own else f"{found[m]['error']:.0e}"
            for m in MACHINES
        ]
        lines.append(f"| {who} | {method} | " + " | ".join(cells) + " |")
    lines.append("")
    for m in MACHINES:
        gain = yardstick[m]["error"] / ours[m]["error"]
        lines.append(f"{m}: peak force error {gain:.1e} times smaller than the hand-written RK4 with events.")
    return "\n".join(lines)


def series(row):
    """Which line of the diagram a row belongs to: tolerances of one method are points of one line."""
    return row["who"], row["method"].split(",")[0]


def diagram(rows, path):
    """Error of the peak force against time for a simulated second."""
    plt.rcParams.update(
        {
            "svg.hashsalt": "work-precision",
            "svg.fonttype": "none",
            "font.family": "sans-serif",
            "font.size": 9,
        }
    )
    figure, axes = plt.subplots(1, len(MACHINES), figsize=(14, 5), sharey=True, layout="constrained")
    rows = [row for row in rows if "own contact" not in row["method"] and "recorded" not in row["method"]]
    kinds = list(dict.fromkeys(map(series, rows)))
    people = list(dict.fromkeys(who for who, _ in kinds))
    marks = "osD^v<>"
    for axis, machine in zip(axes, MACHINES):
        for who, method in kinds:
            points = sorted(
                (row["wall_s"], row["error"])
                for row in rows
                if row["machine"] == machine and series(row) == (who, method)
            )
            if not points:
                continue
            which = [m for w, m in kinds if w == who].index(method)
            axis.loglog(
                *zip(*points),
                marks[which],
                linestyle="-",
                color=f"C{people.index(who)}",
                label=f"{who}, {method}",
                markersize=5,
                linewidth=1,
            )
        axis.set_title(machine)
        axis.set_xlabel("seconds per simulated second")
        axis.grid(True, which="major", color="#dddddd")
    axes[0].set_ylabel("relative error of the peak contact force")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, fontsize=8)
    figure.savefig(path, metadata={"Date": None})


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--into", type=pathlib.Path, required=True, help="folder for what is built and drawn")
    parser.add_argument("--without", default="", help=f"peers to leave out, of {', '.join(PEERS)}")
    arguments = parser.parse_args()
    skipped = [name for name in arguments.without.split(",") if name]
    texts = []
    for name, measure in PEERS.items():
        if name in skipped:
            continue
        try:
            texts.append(measure(arguments.into))
        except (subprocess.CalledProcessError, FileNotFoundError) as problem:
            print(f"{name} is left out: {problem}\n{getattr(problem, 'stderr', '')}", file=sys.stderr)
            if name == "simulator":
                raise
    (arguments.into / "rows.csv").write_text("".join(texts))
    rows = read("".join(texts))
    report = table(rows)
    if "mujoco" not in skipped:
        theirs, ours = mujoco_map(arguments.into), simulator_map(arguments.into)
        report += "\n\n64 x 64 map of M2, 2 s each, two processors: "
        report += f"MuJoCo's C loop, the runs alone, {theirs:.1f} s;"
        report += f" `feeler sweep`, with measures, Parquet and page, {ours:.2f} s:"
        report += f" {theirs / ours:.1f} times as fast."
    (arguments.into / "table.md").write_text(report + "\n")
    diagram(rows, arguments.into / "work-precision.svg")
    print(report)


main()
