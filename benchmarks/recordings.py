#!/usr/bin/python3
"""Figures of ranges, wheels and sightings from real recordings: the program's own commands on session folders whose site files hold geometry only.

    benchmarks/recordings.py build/release/bin/roomfix                    everything
    benchmarks/recordings.py build/release/bin/roomfix plaza1 mrclam      some of it: plaza1, mrclam, labyrinth, trolley, tag_wall, util_uwb

Data lies in $ROOMFIX_DATA or in ../shared/data beside the checkout. --keep FOLDER keeps the sessions and fixes there.
"""
import csv
import json
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

arguments = sys.argv[1:]
keep = None
if "--keep" in arguments:
    place = arguments.index("--keep")
    keep = arguments[place + 1]
    del arguments[place : place + 2]
program = arguments[0] if arguments else "build/release/bin/roomfix"
wanted = arguments[1:]
data = pathlib.Path(os.environ.get("ROOMFIX_DATA", pathlib.Path(__file__).resolve().parents[2] / "shared/data"))
work = pathlib.Path(keep or tempfile.mkdtemp(prefix="roomfix-recordings-"))


def session(name, source, files, site=None):
    """A session folder that holds some of a recording's files, each under the name that the program expects."""
    folder = work / name
    folder.mkdir(parents=True, exist_ok=True)
    for target, origin in files.items():
        (folder / target).write_text(origin if "\n" in origin else (source / origin).read_text())
    (folder / "site.yaml").write_text(site or (source / "site.yaml").read_text())
    return folder


def measure(folder, note="", from_time=None, smooth=False):
    """Replays a session and prints what `evaluate` says of the fixes."""
    fixes = folder / ("smoothed.jsonl" if smooth else "fixes.jsonl")
    began = time.time()
    done = subprocess.run([program, "replay", folder, "--fixes", fixes, *(["--smooth"] if smooth else [])], capture_output=True, text=True)
    seconds = time.time() - began
    name = f"{folder.name}{' smoothed' if smooth else ''}{note}"
    if done.returncode:
        return print(f"{name}: refused: {done.stderr.strip()[-300:]}")
    evaluated = fixes
    if from_time is not None:
        evaluated = folder / "later.jsonl"
        evaluated.write_text("".join(line for line in fixes.open() if json.loads(line)["time"] >= from_time))
    report = folder / "report.json"
    done_too = subprocess.run([program, "evaluate", evaluated, "--truth", folder / "truth.csv", "--json", report], capture_output=True, text=True)
    if done_too.returncode:
        return print(f"{name}: {done.stderr.strip()[-250:]} | {done_too.stderr.strip()[-200:]}")
    r = json.loads(report.read_text())
    all_of = r["all"]
    place = all_of["position"]
    yaw = f", yaw {57.2958 * all_of['yaw']['rmse']:.1f} deg" if all_of["yaw"]["count"] else ""
    print(f"{name}: rms {100 * place['rmse']:.1f} cm, p95 {100 * place['p95']:.1f}, largest {100 * place['max']:.0f}{yaw}; "
          f"NEES per unknown {all_of['nees']['mean']:.2f}; available {100 * r['availability']:.0f} %; {seconds:.1f} s", flush=True)


def beacons_as_landmarks(site):
    return site.replace("beacons:", "landmarks:").replace("receiver: {position: [0, 0, 0], source: ranges.csv}, ", "")


def without_names(text):
    rows = list(csv.reader(text.splitlines()))
    return "\n".join(",".join([row[0], row[1], "" if i else row[2], *row[3:]]) for i, row in enumerate(rows)) + "\n"


def trolley_site(readme):
    """The geometry as the recording's README states it."""
    points = {name: [float(v) for v in xyz.split(",")] for name, xyz in re.findall(r"^([at]\d) \(([^)]*)\)", readme, re.M)}
    height = float(re.search(r"mean height of the body ([\d.]+)", readme).group(1))
    site = "roomfix: 1\nsite: {name: trolley}\nbeacons:\n"
    site += "".join(f"  {n}: {{position: {p}}}\n" for n, p in points.items() if n[0] == "a")
    receivers = ", ".join(f"{n}: {{position: [{p[0]}, {p[1]}, {round(p[2] + height, 4)}]}}" for n, p in points.items() if n[0] == "t")
    return site + f"robots:\n  trolley: {{shape: box, size: [0.5, 0.4, 1.0], receivers: {{{receivers}}}}}\n"


def plaza1():
    source = data / "plaza1"
    folder = session("plaza1", source, {n: n for n in ("ranges.csv", "odometry.csv", "truth.csv")})
    start = float((source / "ranges.csv").read_text().splitlines()[1].split(",")[0])
    for smooth in (False, True):
        measure(folder, " after the first minute", start + 60, smooth)


def mrclam():
    for n in range(1, 6):
        source = data / f"mrclam/robot{n}"
        site = (source / "site.yaml").read_text()
        bearings = (source / "bearings.csv").read_text()
        common = {n: n for n in ("odometry.csv", "truth.csv")}
        variants = {"ranges": (common | {"ranges.csv": "ranges.csv"}, site),
                    "sightings": (common | {"sightings.csv": bearings}, beacons_as_landmarks(site)),
                    "nameless": (common | {"sightings.csv": without_names(bearings)}, beacons_as_landmarks(site))}
        for kind, (files, description) in variants.items():
            folder = session(f"mrclam{n}-{kind}", source, files, description)
            for smooth in (False, True):
                measure(folder, smooth=smooth)


