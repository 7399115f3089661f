"""What a crowd of page clients does to the page and to the fixes of a live site: 200 idle and slow ones and 100 that listen to events.

python3 benchmarks/crowded_page.py [--seconds 30]
The program is build/release/bin/roomfix, or what the variable ROOMFIX names.

Prints how long answers of the page took and how old fixes were when they were given, without the crowd and with it."""
import argparse
import pathlib
import select
import sys
import tempfile
import time
import urllib.request

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tests/connections"))
from live_site import LiveHall, Page, quantile  # noqa: E402
from page_crowd import PageCrowd  # noqa: E402
from peers import Process, fixes_of, free_port, program, wait_until  # noqa: E402


def visit(port, seconds, streams):
    """Seconds that each answer took. The streams are read as they come."""
    times, end = [], time.monotonic() + seconds
    while time.monotonic() < end:
        begin = time.monotonic()
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/api/state", timeout=30) as answer:
            answer.read()
        times.append(time.monotonic() - begin)
        for stream in select.select(streams, [], [], 0.02)[0]:
            stream.recv(1 << 16)
    return times


def measure(name, port, seconds, fixes, streams=()):
    begin = time.time()
    times = visit(port, seconds, streams)
    ages = [fix["latency"] for fix in fixes_of(fixes) if begin < fix["time"] and "latency" in fix]
    figures = [1e3 * quantile(values, q) for values in (times, ages) for q in (0.5, 0.99, 1)]
    print("{:12}              {:6.1f} {:5.1f}   {:6.1f}                   {:6.1f} {:5.1f}   {:6.1f}".format(name, *figures))


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--seconds", type=float, default=30)
    seconds = arguments.parse_args().seconds
    with tempfile.TemporaryDirectory(prefix="roomfix-crowd-") as folder:
        hall, port, fixes = LiveHall(folder, 20, there_and_back=True), free_port(), pathlib.Path(folder) / "fixes.jsonl"
        running = Process(folder, "roomfix", program, "run", hall.write_site(f"  web: {{port: {port}}}\n"), "--fixes", fixes)
        try:
            page = Page(port)
            wait_until(lambda: fixes.exists() and len(fixes_of(fixes)) > 20 and page.state(), "the robot is followed", 120)
            hall.drive()
            print("             answers, ms: median  99 %  largest    fixes, ms old: median  99 %  largest")
            measure("alone", port, seconds, fixes)
            with PageCrowd(port) as crowd:
                measure("with a crowd", port, seconds, fixes, crowd.streams)
        finally:
            running.stop(True)
            hall.stop()


if __name__ == "__main__":
    main()
