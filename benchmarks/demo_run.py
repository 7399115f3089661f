"""The demo for an hour, with its camera that freezes and its camera that is knocked: memory, latency, frame rate, every fix beside the truth,
and how fast the machine itself is, which on a shared one is not the same at all times.

python3 benchmarks/demo_run.py [--minutes 60] [--output DIR]
The program is build/release/bin/roomfix, or what the variable ROOMFIX names.

Writes DIR/demo_run.csv and DIR/demo_run.svg, a row and a point per minute."""
import argparse
import bisect
import collections
import csv
import pathlib
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tests/connections"))
from live_site import Page, errors_of, quantile  # noqa: E402
from peers import Process, free_port, program, wait_until  # noqa: E402

from minutes import FixReader, LineReader, draw, look_at, machine_pace  # noqa: E402

columns = ["minute", "memory MB", "threads", "open files", "frames per s", "latency ms, median", "latency ms, 95 %", "latency ms, 99 %", "ok %", "error mm, median", "error mm, 99 %",
           "surprise", "ok and off by more than 0.5 m", "freezes told", "knocks told", "alarms without cause", "machine: ms for the same work"]
shown = ["memory MB", "open files", "machine: ms for the same work", "frames per s", "latency ms, median", "latency ms, 95 %", "ok %", "error mm, median", "error mm, 99 %"]
period, frozen, knocked = 90, ("hall2", 30, 40), ("hall1", 55, 75)  # s; what the demo stages in every round


class Truth:
    """Where the robots of the demo are, from the file that grows."""

    def __init__(self, file):
        self.lines = LineReader(file)
        self.times, self.poses = collections.defaultdict(list), collections.defaultdict(list)

    def read(self):
        for line in self.lines.read():
            moment, robot, *pose = line.split(",")
            if moment != "time":
                self.times[robot].append(float(moment))
                self.poses[robot].append([float(number) for number in pose])

    def place(self, robot, moment):
        times, poses = self.times[robot], self.poses[robot]
        i = min(max(bisect.bisect(times, moment), 1), len(times) - 1)
        part = min(max((moment - times[i - 1]) / (times[i] - times[i - 1]), 0), 1)
        return [a + part * (b - a) for a, b in zip(poses[i - 1][:2], poses[i][:2])]


class Faults:
    """What the page says of the cameras, beside what is staged."""

    def __init__(self, begin):
        self.begin, self.now, self.told, self.false = begin, {}, collections.Counter(), collections.Counter()

    def look(self, state):
        for camera in state["cameras"]:
            well, phase = camera["status"] in ("ok", "waiting"), (time.time() - self.begin) % period
            for name, (which, begin, end) in (("freeze", frozen), ("knock", knocked)):
                if camera["id"] == which and begin < phase < end and not well:
                    self.told[name, int((time.time() - self.begin) // period)] = 1
            staged = any(camera["id"] == which and begin - 1 < phase < end + 15 for which, begin, end in (frozen, knocked))
            was, self.now[camera["id"]] = self.now.get(camera["id"], True), well
            if was and not well and not staged:
                self.false[camera["id"]] += 1
                print(f"{camera['id']}, {phase:.0f} s into its round: {camera['status']}, {camera.get('message')}", flush=True)

    def counts(self):
        return [sum(name == wanted for name, _ in self.told) for wanted in ("freeze", "knock")] + [sum(self.false.values())]


def minute_of(number, process, fixes, truth, frames, faults, paces):
    well = [fix for fix in fixes if fix["status"] == "ok" and fix["robot"]]
    latencies = [1e3 * fix["latency"] for fix in well if "latency" in fix]
    errors, surprise = errors_of(well, lambda fix: truth.place(fix["robot"], fix["time"]))
    memory, threads, files = look_at(process)
    return [number, round(memory, 1), threads, files, round(frames, 2), *(round(quantile(latencies, q), 1) for q in (0.5, 0.95, 0.99)),
            round(100 * len(well) / max(sum(fix["robot"] is not None for fix in fixes), 1), 1), *(round(1e3 * quantile(errors, q), 1) for q in (0.5, 0.99)), round(surprise, 2),
            sum(error > 0.5 for error in errors), *faults.counts(), round(quantile(paces, 0.5), 1)]


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--minutes", type=float, default=60)
    arguments.add_argument("--output", type=pathlib.Path, default=pathlib.Path("."))
    wanted = arguments.parse_args()
    wanted.output.mkdir(parents=True, exist_ok=True)
    rows = []
    with tempfile.TemporaryDirectory(prefix="roomfix-demo-") as folder, open(wanted.output / "demo_run.csv", "w") as out:
        table = csv.writer(out)
        table.writerow(columns)
        port, fixes_file, truth_file = free_port(), f"{folder}/fixes.jsonl", f"{folder}/truth.csv"
        running = Process(folder, "demo", program, "demo", "--port", port, "--fixes", fixes_file, "--truth", truth_file)
        try:
            page = Page(port)
            wait_until(lambda: "Ctrl-C ends the demo" in running.text(), "the empty building is rendered", 300)
            start = time.time()
            reader, truth, faults = FixReader(fixes_file), Truth(truth_file), Faults(start)
            before, paces = 0, []
            while time.time() < start + 60 * wanted.minutes + 1 and not running.ended():
                time.sleep(0.5)
                state = page.state()
                if state is None:
                    continue
                faults.look(state)
                if time.time() > start + 60 * len(rows) + 12 * len(paces):
                    paces.append(machine_pace())
                if time.time() < start + 60 * (len(rows) + 1):
                    continue
                fixes = reader.read()
                truth.read()
                frames = state["cameras"][0]["frames"]
                rows.append(minute_of(len(rows) + 1, running.process, fixes, truth, (frames - before) / 60, faults, paces))
                before, paces = frames, []
                table.writerow(rows[-1])
                out.flush()
                print(dict(zip(columns, rows[-1])), flush=True)
                draw(columns, rows, shown, wanted.output / "demo_run.svg")
            if running.ended():
                sys.exit(f"the demo ended by itself:\n{running.text()[-2000:]}")
        finally:
            running.stop()


if __name__ == "__main__":
    main()
