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

program, listener, examples = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])
speed = 10  # times as fast as it was recorded
domain = 1 + os.getpid() % 50
# Everything stays on this machine, and on its loopback interface.
loopback = """<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces></General>
<Discovery><Peers><Peer address="127.0.0.1"/></Peers><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>20</MaxAutoParticipantIndex></Discovery>
</Domain></CycloneDDS>"""


class Run:
    """A recorded drive that is run with ROS 2 topics, and what somebody else got of them."""

    def __init__(self, folder, robot, word, domain, change):
        self.folder, self.domain = folder / robot, domain
        shutil.copytree(examples / "labyrinth", self.folder)
        site = (self.folder / "site.yaml").read_text().replace("\n  r:\n", f"\n  {robot}:\n")
        (self.folder / "site.yaml").write_text(change(site))
        for name in ("ranges.csv", "odometry.csv"):
            file = self.folder / name
            file.write_text(file.read_text().replace(",r,", f",{robot},"))
        self.listener = subprocess.Popen([listener, str(domain), word], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                                         env=os.environ | {"CYCLONEDDS_URI": loopback})
        assert self.listener.stdout.readline() == '{"listening": true}\n'
        command = [program, "run", str(self.folder / "site.yaml"), "--no-page", "--speed", str(speed), "--fixes", str(self.folder / "fixes.jsonl")]
        self.program = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=os.environ | {"ROS_LOCALHOST_ONLY": "1"})

    def finish(self):
        said = self.program.communicate(timeout=120)[1]
        assert self.program.returncode == 0, said
        assert f"domain {self.domain}" in said, said
        text = self.listener.communicate(timeout=60)[0]
        assert self.listener.returncode == 0
        messages = [json.loads(line) for line in text.splitlines()]
        self.poses = [m["pose"] for m in messages if "pose" in m]
        self.transforms = [m["transform"] for m in messages if "transform" in m]
        self.states = [m["state"] for m in messages if "state" in m]
        fixes = [(stamp(line), json.loads(line)) for line in (self.folder / "fixes.jsonl").read_text().splitlines()]
        self.fixes = [(time, fix) for time, fix in fixes if fix["status"] != "none"]
        return self


def nanoseconds(text):
    whole, _, part = text.partition(".")
    return int(whole) * 10**9 + int(part.ljust(9, "0")[:9] or 0)


def stamp(line):
    return nanoseconds(line.split('"time": ')[1].split(",")[0])


def time_of(message):
    return message["sec"] * 10**9 + message["nanosec"]


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


def check_poses(run):
    """From the moment on at which the two found each other every fix comes, in their order and as it stands in the file, up to the last. On a machine that has
    no time at all a few may be lost: the last ten are kept, no more."""
    assert len(run.poses) >= 50, f"{len(run.poses)} of {len(run.fixes)} poses came"
    following, places = iter(enumerate(run.fixes)), []
    for pose in run.poses:
        place, fix = next(((i, fix) for i, (time, fix) in following if is_pose(pose, time, fix)), (None, None))
        assert fix, f"no fix, or one out of order: {pose}"
        check_pose(pose, fix)
        places.append(place)
    assert places[-1] == len(run.fixes) - 1, "the last fix did not come"
    assert len(places) > 0.9 * (places[-1] - places[0] + 1), f"{len(places)} came of {places[-1] - places[0] + 1}"


def odometry_of(folder):
    lines = [line.split(",") for line in (folder / "odometry.csv").read_text().split("\n")[1:] if line]
    return [(nanoseconds(time), float(x), float(y), float(yaw)) for time, _, x, y, yaw in lines]


def odometry_at(reports, time):
    i = bisect.bisect_left([report[0] for report in reports], time)
    (t0, *a), (t1, *b) = reports[max(i - 1, 0)], reports[i]
    part = (time - t0) / (t1 - t0) if t1 > t0 else 1
    turn = math.remainder(b[2] - a[2], 2 * math.pi)
    return a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1]), a[2] + part * turn


def check_odometry_chain(run):
    """map -> odom, and odom -> base_link of the wheels, make the fix; base_link has no other parent."""
    reports = odometry_of(run.folder)
    assert len(run.transforms) >= 40, f"{len(run.transforms)} transforms came"
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


def check_robot_transforms(run):
    known = {(time, fix["x"], fix["y"]): fix["yaw"] for time, fix in run.fixes if fix["yaw"] is not None}
    assert len(run.transforms) >= 40, f"{len(run.transforms)} transforms came"
    for transform in run.transforms:
        assert (transform["frame"], transform["child"]) == ("map", "id_2_r/base_link")
        x, y = (round(value, 6) for value in transform["position"][:2])
        same_angle(yaw_of(transform), known[(time_of(transform), x, y)])


def check_states(run, robot):
    states = [state for state in run.states if state["name"] == f"roomfix: robot {robot}"]
    assert states, "no /diagnostics came"
    assert {state["id"] for state in states} == {robot} and all(state["level"] in (0, 1, 2) for state in states)
    assert any(state["values"]["status"] == "ok" and state["level"] == 0 for state in states), states


with tempfile.TemporaryDirectory() as folder:
    folder = pathlib.Path(folder)
    drive = Run(folder, "r", "r", domain, lambda site: site + f"outputs:\n  ros2: {{domain: {domain}}}\n")
    # The same robot without its odometry; its name is no word of ROS.
    without = [line for line in (examples / "labyrinth" / "site.yaml").read_text().splitlines() if "odometry:" in line][0] + "\n"
    outputs = f"outputs:\n  ros2: {{domain: {domain + 50}, robot_transform: true}}\n"
    bare = Run(folder, "2-r", "id_2_r", domain + 50, lambda site: site.replace(without, "") + outputs)
    drive.finish()
    bare.finish()
    check_poses(drive)
    check_odometry_chain(drive)
    check_states(drive, "r")
    check_poses(bare)
    check_robot_transforms(bare)
    check_states(bare, "2-r")
    print(f"{len(drive.poses)} of {len(drive.fixes)} poses, {len(drive.transforms)} times map -> odom; "
          f"without odometry {len(bare.poses)} of {len(bare.fixes)}, {len(bare.transforms)} times map -> base_link: all as in the fixes file")
