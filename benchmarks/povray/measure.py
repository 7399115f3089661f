"""What the program makes of the worlds: errors, honesty, false fixes, and a sheet of the worst pictures."""
import csv
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from . import sheet

beyond = 3.0        # stated deviations
wrong_place = 0.5   # m: a fix this far from every robot's truth is of something else


def call(program, *words):
    """Standard output of the program, or nothing where it refuses."""
    done = subprocess.run([program, *map(str, words)], capture_output=True, text=True)
    if done.returncode:
        print("   refused:", done.stderr.strip()[-300:], file=sys.stderr)
    return done.stdout if done.returncode == 0 else ""


def error_of(fix, x, y):
    return np.array([fix["x"] - x, fix["y"] - y])


def nees(fix, error):
    """Per unknown, over x and y."""
    return float(error @ np.linalg.solve(np.array(fix["covariance"]).reshape(3, 3)[:2, :2], error)) / 2


def yaw_error(fix, yaw):
    """deg; a box looks the same after half a turn, so only the best of both is judged. Nothing where either is unknown."""
    if yaw is None or fix.get("yaw") is None:
        return None
    return math.degrees(abs((fix["yaw"] - yaw + math.pi / 2) % math.pi - math.pi / 2))


def summary(errors, consistency, turns=()):
    if not errors:
        return ""
    text = (f"mean {100 * np.mean(errors):6.1f}, median {100 * np.median(errors):5.1f}, p95 {100 * np.percentile(errors, 95):6.1f} cm; "
            f"NEES per unknown {np.mean(consistency):6.2f}, {sum(2 * c > beyond**2 for c in consistency)} beyond three deviations")
    turns = [t for t in turns if t is not None]
    return text + (f"; yaw median {np.median(turns):.1f} deg" if turns else "")


def judge_world(program, folder, site):
    """One row per picture: the truth, what was found, and how far off."""
    truth = json.load(open(folder / "truth.json"))
    lines = call(program, "fix", folder / site, "--camera", "cam", *[folder / row["image"] for row in truth]).splitlines()
    fixes = [json.loads(line) for line in lines]
    for row in truth:
        mine = [f for f in fixes if f.get("image") == str(folder / row["image"])]
        found = [f for f in mine if f["status"] == "ok" and f.get("robot") == "r"]
        others = [f for f in mine if f["status"] == "ok" and f.get("robot") is None]
        row.update(folder=folder, found=found, unknown=len(others), error=None)
        if found and "x" in row:
            error = error_of(found[0], row["x"], row["y"])
            row.update(error=float(np.linalg.norm(error)), nees=nees(found[0], error), turn=yaw_error(found[0], row.get("yaw")))
    return truth


def report_pictures(rows, name):
    present = [r for r in rows if "x" in r]
    groups = [(kind, [r for r in present if r["kind"] == kind]) for kind in ("plain", "light", "hidden")] + [("all", present)]
    for kind, those in groups:
        found = [r for r in those if r["found"]]
        print(f"{name}, {kind:6}: found {len(found):3} of {len(those):3}; " + summary([r["error"] for r in found], [r["nees"] for r in found], [r["turn"] for r in found]))
    empty = [r for r in rows if "x" not in r]
    for what in sorted({r["what"] for r in empty}):
        those = [r for r in empty if r["what"] == what]
        print(f"{name}, without robot, {what:6}: {sum(len(r['found']) for r in those)} false fixes in {len(those)} pictures, {sum(r['unknown'] for r in those)} unknown things")
    if empty:
        print(f"{name}, without robot: {sum(len(r['found']) for r in empty) / len(empty):.2f} false fixes per picture")


def measure_pictures(program, folder, with_sheet):
    worlds = sorted(p.parent for p in folder.glob("world-*/truth.json"))
    for site, name in (("site.yaml", "bounding box"), ("site-parts.yaml", "true parts")):
        rows = [row for world in worlds for row in judge_world(program, world, site)]
        report_pictures(rows, name)
        if with_sheet:
            file = folder / ("worst.png" if site == "site.yaml" else "worst-parts.png")
            sheet.pictures(rows, site, file)
            print("   the ten worst:", file)


class Truth:
    """Poses by time, from a session's truth.csv."""

    def __init__(self, file):
        self.rows = {}
        for row in csv.DictReader(open(file)):
            yaw = float(row["yaw"]) if row["yaw"] else math.nan
            self.rows.setdefault(row["robot"], []).append([float(row["time"]), float(row["x"]), float(row["y"]), yaw])
        self.rows = {robot: np.array(rows) for robot, rows in self.rows.items()}

    def at(self, robot, time):
        """x, y, yaw; nothing outside what is known."""
        rows = self.rows[robot]
        if not rows[0, 0] - 1e-6 <= time <= rows[-1, 0] + 1e-6:
            return None
        x, y = (np.interp(time, rows[:, 0], rows[:, n]) for n in (1, 2))
        return [float(x), float(y), float(np.interp(time, rows[:, 0], np.unwrap(rows[:, 3])))]


