"""A live site for hours, with somebody killed and started again every few seconds: what it does to memory, latency and truth.

[ROOMFIX_DDS_LISTENER=build/release/tests/ros2/ros2_listener] python3 benchmarks/long_run.py [--minutes 60] [--output DIR]
The program is build/release/bin/roomfix, or what the variable ROOMFIX names.

Writes DIR/long_run.csv and DIR/long_run.svg, a row and a point per minute."""
import argparse
import csv
import pathlib
import random
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tests/connections"))
from killable_peers import SiteWithPeers  # noqa: E402
from live_site import errors_of, quantile  # noqa: E402
from peers import wait_until  # noqa: E402

from minutes import FixReader, draw, look_at  # noqa: E402

columns = ["minute", "memory MB", "threads", "open files", "fixes", "latency ms, median", "latency ms, 95 %", "error mm, median", "error mm, 99 %", "surprise", "kills",
           "slowest recovery s"]
shown = ["memory MB", "open files", "latency ms, median", "latency ms, 95 %", "error mm, median", "slowest recovery s"]


def minute_of(site, reader, number, kills, slowest):
    fixes = [fix for fix in reader.read() if fix["status"] == "ok"]
    latencies = [1e3 * fix["latency"] for fix in fixes if "latency" in fix]
    errors, surprise = errors_of(fixes, lambda fix: site.hall.place(fix["time"]))
    memory, threads, files = look_at(site.running.process)
    return [number, round(memory, 1), threads, files, len(fixes), *(round(value, 1) for value in (
        quantile(latencies, 0.5), quantile(latencies, 0.95), 1e3 * quantile(errors, 0.5), 1e3 * quantile(errors, 0.99))), round(surprise, 2), kills, round(slowest, 1)]


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--minutes", type=float, default=60)
    arguments.add_argument("--output", type=pathlib.Path, default=pathlib.Path("."))
    wanted = arguments.parse_args()
    wanted.output.mkdir(parents=True, exist_ok=True)
    rows = []
    with tempfile.TemporaryDirectory(prefix="roomfix-long-") as folder, SiteWithPeers(folder, 40) as site, open(wanted.output / "long_run.csv", "w") as out:
        table = csv.writer(out)
        table.writerow(columns)
        wait_until(lambda: all(site.works(peer, 0) for peer in site.peers), "all is well", 120)
        site.hall.drive()
        reader, start, kills, slowest = FixReader(site.fixes), time.time(), 0, 0.0
        while time.time() < start + 60 * wanted.minutes:
            time.sleep(random.uniform(3, 12))
            order = random.sample(list(site.peers), random.randint(1, len(site.peers)))
            site.kill(order)
            slowest = max(slowest, *site.restart(order).values())
            kills += len(order)
            if time.time() < start + 60 * (len(rows) + 1):
                continue
            rows.append(minute_of(site, reader, len(rows) + 1, kills, slowest))
            table.writerow(rows[-1])
            out.flush()
            print(dict(zip(columns, rows[-1])), flush=True)
            draw(columns, rows, shown, wanted.output / "long_run.svg")
            kills, slowest = 0, 0.0


if __name__ == "__main__":
    main()
