"""ROS 2 topics as a subscriber of another vendor's DDS (Cyclone) gets them, beside the fixes file of the same run: ros2_test.py ROOMFIX LISTENER EXAMPLES"""
import bisect
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

from ros2_peer import apart, cyclone, domain, time_of

program, listener, examples = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])


class Run:
    """A session that is run with ROS 2 topics, and what somebody else got of them."""

    def __init__(self, session, domain, word, speed):
        self.folder, self.domain = session, domain
        self.listener = subprocess.Popen([listener, str(domain), word, "hall1"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=cyclone)
        assert self.listener.stdout.readline() == '{"listening": true}\n'
        command = [program, "run", str(session / "site.yaml"), "--no-page", "--speed", str(speed), "--fixes", str(session / "fixes.jsonl")]
        self.program = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=os.environ | {"ROS_LOCALHOST_ONLY": "1"})

    def finish(self):
        said = self.program.communicate(timeout=120)[1]
        assert self.program.returncode == 0, said
        assert f"domain {self.domain}" in said, said
        text = self.listener.communicate(timeout=60)[0]
        assert self.listener.returncode == 0
        messages = [json.loads(line) for line in text.splitlines()]
        self.poses = [m["pose"] for m in messages if "pose" in m]
        self.odometry = [m["odometry"] for m in messages if "odometry" in m]
        self.transforms = [m["transform"] for m in messages if "transform" in m]
        self.states = [m["state"] for m in messages if "state" in m]
        self.cameras = [m["camera"] for m in messages if "camera" in m]
        fixes = [(stamp(line), json.loads(line)) for line in (self.folder / "fixes.jsonl").read_text().splitlines()]
        self.fixes = [(time, fix) for time, fix in fixes if fix["status"] != "none"]
        return self


def nanoseconds(text):
    whole, _, part = text.partition(".")
    return int(whole) * 10**9 + int(part.ljust(9, "0")[:9] or 0)


def stamp(line):
    return nanoseconds(line.split('"time": ')[1].split(",")[0])


def yaw_of(message):
    x, y, z, w = message["quaternion"]
    assert x == y == 0 and abs(math.hypot(z, w) - 1) < 1e-12
    return 2 * math.atan2(z, w)


def near(a, b, tolerance=1e-6):
    assert abs(a - b) < tolerance, f"{a} is not {b}"


def same_angle(a, b):
    near(math.sin(a - b), 0)
    assert math.cos(a - b) > 0


def is_pose(pose, time, fix):
    return time_of(pose) == time and max(abs(pose["position"][0] - fix["x"]), abs(pose["position"][1] - fix["y"])) < 1e-6


def check_pose(pose, fix):
    """Beside its place. The file has six decimals, of the covariance nine digits."""
    assert pose["frame"] == "map" and pose["position"][2] == 0
    covariance, axes = pose["covariance"], [0, 1, 5] if fix["yaw"] is not None else [0, 1]
    for i, a in enumerate(axes):
        for j, b in enumerate(axes):
            near(covariance[6 * a + b], fix["covariance"][3 * i + j], 1e-7 * abs(fix["covariance"][3 * i + j]) + 1e-15)
    assert all(math.isfinite(c) for c in covariance) and all(covariance[7 * i] > 0 for i in range(6))
    if fix["yaw"] is None:
        near(covariance[35], math.pi**2 / 3)
    else:
        same_angle(yaw_of(pose), fix["yaw"])


def check_poses(run, least=50):
    """From the moment on at which the two found each other every fix comes, in their order and as it stands in the file, up to the last. On a machine that has
    no time at all a few may be lost: the last ten are kept, no more."""
    assert len(run.poses) >= least, f"{len(run.poses)} of {len(run.fixes)} poses came"
    following, places = iter(enumerate(run.fixes)), []
    for pose in run.poses:
        place, fix = next(((i, fix) for i, (time, fix) in following if is_pose(pose, time, fix)), (None, None))
        assert fix, f"no fix, or one out of order: {pose}"
        check_pose(pose, fix)
        places.append(place)
    assert places[-1] == len(run.fixes) - 1, "the last fix did not come"
    assert len(places) > 0.9 * (places[-1] - places[0] + 1), f"{len(places)} came of {places[-1] - places[0] + 1}"


def check_odometry(run, child):
    """With each pose that has a velocity comes an odometry of the same fix."""
    moving = {(time, fix["x"], fix["y"]): fix for time, fix in run.fixes if "velocity" in fix and fix["yaw"] is not None}
    posed = [key for key in ((time_of(pose), *(round(v, 6) for v in pose["position"][:2])) for pose in run.poses) if key in moving]
    assert posed and len(run.odometry) > 0.9 * len(posed), f"{len(run.odometry)} came beside {len(posed)} poses"
    for message in run.odometry:
        assert (message["frame"], message["child"]) == ("map", child)
        fix = moving[(time_of(message), *(round(value, 6) for value in message["position"][:2]))]
        same_angle(yaw_of(message), fix["yaw"])
        near(math.hypot(*message["twist"][:2]), math.hypot(*fix["velocity"][:2]), 3e-6)
        near(message["twist"][5], fix["velocity"][2])
        assert all(message[name][7 * i] > 0 for name in ("covariance", "twist_covariance") for i in range(6))


def odometry_of(folder):
    lines = [line.split(",") for line in (folder / "odometry.csv").read_text().split("\n")[1:] if line]
    return [(nanoseconds(time), float(x), float(y), float(yaw)) for time, _, x, y, yaw in lines]