def phase_of(time, world):
    """Which of the session's stretches: quiet, with the person, with the lamp dimmed."""
    if world["lamp"][0] <= time <= world["lamp"][1]:
        return "lamp"
    return "person" if time >= world["person_from"] else "quiet"


def judge_session(fixes, truth, world):
    rows = []
    robots = [r for r in truth.rows if not r.startswith("unknown")]
    for fix in fixes:
        if fix["status"] != "ok" or fix.get("robot") not in robots:
            continue
        pose = truth.at(fix["robot"], fix["time"])
        if pose is None:
            continue
        alike = [truth.at(r, fix["time"]) for r in robots if world["robots"][r] == world["robots"][fix["robot"]]]
        anyone = [truth.at(r, fix["time"]) for r in robots]
        error = error_of(fix, *pose[:2])
        rows.append({"fix": fix, "pose": pose, "phase": phase_of(fix["time"], world), "kind": world["robots"][fix["robot"]], "error": float(np.linalg.norm(error)),
                     "nees": nees(fix, error), "turn": yaw_error(fix, pose[2]), "like": min(np.linalg.norm(error_of(fix, *p[:2])) for p in alike if p),
                     "false": min(np.linalg.norm(error_of(fix, *p[:2])) for p in anyone if p) > wrong_place})
    return rows


def report_session(rows, fixes, truth, frames):
    groups = [("robot " + r, [x for x in rows if x["fix"]["robot"] == r]) for r in truth.rows if not r.startswith("unknown")]
    groups += [("kind " + k, [x for x in rows if x["kind"] == k]) for k in sorted({x["kind"] for x in rows})]
    groups += [(p, [x for x in rows if x["phase"] == p]) for p in ("quiet", "person", "lamp")] + [("all", rows)]
    for name, those in groups:
        if those:
            print(f"{name:13}: {len(those):5} ok; {summary([r['error'] for r in those], [r['nees'] for r in those], [r['turn'] for r in those])}; "
                  f"whichever of its like: mean {100 * np.mean([r['like'] for r in those]):.1f} cm; {sum(r['false'] for r in those)} at no robot")
    times = sorted({round(f["time"], 3) for f in fixes})
    print(f"moments in which a robot has an ok fix within 0.5 m: {coverage(rows, truth):.1f} %; false fixes per frame: {sum(r['false'] for r in rows) / max(1, frames):.2f} ({len(times)} moments)")
    strangers = [f for f in fixes if f.get("kind") == "unknown" and f["status"] == "ok" and "unknown-1" in truth.rows]
    near = [truth.at("unknown-1", f["time"]) for f in strangers]
    right = sum(bool(p) and np.linalg.norm(error_of(f, *p[:2])) < wrong_place for f, p in zip(strangers, near))
    print(f"unknown things: {len(strangers)} fixes, {right} of them the person, who was there in {len(truth.rows.get('unknown-1', []))} moments")


def coverage(rows, truth):
    good = {(r["fix"]["robot"], round(r["fix"]["time"], 1)) for r in rows if r["error"] < wrong_place}
    wanted = [(robot, round(float(t), 1)) for robot, poses in truth.rows.items() if not robot.startswith("unknown") for t in poses[:, 0]]
    return 100 * sum(w in good for w in wanted) / max(1, len(wanted))


def robots_only(truth_file, folder):
    """The truth without the person, for `evaluate`, which would count her as missing."""
    file = folder / "truth.csv"
    file.write_text("".join(line for line in open(truth_file) if ",unknown" not in line))
    return file


def measure_session(program, folder, with_sheet):
    world = json.load(open(folder / "world.json"))
    truth = Truth(folder / "truth.csv")
    with tempfile.TemporaryDirectory() as scratch:
        scratch = pathlib.Path(scratch)
        call(program, "replay", folder, "--fixes", scratch / "fixes.jsonl")
        fixes = [json.loads(line) for line in open(scratch / "fixes.jsonl")] if (scratch / "fixes.jsonl").exists() else []
        rows = judge_session(fixes, truth, world)
        report_session(rows, fixes, truth, len(list(folder.glob("frames/*/*"))))
        print(call(program, "evaluate", scratch / "fixes.jsonl", "--truth", robots_only(folder / "truth.csv", scratch)))
    if with_sheet:
        sheet.session(rows, folder, world, folder / "worst.png")
        print("the ten worst:", folder / "worst.png")


def measure(program, folder, with_sheet):
    folder = folder.resolve()
    if (folder / "truth.csv").exists():
        measure_session(program, folder, with_sheet)
    elif list(folder.glob("world-*/truth.json")):
        measure_pictures(program, folder, with_sheet)
    else:
        print(f"{folder}: neither world-*/truth.json nor truth.csv is there", file=sys.stderr)
        return 2
    return 0