def labyrinth():
    folder = session("labyrinth", data / "labyrinth", {n: n for n in ("ranges.csv", "odometry.csv", "truth.csv")})
    for smooth in (False, True):
        measure(folder, smooth=smooth)


def trolley():
    source = data / "uwb-trolley"
    folder = session("trolley", source, {n: n for n in ("ranges.csv", "truth.csv")}, trolley_site((source / "README.txt").read_text()))
    start = float((source / "ranges.csv").read_text().splitlines()[1].split(",")[0])
    for smooth in (False, True):
        measure(folder, smooth=smooth)
        measure(folder, " after 30 s", start + 30, smooth)


def tag_wall():
    """One tag on a wall and a camera of which only the rough height is known, moved sideways in steps of 5 cm."""
    site = """roomfix: 1
site: {name: tag-wall}
cameras:
  eye:
    source: frames
    size: [1920, 1080]
    intrinsics: {fx: 1477.35, fy: 1473.57, cx: 961.14, cy: 492.67}
    distortion: [-0.4417, 0.2396, 0.00115, -0.00021, -0.0761]
    height: 1.2
    height_sigma: 0.3
landmarks:
  t0: {tag: 0, family: tagStandard41h12, size: 0.084, position: [0.1016, 0, 1.395], facing: wall, yaw_deg: -90}
"""
    folder = session("tag-wall", data / "tag-wall", {}, site)
    pictures = sorted((data / "tag-wall/frames").glob("*.jpg"), key=lambda p: int(p.stem.split("_")[1]))
    done = subprocess.run([program, "fix", folder / "site.yaml", "--camera", "eye", *pictures], capture_output=True, text=True)
    if done.returncode:
        return print(f"tag-wall: refused: {done.stderr.strip()[-300:]}")
    fixes = [json.loads(line) for line in done.stdout.splitlines()]
    # The file names tell centimetres; to which side the pictures tell.
    moved = [int(p.stem.split("_")[1]) / 100 for p in pictures]
    side = 1 if fixes[-1]["x"] > fixes[0]["x"] else -1
    for fix, way in zip(fixes, moved):
        x, y, z = fix["camera"]["position"]
        off = (x - side * way, y + 0.945, z - 1.225)
        nees = (off[0] ** 2 / (fix["covariance"][0] + 1e-4) + off[1] ** 2 / (fix["covariance"][4] + 1e-4)) / 2  # the tape is good to 1 cm
        step = math.hypot(x - fixes[0]["camera"]["position"][0], y - fixes[0]["camera"]["position"][1])
        print(f"tag-wall {100 * way:.0f} cm: {1000 * math.hypot(*off):.1f} mm from the tape ({', '.join(f'{1000 * o:+.1f}' for o in off)}), "
              f"step {1000 * (step - way):+.1f} mm off, NEES per unknown {nees:.2f}, {len(fix.get('hypotheses', [1]))} places")


def util_uwb():
    """Range differences of two anchors to a tag that stands still: they tell on which hyperbola it is, not where on it."""
    source = data / "util-uwb"
    for pose in sorted(source.glob("*_pose.txt")):
        name = pose.stem.removesuffix("_pose")
        points = {row[0][:3]: [float(v) for v in row[1:]] for row in csv.reader(pose.open()) if row[0].endswith("_p")}
        rows = list(csv.DictReader((source / f"{name}_data.csv").open()))
        lines = "".join(f"{100 + 0.05 * i:.3f},r1,an1,an2,{row['tdoa12']}\n" for i, row in enumerate(rows) if row["tdoa12"])
        site = "roomfix: 1\nsite: {name: util}\nbeacons:\n" + "".join(f"  {n}: {{position: {points[n]}}}\n" for n in ("an1", "an2"))
        site += f"robots:\n  r1: {{shape: cylinder, size: [0.3, 1.0], receiver: {{position: [0, 0, {points['tag'][2]}]}}}}\n"
        folder = session(f"util-{name}", source, {"ranges.csv": "time,robot,beacon_a,beacon_b,difference\n" + lines}, site)
        done = subprocess.run([program, "replay", folder, "--fixes", folder / "fixes.jsonl"], capture_output=True, text=True)
        fixes = [json.loads(line) for line in (folder / "fixes.jsonl").open()] if done.returncode == 0 else []
        placed = [math.hypot(f["x"] - points["tag"][0], f["y"] - points["tag"][1]) for f in fixes if "x" in f]
        distance = {n: math.dist(points[n], points["tag"]) for n in ("an1", "an2")}
        errors = sorted(float(row["tdoa12"]) - (distance["an2"] - distance["an1"]) for row in rows if row["tdoa12"])
        print(f"util-uwb {name}: differences off by {errors[len(errors) // 2]:+.2f} m (median), {len(placed)} places"
              + (f", the last {placed[-1]:.2f} m off" if placed else f"; {done.stderr.strip().splitlines()[-1] if done.stderr.strip() else ''}"))


for part in (plaza1, mrclam, labyrinth, trolley, tag_wall, util_uwb):
    if not wanted or part.__name__ in wanted:
        part()
