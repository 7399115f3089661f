#!/usr/bin/python3
"""Figures of fixed cameras on pictures that nobody here rendered, from the program's own commands on plain site files.

    benchmarks/real_scenes.py build/release/bin/roomfix              everything
    benchmarks/real_scenes.py build/release/bin/roomfix lcav unitn   some of it: lcav, unitn, aisle

Data lies in $ROOMFIX_DATA or in ../shared/data beside the checkout. Needs python3-numpy, python3-opencv and python3-yaml.
"""
import csv
import json
import math
import os
import pathlib
import random
import subprocess
import sys
import tempfile

import cv2
import numpy as np
import yaml

program = sys.argv[1] if len(sys.argv) > 1 else "build/release/bin/roomfix"
data = pathlib.Path(os.environ.get("ROOMFIX_DATA", pathlib.Path(__file__).resolve().parents[2] / "shared/data"))
work = pathlib.Path(tempfile.mkdtemp(prefix="roomfix-scenes-"))


def call(*arguments):
    """Standard output of the program, or nothing where it refuses."""
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode:
        print("   refused:", done.stderr.strip()[-300:])
    return done.stdout if done.returncode == 0 else None


def fixes(*arguments):
    return [json.loads(line) for line in (call("fix", *arguments) or "").splitlines()]


def rows(file):
    return list(csv.DictReader(open(file)))


def site_with(source, robot, name):
    """The site file with its robots replaced, beside the original so that its paths hold."""
    text = source.read_text().split("robots:")[0].replace("frames", str(source.parent / "frames"))
    file = work / name
    file.write_text(text + "robots:\n  " + robot + "\n")
    return file


def nees(error, covariance, truth_sigma):
    return error @ np.linalg.solve(covariance + truth_sigma**2 * np.eye(len(error)), error) / len(error)


def report(what, errors, consistency, found, of):
    if not errors:
        print(f"{what}: found {found} of {of}")
        return
    print(f"{what}: found {found} of {of}; mean {100 * np.mean(errors):.1f}, median {100 * np.median(errors):.1f}, largest {100 * max(errors):.1f} cm; "
          f"NEES per unknown {np.mean(consistency):.2f}, largest {max(consistency):.1f}")


