#!/usr/bin/python3
"""Worlds rendered by POV-Ray, which shares nothing with roomfix, and what the program makes of them.

    benchmarks/povray_worlds.py aisle -o DIR --count 12 --seed 1           single pictures of one robot, one world each
    benchmarks/povray_worlds.py hall -o DIR --seed 1 --duration 10         a session with five or six robots and a person
    benchmarks/povray_worlds.py measure build/release/bin/roomfix DIR      figures, and the ten worst pictures in DIR/worst.png
    benchmarks/povray_worlds.py check                                      geometry against OpenCV's camera model

Needs povray, python3-numpy, python3-opencv and python3-yaml. Every seed is another world; the same seed gives the same one.

Seeds 1 to 20 are for looking at while the program is made better. Figures that are published are to be made with seeds nobody
has looked at: once their pictures or their single failures were seen, take others (--no-sheet keeps them unseen).
"""
import argparse
import pathlib
import sys

from povray import aisle, check, hall, measure


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    for name, about in (("aisle", "single pictures of one robot"), ("hall", "a session with several robots")):
        command = commands.add_parser(name, help=about)
        command.add_argument("-o", dest="folder", type=pathlib.Path, required=True, help="folder to write")
        command.add_argument("--seed", type=int, default=1, help="1 to 20 for development, others for reports")
        if name == "aisle":
            command.add_argument("--count", type=int, default=12, help="number of worlds")
        else:
            command.add_argument("--duration", type=float, default=10, help="s")
    command = commands.add_parser("measure", help="what the program makes of worlds or a session")
    command.add_argument("program", help="the roomfix binary")
    command.add_argument("folder", type=pathlib.Path)
    command.add_argument("--no-sheet", action="store_true", help="no picture of the worst ones")
    command = commands.add_parser("check", help="geometry against OpenCV's camera model")
    command.add_argument("--seed", type=int, default=1)
    return parser.parse_args()


def main():
    given = arguments()
    if given.command == "aisle":
        aisle.write_worlds(given.folder, given.count, given.seed)
    elif given.command == "hall":
        hall.write_hall(given.folder, given.seed, given.duration)
    elif given.command == "measure":
        return measure.measure(given.program, given.folder, not given.no_sheet)
    else:
        return check.check(given.seed)
    return 0


if __name__ == "__main__":
    sys.exit(main())
