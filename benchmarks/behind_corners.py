#!/usr/bin/python3
"""A robot that vanishes behind corners of which the site file says nothing: the hall of Li 2014 without its walls and without the robot's wheels, seen by all
three cameras and by each alone: `simulate`, `replay` and `evaluate`.

    benchmarks/behind_corners.py PROGRAM SEED...

Needs python3-yaml.
"""
import argparse
import json
import pathlib
import subprocess
import tempfile

import yaml


def run(*command):
    subprocess.run([str(part) for part in command], check=True, capture_output=True)


def session(program, folder, seed):
    """Its site, without walls and wheels."""
    run(program, "simulate", "li2014", "-o", folder, "--seed", seed, "--duration", 30)
    site = yaml.safe_load((folder / "site.yaml").read_text())
    del site["site"]["walls"]
    for robot in site["robots"].values():
        robot.pop("odometry", None)
    (folder / "odometry.csv").unlink(missing_ok=True)
    return site


def figures(program, folder, site):
    """What `evaluate` says of the fixes that `replay` gives."""
    (folder / "site.yaml").write_text(yaml.safe_dump(site, sort_keys=False))
    run(program, "replay", folder / "site.yaml", "--fixes", folder / "fixes.jsonl")
    run(program, "evaluate", folder / "fixes.jsonl", "--truth", folder / "truth.csv", "--symmetry-deg", 90, "--json", folder / "figures.json")
    all_fixes = json.loads((folder / "figures.json").read_text())["all"]
    return all_fixes["position"], all_fixes["nees"]["mean"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("seeds", nargs="+", type=int)
    given = parser.parse_args()
    print(f"{'seed':>6} {'cameras':>18} {'fixes':>6} {'median mm':>10} {'largest mm':>11} {'NEES per unknown':>17}")
    for seed in given.seeds:
        with tempfile.TemporaryDirectory() as made:
            folder = pathlib.Path(made) / "hall"
            site = session(given.program, folder, seed)
            cameras = site["cameras"]
            for used in (list(cameras), *([name] for name in cameras)):
                site["cameras"] = {name: cameras[name] for name in used}
                position, nees = figures(given.program, folder, site)
                print(f"{seed:>6} {' '.join(used):>18} {position['count']:>6} {1e3 * position['median']:>10.1f} {1e3 * position['max']:>11.0f} {nees:>17.2f}", flush=True)


if __name__ == "__main__":
    main()
