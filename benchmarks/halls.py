#!/usr/bin/python3
"""Fixed cameras and many robots, on halls that are drawn anew: `roomfix simulate hall`, `replay` and `evaluate`, nothing else.

    benchmarks/halls.py PROGRAM accuracy SEED...      errors, names and false things in one hall for each seed, with and without odometry
    benchmarks/halls.py PROGRAM cost -o OUTPUT.svg    time per frame over the robots in view, on one processor, with a plot
"""
import argparse
import pathlib
import re
import subprocess
import tempfile


def run(*command, **more):
    return subprocess.run([str(part) for part in command], check=True, capture_output=True, text=True, **more)


def number(pattern, text):
    found = re.search(pattern, text, re.MULTILINE)
    return found.group(1) if found else "-"


def hall(program, folder, seed, robots=6, duration=12):
    run(program, "simulate", "hall", "-o", folder, "--seed", seed, "--robots", robots, "--duration", duration)


def accuracy(program, seeds):
    print(f"{'seed':>8} {'odometry':>9} {'rms mm':>8} {'NEES':>8} {'available %':>12} {'GOSPA m':>8} {'switches':>9} {'confidently wrong':>18} {'person found %':>15}")
    for seed in seeds:
        with tempfile.TemporaryDirectory() as made:
            folder, fixes = pathlib.Path(made) / "hall", pathlib.Path(made) / "fixes.jsonl"
            hall(program, folder, seed)
            for source, odometry in ((folder, "with"), (folder / "site.yaml", "without")):
                run(program, "replay", source, "--fixes", fixes)
                told = run(program, "evaluate", fixes, "--truth", folder / "truth.csv").stdout
                wrong = number(r"^confidently wrong: (\S+)", told)
                figures = (number(r"^all +\d+ +(\S+)", told), number(r"^all(?: +\S+){8} +(\S+)", told), number(r"^available (\S+)", told),
                           number(r"^GOSPA +(\S+)", told), number(r"^identity switches: (\d+)", told), "0" if wrong == "none" else wrong,
                           number(r"^unknown things: found (\S+)", told))
                print("{:>8} {:>9} {:>8} {:>8} {:>12} {:>8} {:>9} {:>18} {:>15}".format(seed, odometry, *figures), flush=True)


def cost(program, output, seed):
    """Two cameras; each moment's time is that of both."""
    points = []
    for robots in (1, 2, 4, 6, 8, 12, 16, 20):
        with tempfile.TemporaryDirectory() as made:
            folder = pathlib.Path(made) / "hall"
            hall(program, folder, seed, robots, 8)
            told = run("taskset", "-c", "0", program, "replay", folder / "site.yaml", "--fixes", pathlib.Path(made) / "fixes.jsonl").stderr
            stages = {name: [float(n) for n in rest.split()] for name, rest in re.findall(r"info: +(\w+) +\d+ +((?:[\d.]+ *){4})$", told, re.MULTILINE)}
            points.append((robots, stages["moment"][0] / 2, stages["moment"][2] / 2, stages["look"][0], stages["fit"][0] / 2))
            print("{:>2} robots: {:6.1f} ms per frame (median), {:6.1f} (99 %); of it looking {:.1f}, fitting {:.1f}".format(*points[-1]), flush=True)
    if output:
        draw(points, output)


def draw(points, output):
    width, height, left, top = 640, 320, 60, 20
    highest = max(p[2] for p in points) * 1.1
    at = lambda robots, ms: (left + width * robots / 20, top + height * (1 - ms / highest))
    line = lambda which: " ".join("{:.1f},{:.1f}".format(*at(p[0], p[which])) for p in points)
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width + left + 20}" height="{height + 70}" font-family="sans-serif" font-size="13">',
             '<rect width="100%" height="100%" fill="white"/>', f'<path d="M{left},{top} v{height} h{width}" stroke="#888" fill="none"/>']
    for which, colour, name in ((1, "#1f6fb2", "median"), (2, "#c2571a", "99 %")):
        parts.append(f'<polyline points="{line(which)}" fill="none" stroke="{colour}" stroke-width="2"/>')
        x, y = at(20, points[-1][which])
        parts.append(f'<text x="{x - 60}" y="{y - 8}" fill="{colour}">{name}</text>')
    for robots in range(0, 21, 4):
        parts.append(f'<text x="{at(robots, 0)[0]}" y="{top + height + 18}" text-anchor="middle">{robots}</text>')
    for step in range(0, 5):
        ms = highest * step / 4
        parts.append(f'<text x="{left - 6}" y="{at(0, ms)[1] + 4}" text-anchor="end">{ms:.0f}</text>')
    parts += [f'<text x="{left + width / 2}" y="{top + height + 40}" text-anchor="middle">robots in view of two cameras</text>',
              f'<text x="{left + 8}" y="{top + 12}">ms per frame of 640 x 480, one processor</text>', "</svg>"]
    pathlib.Path(output).write_text("\n".join(parts))


wanted = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
wanted.add_argument("program", type=pathlib.Path)
wanted.add_argument("what", choices=("accuracy", "cost"))
wanted.add_argument("seeds", nargs="*", type=int, default=[1])
wanted.add_argument("-o", "--output")
told = wanted.parse_args()
if told.what == "accuracy":
    accuracy(told.program.resolve(), told.seeds)
else:
    cost(told.program.resolve(), told.output, told.seeds[0])
