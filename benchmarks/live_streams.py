#!/usr/bin/python3
"""A recorded session as live cameras: its pictures come as MJPEG streams over HTTP at their own times, `roomfix run` finds the robots, `roomfix evaluate`
compares the fixes with the session's truth. What the time stamps of arrival are late by is part of the errors.

    benchmarks/live_streams.py build/release/bin/roomfix SESSION
"""
import csv
import http.server
import json
import pathlib
import subprocess
import sys
import tempfile
import threading
import time

import yaml

program, session = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
site = yaml.safe_load((session / "site.yaml").read_text())
frames = {camera: sorted((session / "frames" / camera).iterdir(), key=lambda f: int(f.stem)) for camera in site["cameras"]}
first = min(int(files[0].stem) for files in frames.values()) * 1e-9
start_up = 4.0  # s until the program has learned its backgrounds
started = threading.Event()
begin = 0.0


class Streams(http.server.BaseHTTPRequestHandler):
    def log_message(self, *_):
        pass

    def do_GET(self):
        global begin
        if not started.is_set():
            begin = time.time() + start_up
            started.set()
        self.send_response(200)
        self.send_header("Content-Type", "multipart/x-mixed-replace; boundary=frame")
        self.end_headers()
        try:
            for file in frames[self.path.strip("/").removesuffix(".mjpg")]:
                due = begin + int(file.stem) * 1e-9 - first
                time.sleep(max(due - time.time(), 0))
                picture = file.read_bytes()
                self.wfile.write(b"--frame\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n" % len(picture) + picture + b"\r\n")
        except (BrokenPipeError, ConnectionResetError):
            pass


server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Streams)
threading.Thread(target=server.serve_forever, daemon=True).start()
for name, camera in site["cameras"].items():
    camera["source"] = f"http://127.0.0.1:{server.server_port}/{name}.mjpg"
    if "background" in camera:
        camera["background"] = str(session / camera["background"])
with tempfile.TemporaryDirectory() as work:
    live, fixes, moved = (pathlib.Path(work) / name for name in ("site.yaml", "live.jsonl", "fixes.jsonl"))
    live.write_text(yaml.safe_dump(site))
    ran = subprocess.run([program, "run", live, "--port", "0", "--fixes", fixes], capture_output=True, text=True)
    print(ran.stderr + ran.stdout)
    with moved.open("w") as out:
        for line in fixes.read_text().splitlines():
            fix = json.loads(line)
            fix["time"] = fix["time"] - begin + first
            out.write(json.dumps(fix) + "\n")
    end = max(float(row["time"]) for row in csv.DictReader((session / "truth.csv").open()))
    print(f"truth from {first:.1f} to {end:.1f} s")
    print(subprocess.run([program, "evaluate", moved, "--truth", session / "truth.csv"], capture_output=True, text=True).stdout)