def lcav():
    folder = data / "lcav"
    truth = {row["time"]: np.array([float(row["x"]), float(row["y"])]) for row in rows(folder / "truth.csv")}
    bodies = {"cylinder": "robot: {shape: cylinder, size: [0.45, 1.75]}"}
    if call("calibrate", "robot", folder, "-o", work / "lcav.body"):
        bodies["learned"] = f"robot: {{model: {work}/lcav.body}}"
    for name, robot in bodies.items():
        site = site_with(folder / "site.yaml", robot, f"lcav-{name}.yaml")
        errors, consistency, beyond = [], [], 0
        for camera in ("cam139", "cam141", "cam143", "cam145"):
            frames = folder / "frames" / camera
            for fix in fixes(site, "--camera", camera, *[frames / f"{t}000000000.png" for t in truth], "--background", frames):
                if fix["status"] != "ok":
                    continue
                error = np.array([fix["x"], fix["y"]]) - truth[str(int(pathlib.Path(fix["image"]).stem) // 10**9)]
                covariance = np.array(fix["covariance"]).reshape(3, 3)[:2, :2]
                errors.append(np.linalg.norm(error))
                consistency.append(nees(error, covariance, 0.02))
                beyond += 2 * consistency[-1] > 9
        report(f"lcav, {name}, single views", errors, consistency, len(errors), 20)
        print(f"   beyond three deviations: {beyond}")
        call("replay", site, "--fixes", work / "lcav.jsonl")
        errors, consistency = [], []
        for line in open(work / "lcav.jsonl"):
            fix = json.loads(line)
            at = truth.get(str(round(fix["time"])))
            if fix["status"] != "ok" or at is None or len(fix["sources"]) < 4:
                continue
            error = np.array([fix["x"], fix["y"]]) - at
            errors.append(np.linalg.norm(error))
            consistency.append(nees(error, np.array(fix["covariance"]).reshape(3, 3)[:2, :2], 0.02))
        report(f"lcav, {name}, four cameras together", errors, consistency, len(errors), 5)


def unitn(splits=15):
    folder = data / "unitn"
    reference = {row["image"]: row for row in rows(folder / "reference.csv")}
    robots = [image for image, row in reference.items() if row["robot"] == "1"]
    empty = [image for image, row in reference.items() if row["robot"] == "0"]
    camera = yaml.safe_load(open(folder / "site.yaml"))["cameras"]["top"]
    lens = camera["intrinsics"]
    matrix = np.array([[lens["fx"], 0, lens["cx"]], [0, lens["fy"], lens["cy"]], [0, 0, 1.0]])
    distortion = np.array(camera["distortion"], float)
    points = camera["floor_points"]
    _, turn, shift = cv2.solvePnP(np.array([p["map"] + [0] for p in points], float), np.array([p["pixel"] for p in points], float), matrix, distortion)

    def pixel(x, y):
        return cv2.projectPoints(np.array([[x, y, 0.1]]), turn, shift, matrix, distortion)[0][0, 0]

    def compare(found):
        offsets, turns, false = [], [], 0
        for fix in found:
            row = reference[pathlib.Path(fix["image"]).name]
            if fix["status"] != "ok":
                continue
            if row["robot"] == "0":
                false += 1
                continue
            middle = pixel(fix["x"], fix["y"])
            tip = pixel(fix["x"] + 0.05 * math.cos(fix["yaw"]), fix["y"] + 0.05 * math.sin(fix["yaw"]))
            heading = float(row["heading_image_deg"])
            off = middle - [float(row["u"]), float(row["v"])]
            a = math.radians(heading)
            offsets.append([off[0] * math.cos(a) + off[1] * math.sin(a), off[1] * math.cos(a) - off[0] * math.sin(a)])
            turns.append(math.degrees(math.atan2(tip[1] - middle[1], tip[0] - middle[0])) - heading)
        return np.array(offsets).reshape(-1, 2), np.array(turns), false

    background = ["--background", folder / "frames" / empty[0]]
    for split in range(splits):
        random.seed(split + 100)
        taught = sorted(random.sample(robots, 8))
        body = work / f"lego-{split}.body"
        frames = [folder / "frames" / image for image in taught]
        if not call("calibrate", "robot", folder / "site.yaml", "--camera", "top", *background, *frames, "-o", body):
            continue
        site = site_with(folder / "site.yaml", f"lego: {{model: {body}}}", f"unitn-{split}.yaml")
        others = [folder / "frames" / image for image in robots if image not in taught] + [folder / "frames" / image for image in empty]
        offsets, turns, false = compare(fixes(site, "--camera", "top", *background, *others))
        if not len(turns):
            print(f"unitn, split {split}: none of 8 found, {false} false")
            continue
        # One fixed offset in the robot's frame, and a half turn that nobody told.
        middle = np.median(offsets, axis=0)
        half = 0 if np.median(np.cos(np.radians(turns))) > 0 else 180
        deviation = (turns - half + 180) % 360 - 180
        scatter = np.hypot(*(offsets - middle).T)
        right = int(np.sum((scatter < 40) & (np.abs(deviation) < 15)))
        centred = deviation - np.median(deviation)
        print(f"unitn, learned from eight (split {split}): {right} of 8 others right, {false} of {len(empty)} empty pictures with a fix; scatter "
              f"{np.sqrt(np.mean(scatter**2)):.1f} px, {np.sqrt(np.mean(centred**2)):.1f} deg; front {'as marked' if half % 360 == 0 else 'half a turn off'}, "
              f"{np.median(deviation):+.1f} deg")
    offsets, turns, false = compare(fixes(folder / "site.yaml", "--camera", "top", *background, *[folder / "frames" / image for image in reference]))
    right = int(np.sum((np.hypot(*offsets.T) < 40) & (np.abs((turns + 90) % 180 - 90) < 15))) if len(turns) else 0
    print(f"unitn, plain box: {right} of 16 right (half turns count), {false} of {len(empty)} empty pictures with a fix")


def aisle():
    folder = data / "worlds/aisle"
    truth = json.load(open(folder / "truth.json"))
    bodies = {"bounding box": None,
              "parts": "robot: {parts: [{box: [0.54, 0.10, 0.26], at: [0, 0.22, 0.13]}, {box: [0.54, 0.10, 0.26], at: [0, -0.22, 0.13]}, "
                       "{box: [0.47, 0.34, 0.39], at: [0, 0, 0.255]}]}"}
    for name, robot in bodies.items():
        site = folder / "site.yaml"
        if robot:
            site = site_with(site, robot.replace("robot:", next(iter(yaml.safe_load(open(site))["robots"])) + ":", 1), "aisle-parts.yaml")
        found = {}
        for camera in sorted({row["camera"] for row in truth}):
            for fix in fixes(site, "--camera", camera, *[folder / row["image"] for row in truth if row["camera"] == camera]):
                found[fix["image"]] = fix
        for kind in ("plain", "light", "hidden"):
            those = [row for row in truth if row["kind"] == kind]
            errors, consistency = [], []
            for row in those:
                fix = found.get(str(folder / row["image"]))
                if not fix or fix["status"] != "ok":
                    continue
                error = np.array([fix["x"] - row["x"], fix["y"] - row["y"], (fix["yaw"] - row["yaw"] + math.pi / 4) % (math.pi / 2) - math.pi / 4])
                errors.append(np.linalg.norm(error[:2]))
                consistency.append(error @ np.linalg.solve(np.array(fix["covariance"]).reshape(3, 3), error) / 3)
            report(f"aisle, {name}, {kind}", errors, consistency, len(errors), len(those))


if __name__ == "__main__":
    for scene in sys.argv[2:] or ["lcav", "unitn", "aisle"]:
        {"lcav": lcav, "unitn": unitn, "aisle": aisle}[scene]()
