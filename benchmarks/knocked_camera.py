#!/usr/bin/python3
"""A recorded session in which somebody bumps into a camera: from one moment on, all its pictures are those of a camera turned by some degrees.

    benchmarks/knocked_camera.py PROGRAM SESSION [--camera ID] [--degrees 0.4 0.8 2] [--after 0.4]

Prints what `replay` and `evaluate` say, without a knock and with each, and when the camera was noticed. Needs python3-numpy, python3-opencv and python3-yaml.
"""
import argparse
import pathlib
import re
import shutil
import subprocess
import tempfile

import cv2
import numpy as np
import yaml


def sources_after(camera, turn):
    """For every pixel after the knock: where it was before. `turn`: rad, about the camera's axes."""
    width, height = camera["size"]
    k = camera["intrinsics"]
    matrix = np.array([[k["fx"], 0, k["cx"]], [0, k["fy"], k["cy"]], [0, 0, 1.0]])
    distortion = np.array(camera.get("distortion", [0.0] * 5), float)
    pixels = np.stack(np.meshgrid(np.arange(width), np.arange(height)), -1).reshape(-1, 1, 2).astype(float)
    rays = cv2.undistortPoints(pixels, matrix, distortion)[:, 0]
    before = np.c_[rays, np.ones(len(rays))] @ cv2.Rodrigues(np.asarray(turn, float))[0].T
    source = cv2.projectPoints(before, np.zeros(3), np.zeros(3), matrix, distortion)[0]
    return source.reshape(height, width, 2).astype(np.float32)


def knock(session, copy, name, turn, after):
    shutil.copytree(session, copy)
    camera = yaml.safe_load((session / "site.yaml").read_text())["cameras"][name]
    pictures = sorted((copy / camera["source"]).iterdir(), key=lambda file: int(file.stem))
    source = sources_after(camera, turn)
    for picture in pictures[int(after * len(pictures)):]:
        seen = cv2.remap(cv2.imread(str(picture), cv2.IMREAD_UNCHANGED), source, None, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT)
        picture.chmod(0o644)
        cv2.imwrite(str(picture), seen, [cv2.IMWRITE_JPEG_QUALITY, 92])


def figures(program, session, work):
    fixes = work / "fixes.jsonl"
    told = subprocess.run([program, "replay", session, "--fixes", fixes], check=True, capture_output=True, text=True).stderr
    report = subprocess.run([program, "evaluate", fixes, "--truth", session / "truth.csv"], check=True, capture_output=True, text=True).stdout
    row = re.search(r"^all +(.*)$", report, re.MULTILINE).group(1).split()
    numbers = [re.search(pattern, report, re.MULTILINE) for pattern in (r"^GOSPA +(\S+)", r"^available (\S+)", r"^confidently wrong: (\S+)", r"^identity switches: (\d+)")]
    told = [line.split("warning: ")[1] for line in told.splitlines() if "(moved)" in line or "(changed)" in line or "(quarantined)" in line]
    print("  GOSPA {} m, available {} %, confidently wrong {}, switches {}".format(*(n.group(1) if n else "-" for n in numbers)), f"rms {row[1]} mm, NEES {row[8]}", flush=True)
    for line in told[:3]:
        print("   ", line[:150], flush=True)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("program", type=pathlib.Path)
    arguments.add_argument("session", type=pathlib.Path)
    arguments.add_argument("--camera")
    arguments.add_argument("--degrees", type=float, nargs="+", default=[0.4, 0.8, 2])
    arguments.add_argument("--after", type=float, default=0.4)
    wanted = arguments.parse_args()
    program = wanted.program.resolve()
    camera = wanted.camera or next(iter(yaml.safe_load((wanted.session / "site.yaml").read_text())["cameras"]))
    for degrees in [0, *wanted.degrees]:
        with tempfile.TemporaryDirectory(prefix="roomfix-knock-") as folder:
            work = pathlib.Path(folder)
            turn = np.radians(degrees) * np.array([0.4, 0.85, -0.33])
            knock(wanted.session, work / "session", camera, turn, wanted.after if degrees else 1)
            print(f"{wanted.session.name}: camera {camera} turned by {degrees} deg")
            figures(program, work / "session", work)


if __name__ == "__main__":
    main()
