"""Pages of every kind, made by the commands."""

import os
import subprocess
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
DATASET = Path("scenarios/datasets/bench-axis")
FEELER = os.environ.get("FEELER", str(ROOT / "target/release/feeler"))
# A grid with more variants than a page draws; the runs are as short as possible.
DENSE = """scenario = "{root}/scenarios/paper/rigid.toml"

[axes]
"run.duration" = ["20 ms"]
"controllers.force.kp" = {{ linear = [0.1, 1.0], points = 210 }}
"contacts.tool.stiffness" = {{ log = ["10 kN/m", "1 MN/m"], points = 100 }}
"""


def passed(began=time.monotonic()):
    return f"({time.monotonic() - began:.0f} s since the start)"


def feeler(*words, cwd=ROOT):
    done = subprocess.run([FEELER, *map(str, words)], cwd=cwd, capture_output=True, text=True)
    if done.returncode:
        raise AssertionError(f"feeler {' '.join(map(str, words))}: {done.stderr}")


def pages(out):
    """A page of each kind, made by its command."""
    scenarios = Path("scenarios")
    out.mkdir(parents=True, exist_ok=True)
    dense = out / "dense.toml"
    dense.write_text(DENSE.format(root=ROOT))
    makes = {
        "run": ["run", scenarios / "chatter/sustained.toml", "--out"],
        "run-long": ["run", scenarios / "chatter/sustained.toml", "--set", "run.duration=10 s", "--out"],
        "run-at-rest": ["run", scenarios / "control/admittance-soft-wall.toml", "--out"],
        "run-arm": ["run", scenarios / "arms/press-low-gain.toml", "--out"],
        "why": ["why", scenarios / "chatter/sustained.toml", "--out"],
        "analyze": ["analyze", "files/src/templates/all-three.toml", "--out"],
        "analyze-servo": ["analyze", "files/src/templates/servo.toml", "--out"],
        "frf": ["frf", scenarios / "paper/flexible-multisine.toml", "--out"],
        "frf-linear": ["frf", scenarios / "paper/base-free.toml", "--out"],
        "why-settled": ["why", scenarios / "paper/all-three-contact.toml", "--out"],
        "sweep-map": ["sweep", scenarios / "sweeps/base-damping.toml", "--out"],
        "sweep-dense": ["sweep", dense, "--out"],
        "sweep-random": ["sweep", scenarios / "sweeps/tolerances.toml", "--out"],
        "bifurcation": ["sweep", scenarios / "sweeps/bifurcation.toml", "--out"],
        "compare": [
            "compare",
            scenarios / "chatter/sustained.toml",
            "--set",
            "controllers.force.kp=0.2",
            "--out",
        ],
        "compare-several": [
            "compare",
            scenarios / "chatter/settles.toml",
            scenarios / "chatter/sustained.toml",
            scenarios / "chatter/saturation.toml",
            "--out",
        ],
        "frf-records": ["frf", DATASET, "--out"],
        "compare-records": ["compare", DATASET, DATASET / "dataset.toml", "--out"],
    }
    made = Path(os.environ.get("FEELER_MADE", out / "made"))
    diagnosis, blind = made / "bench-axis/report.html", made / "blind/answers/score.html"
    if os.environ.get("FEELER_LONG"):
        if not diagnosis.exists():
            feeler("diagnose", DATASET, "--out", diagnosis.parent)
        if not blind.exists():
            feeler("blind", "make", "--cases", 2, "--seed", 7, "--out", made / "blind")
            feeler("blind", "run", made / "blind")
            feeler("blind", "score", made / "blind")
    found = {}
    for name, words in makes.items():
        if not (out / name / "report.html").exists():
            feeler(*words, out / name)
        found[name] = out / name / "report.html"
    map_of_arm = out / "reduce-map.html"
    feeler(
        "reduce",
        scenarios / "arms/six-joint.toml",
        "--at",
        "0.65,0.1,0.1",
        "--normal",
        "0,0,-1",
        "--map",
        "0.4,0.9,3,-0.4,0.4,3",
        "--map-out",
        map_of_arm,
    )
    found["reduce-map"] = map_of_arm
    for name, path in (("diagnose", diagnosis), ("blind", blind)):
        if path.exists():
            found[name] = path
        else:
            print(f"skipped: the page of {name}, since neither FEELER_MADE nor FEELER_LONG is set")
    return found


def shipped(without=("/sweeps/", "/datasets/", "/arms/", "/machines/")):
    """The shipped scenario files, except those of some folders."""
    listed = subprocess.run(
        ["git", "ls-files", "scenarios/*.toml"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.split()
    return [file for file in listed if not any(folder in file for folder in without)]
