#!/usr/bin/python3
"""A robot that vanishes behind corners of which the site file says nothing: the hall of Li 2014 without its walls and without the robot's wheels, seen by all three cameras and by each alone.

    benchmarks/behind_corners.py PROGRAM SEED...
"""
import argparse
import csv
import json
import math
import pathlib
import re
import subprocess
import tempfile

import yaml


def run(*command):
    subprocess.run([str(part) for part in command], check=True, capture_output=True)


def session(program, folder, seed):
    """Its site, without walls and wheels, and where the robot is when."""
    run(program, "simulate", "li2014", "-o", folder, "--seed", seed, "--duration", 30)
    site = yaml.safe_load((folder / "site.yaml").read_text())
    del site["site"]["walls"]
    for robot in site["robots"].values():
        robot.pop("odometry", None)
    (folder / "odometry.csv").unlink(missing_ok=True)
    with open(folder / "truth.csv") as file:
        return site, {round(float(line["time"]), 3): (float(line["x"]), float(line["y"])) for line in csv.DictReader(file)}


def errors(fixes, truth):
    """Of each fix called ok: how far it is off, m, and the square of that over what it states."""
    for line in fixes.read_text().splitlines():
        fix = json.loads(line)
        place = truth.get(round(fix["time"], 3))
        if fix["status"] == "ok" and place:
            error = math.dist(place, (fix["x"], fix["y"]))
            yield error, error**2 / (fix["covariance"][0] + fix["covariance"][4])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("seeds", nargs="+", type=int)
    given = parser.parse_args()
    print(f"{'seed':>6} {'cameras':>18} {'fixes':>6} {'median mm':>10} {'largest mm':>11} {'squares over stated':>20} {'3 times off':>12}")
    for seed in given.seeds:
        with tempfile.TemporaryDirectory() as made:
            folder = pathlib.Path(made)
            site, truth = session(given.program, folder / "hall", seed)
            cameras = site["cameras"]
            for used in (list(cameras), *([name] for name in cameras)):
                site["cameras"] = {name: cameras[name] for name in used}
                (folder / "hall/site.yaml").write_text(re.sub(r"^roomfix: .*$", "roomfix: 1", yaml.safe_dump(site, sort_keys=False), flags=re.MULTILINE))
                run(given.program, "replay", folder / "hall/site.yaml", "--fixes", folder / "fixes.jsonl")
                found = sorted(errors(folder / "fixes.jsonl", truth))
                off, squares = [e for e, _ in found], [s for _, s in found]
                print(f"{seed:>6} {' '.join(used):>18} {len(off):>6} {1e3 * off[len(off) // 2]:>10.1f} {1e3 * off[-1]:>11.0f} {sum(squares) / len(squares):>20.2f} "
                      f"{sum(s > 9 for s in squares):>12}", flush=True)


if __name__ == "__main__":
    main()