def odometry_at(reports, time):
    i = bisect.bisect_left([report[0] for report in reports], time)
    (t0, *a), (t1, *b) = reports[max(i - 1, 0)], reports[i]
    part = (time - t0) / (t1 - t0) if t1 > t0 else 1
    turn = math.remainder(b[2] - a[2], 2 * math.pi)
    return a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1]), a[2] + part * turn


def check_odometry_chain(run, least=40):
    """map -> odom, and odom -> base_link of the wheels, make the fix; base_link has no other parent."""
    reports = odometry_of(run.folder)
    assert len(run.transforms) >= least, f"{len(run.transforms)} transforms came"
    times = [time_of(t) for t in run.transforms]
    assert times == sorted(set(times)), "one transform at a time, in their order"
    for transform in run.transforms:
        assert (transform["frame"], transform["child"]) == ("map", "odom")
        x, y, yaw = odometry_at(reports, time_of(transform))
        turn = yaw_of(transform)
        place = (transform["position"][0] + math.cos(turn) * x - math.sin(turn) * y, transform["position"][1] + math.sin(turn) * x + math.cos(turn) * y)
        at_that_time = [fix for time, fix in run.fixes if time == time_of(transform) and fix["yaw"] is not None]
        assert any(math.dist(place, (fix["x"], fix["y"])) < 2e-6 and abs(math.sin(turn + yaw - fix["yaw"])) < 2e-6 for fix in at_that_time), transform
    # Also at the end, but for what waits for the next report.
    assert run.fixes[-1][0] - times[-1] < 0.5e9


def check_robot_transforms(run, word):
    known = {(time, fix["x"], fix["y"]): fix["yaw"] for time, fix in run.fixes if fix["yaw"] is not None}
    assert len(run.transforms) >= 40, f"{len(run.transforms)} transforms came"
    for transform in run.transforms:
        assert (transform["frame"], transform["child"]) == ("map", f"{word}/base_link")
        x, y = (round(value, 6) for value in transform["position"][:2])
        same_angle(yaw_of(transform), known[(time_of(transform), x, y)])


def check_states(run, robot):
    states = [state for state in run.states if state["name"] == f"roomfix: robot {robot}"]
    assert states, "no /diagnostics came"
    assert {state["id"] for state in states} == {robot} and all(state["level"] in (0, 1, 2) for state in states)
    assert any(state["values"]["status"] == "ok" and state["level"] == 0 for state in states), states


def check_cameras(run):
    names = {state["name"] for state in run.states}
    assert names == {"roomfix: robot r1"} | {f"roomfix: camera hall{i}" for i in (1, 2, 3)}, names
    first = [state for state in run.states if state["id"] == "hall1"]
    assert any(state["level"] == 0 and state["values"]["status"] == "ok" and int(state["values"]["frames"]) > 0 for state in first), first
    assert run.cameras, "no camera_info came"
    info = run.cameras[-1]
    assert (info["frame"], info["size"], info["model"], info["rectify"]) == ("hall1_optical_frame", [640, 480], "plumb_bob", 0)
    assert info["k"] == [518.38, 0, 318, 0, 518.07, 239.5, 0, 0, 1] and info["d"] == [0.0895, -0.7064, -0.0034, 0.002, 1.3227]
    assert info["r"] == [1, 0, 0, 0, 1, 0, 0, 0, 1] and info["p"] == [518.38, 0, 318, 0, 0, 518.07, 239.5, 0, 0, 0, 1, 0]


def write_outputs(session, domain, more=""):
    with open(session / "site.yaml", "a") as file:
        file.write(f"outputs:\n  ros2: {{domain: {domain}{more}}}\n")


def drive_session(session, robot, domain, with_odometry, more=""):
    """A recorded drive with ranges and wheels."""
    shutil.copytree(examples / "labyrinth", session)
    lines = (session / "site.yaml").read_text().replace("\n  r:\n", f"\n  {robot}:\n").splitlines(True)
    (session / "site.yaml").write_text("".join(line for line in lines if with_odometry or "odometry:" not in line))
    for name in ("ranges.csv", "odometry.csv"):
        (session / name).write_text((session / name).read_text().replace(",r,", f",{robot},"))
    write_outputs(session, domain, more)
    return session


def hall_session(session, domain):
    """Three cameras, and wheels."""
    subprocess.run([program, "simulate", "li2014", "--duration", "0.5", "-o", str(session)], check=True, stderr=subprocess.DEVNULL)
    write_outputs(session, domain, ", robot_transform: true")  # base_link has its parent already
    return session


with tempfile.TemporaryDirectory() as folder:
    folder = pathlib.Path(folder)
    drive = drive_session(folder / "drive", "r", domain, True)
    bare = drive_session(folder / "bare", "2-r", domain + apart, False, ", robot_transform: true")  # no word of ROS
    hall = hall_session(folder / "hall", domain + 2 * apart)
    drive, bare, hall = Run(drive, domain, "r", 10), Run(bare, domain + apart, "id_2_r", 10), Run(hall, domain + 2 * apart, "r1", 0.15)
    for run in (drive, bare, hall):
        run.finish()
    check_poses(drive)
    check_odometry_chain(drive)
    check_odometry(drive, "base_link")
    check_states(drive, "r")
    check_poses(bare)
    check_robot_transforms(bare, "id_2_r")
    check_odometry(bare, "base_link")
    check_states(bare, "2-r")
    check_poses(hall, 2)
    check_odometry_chain(hall, 2)
    check_states(hall, "r1")
    check_cameras(hall)
    print(f"{len(drive.poses)} of {len(drive.fixes)} poses, {len(drive.transforms)} times map -> odom; "
          f"without odometry {len(bare.poses)} of {len(bare.fixes)}, {len(bare.transforms)} times map -> base_link; "
          f"by cameras {len(hall.poses)} of {len(hall.fixes)}: all as in the fixes file")
