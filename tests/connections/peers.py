"""Real peers for the tests of connections: each is started on a free port of this machine and ended with the test."""
import json
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import tempfile
import time

source = pathlib.Path(__file__).resolve().parents[2]
program = os.environ.get("ROOMFIX", source / "build/release/bin/roomfix")
# DDS of this machine only.
loopback_only = os.environ | {"ROS_LOCALHOST_ONLY": "1"}
cyclone_on_loopback = os.environ | {"CYCLONEDDS_URI": (
    '<CycloneDDS><Domain><General><Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces></General><Discovery><Peers><Peer address="127.0.0.1"/></Peers>'
    "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>20</MaxAutoParticipantIndex></Discovery></Domain></CycloneDDS>")}


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def wait_until(holds, what, longest=30):
    end = time.monotonic() + longest
    while not holds():
        if time.monotonic() > end:
            raise AssertionError(f"waited {longest} s in vain until {what}")
        time.sleep(0.02)


def listens(port):
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


class Process:
    """A program that runs until it is stopped; what it prints goes to a file."""

    def __init__(self, folder, name, *command, **more):
        self.output = pathlib.Path(folder) / f"{name}.out"
        with open(self.output, "ab") as out:
            self.process = subprocess.Popen([str(word) for word in command], stdout=out, stderr=subprocess.STDOUT, **more)

    def text(self):
        return self.output.read_text(errors="replace")

    def lines(self):
        return self.text().splitlines()

    def ended(self):
        return self.process.poll() is not None

    def stop(self, kill=False):
        if not self.ended():
            self.process.kill() if kill else self.process.terminate()
        return self.process.wait(30)


class Broker:
    """Mosquitto. `settings`: lines of its configuration beside the listener."""

    def __init__(self, folder, *settings):
        self.folder, self.port = pathlib.Path(folder), free_port()
        self.file = self.folder / "mosquitto.conf"
        self.file.write_text("\n".join([f"listener {self.port} 127.0.0.1", "user root" if os.getuid() == 0 else "", *settings]) + "\n")
        self.start()

    def start(self):
        self.process = Process(self.folder, "mosquitto", shutil.which("mosquitto") or "/usr/sbin/mosquitto", "-c", self.file)
        wait_until(lambda: listens(self.port), "Mosquitto listens")

    def stop(self, kill=False):
        self.process.stop(kill)

    def subscribe(self, name, topic="#", *options):
        """A subscriber whose file gets a line TOPIC TAB PAYLOAD per message."""
        subscriber = Process(self.folder, name, "mosquitto_sub", "-p", self.port, "-V", "mqttv5", "-t", topic, "-F", "%t\t%p", *options)
        subscriber.messages = lambda: [line.split("\t", 1) for line in subscriber.lines() if "\t" in line]
        return subscriber

    def retained(self, topic):
        """What a newcomer gets of a topic at once."""
        asked = subprocess.run(["mosquitto_sub", "-p", str(self.port), "-t", topic, "--retained-only", "-W", "2", "-C", "1"], capture_output=True, text=True)
        return asked.stdout.strip()


class Postgres:
    """A PostgreSQL server without a port, in a folder that it owns, for it does not run as root."""

    def __init__(self, folder):
        self.outputs, self.folder = folder, pathlib.Path(tempfile.mkdtemp(prefix="roomfix-test-"))
        self.programs = next(pathlib.Path("/usr/lib/postgresql").glob("*/bin"))
        self.user = {"user": 65534, "group": 65534, "extra_groups": []} if os.getuid() == 0 else {}
        if self.user:
            os.chown(self.folder, 65534, 65534)
        made = [self.programs / "initdb", "-D", self.folder / "data", "-U", "roomfix", "-A", "trust", "-E", "UTF8", "--no-sync", "--no-locale"]
        subprocess.run([str(word) for word in made], check=True, capture_output=True, cwd="/", **self.user)
        self.address = f"postgresql://roomfix@/postgres?host={self.folder}"
        self.start()

    def start(self):
        settings = [word for value in ("listen_addresses=", "fsync=off", "shared_buffers=1MB", "max_connections=8") for word in ("-c", value)]
        self.process = Process(self.outputs, "postgres", self.programs / "postgres", "-D", self.folder / "data", "-k", self.folder, *settings, cwd="/", **self.user)
        wait_until(lambda: subprocess.run([self.programs / "pg_isready", "-q", "-h", self.folder]).returncode == 0, "PostgreSQL answers")

    def stop(self, kill=False):
        """Killed: as if the machine lost its power, nobody is said good-bye."""
        self.process.process.send_signal(signal.SIGQUIT if kill else signal.SIGINT)
        self.process.process.wait(30)

    def remove(self):
        if not self.process.ended():
            self.stop(True)
        shutil.rmtree(self.folder)

    def ask(self, query):
        asked = subprocess.run(["psql", "-h", str(self.folder), "-U", "roomfix", "-AtF,", "-c", query, "postgres"], capture_output=True, text=True, check=True)
        return [line.split(",") for line in asked.stdout.splitlines()]


def certificate(folder, name, host, days, ca=None):
    """A key and its certificate by openssl, FOLDER/NAME.key and .crt; signed by itself or by `ca`."""
    key, request, signed, names = (pathlib.Path(folder) / f"{name}.{ending}" for ending in ("key", "csr", "crt", "ext"))
    names.write_text(f"subjectAltName={'IP' if host[0].isdigit() else 'DNS'}:{host}\n" + ("" if ca else "basicConstraints=critical,CA:TRUE\n"))
    curve = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1"]
    by = ["-CA", f"{folder}/{ca}.crt", "-CAkey", f"{folder}/{ca}.key", "-CAcreateserial"] if ca else ["-signkey", key]
    for command in (["req", "-new", *curve, "-nodes", "-keyout", key, "-out", request, "-subj", f"/CN={name}"],
                    ["x509", "-req", "-in", request, "-out", signed, "-days", days, "-extfile", names, *by]):
        subprocess.run(["openssl", *[str(word) for word in command]], check=True, capture_output=True)


def labyrinth(folder, outputs, seconds=None):
    """The recorded drive of examples/labyrinth, or its beginning, with outputs of its own. Gives the site file."""
    shutil.copytree(source / "examples/labyrinth", folder, dirs_exist_ok=True)
    for recorded in ("ranges.csv", "odometry.csv") if seconds else ():
        header, *lines = (pathlib.Path(folder) / recorded).read_text().splitlines()
        start = float(lines[0].split(",")[0])
        kept = [line for line in lines if float(line.split(",")[0]) < start + seconds]
        (pathlib.Path(folder) / recorded).write_text("\n".join([header, *kept]) + "\n")
    file = pathlib.Path(folder) / "site.yaml"
    file.write_text(file.read_text() + outputs)
    return file


def fixes_of(file):
    """All but one that is being written just now."""
    return [json.loads(line) for line in pathlib.Path(file).read_text().split("\n")[:-1]]


def temporary_folder():
    return tempfile.TemporaryDirectory(prefix="roomfix-test-")
