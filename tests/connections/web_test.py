"""The page's server: who may ask it, what it says to Prometheus, and that crowds of slow clients do not starve it. The program is in the variable ROOMFIX."""
import base64
import json
import pathlib
import re
import socket
import ssl
import subprocess
import threading
import time
import unittest
import urllib.error
import urllib.request

import jsonschema

from page_crowd import PageCrowd
from peers import Process, certificate, free_port, labyrinth, listens, program, source, temporary_folder, wait_until


def ask(address, headers=None, context=None):
    request = urllib.request.Request(address, headers=headers or {})
    with urllib.request.urlopen(request, timeout=30, context=context) as answer:
        return answer.read().decode()


def change(method, address, token=None, content=None, **headers):
    """Status, type and text of the answer."""
    headers = {name.replace("_", "-"): value for name, value in headers.items()}
    if token:
        headers["Authorization"] = f"Bearer {token}"
    if content is not None:
        headers.setdefault("Content-Type", "application/json")
    body = None if content is None else json.dumps(content).encode()
    try:
        with urllib.request.urlopen(urllib.request.Request(address, method=method, headers=headers, data=body), timeout=30) as answer:
            return answer.status, answer.headers.get_content_type(), answer.read().decode(errors="replace")
    except urllib.error.HTTPError as refused:
        with refused:
            return refused.code, refused.headers.get_content_type(), refused.read().decode()


def strict(schema):
    """A schema that takes no key that it does not describe."""
    if isinstance(schema, list):
        return [strict(one) for one in schema]
    if not isinstance(schema, dict):
        return schema
    schema = {key: strict(value) for key, value in schema.items()}
    if "properties" in schema and schema.get("type") == "object":
        schema["unevaluatedProperties"] = False
    return schema


class Description:
    """What /api/openapi.json says, to hold answers against."""

    def __init__(self, openapi):
        self.openapi = openapi
        self.components = strict(openapi["components"])
        for schema in self.components["schemas"].values():
            jsonschema.Draft202012Validator.check_schema(schema)

    def schema_of(self, path, method="get", status="200", kind="application/json"):
        return self.openapi["paths"][path][method]["responses"][status]["content"][kind]["schema"]

    def check(self, value, schema):
        jsonschema.Draft202012Validator({**strict(schema), "components": self.components}).validate(value)


def pgm(file, width, height):
    file.write_bytes(b"P5 %d %d 255\n" % (width, height) + bytes(254 for _ in range(width * height)))


class Web(unittest.TestCase):
    def setUp(self):
        self.temporary = temporary_folder()
        self.folder = pathlib.Path(self.temporary.name)
        self.addCleanup(self.temporary.cleanup)
        self.port = free_port()

    def serve(self, settings="", *options):
        """The recorded drive in real time, with its page."""
        site = labyrinth(self.folder / "session", f"outputs:\n  web: {{port: {self.port}{settings}}}\n")
        running = Process(self.folder, "roomfix", program, "run", site, *options)
        self.addCleanup(running.stop, True)
        wait_until(lambda: listens(self.port) or running.ended(), "the page is served")
        self.assertFalse(running.ended(), running.text())
        return running

    def test_who_has_no_token_gets_nothing(self):
        certificate(self.folder, "page", "127.0.0.1", 2)
        (self.folder / "token").write_text("open sesame\n")
        self.serve(f", tls: {{certificate: {self.folder}/page.crt, key: {self.folder}/page.key}}, token: {{file: {self.folder}/token}}")
        address = f"https://127.0.0.1:{self.port}"
        context = ssl.create_default_context(cafile=self.folder / "page.crt")
        basic = base64.b64encode(b"anybody:open sesame").decode()
        for authorization in ("Bearer open sesame", f"Basic {basic}"):
            self.assertIn('"name":"labyrinth"', ask(f"{address}/api/site", {"Authorization": authorization}, context))
        wrong = base64.b64encode(b"open sesame:").decode()
        for headers in ({}, {"Authorization": "Bearer open sesam"}, {"Authorization": f"Basic {wrong}"}, {"Authorization": "Basic %%%"}, {"Authorization": "Bearer "}):
            for path in ("/", "/api/site", "/api/state", "/api/events", "/metrics", "/nowhere"):
                with self.assertRaises(urllib.error.HTTPError) as refused:
                    ask(address + path, headers, context)
                self.assertEqual(refused.exception.code, 401)
                refused.exception.close()

    def test_nobody_is_let_in_by_mistake(self):
        site = labyrinth(self.folder / "session", "")
        done = subprocess.run([program, "run", site, "--host", "0.0.0.0", "--port", str(self.port)], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 2)
        self.assertIn("--insecure", done.stderr)
        site = labyrinth(self.folder / "session", f"outputs:\n  web: {{host: 0.0.0.0, token: {{file: token}}}}\n")
        done = subprocess.run([program, "check", site], capture_output=True, text=True, timeout=60)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("'tls'", done.stdout + done.stderr)
        site = labyrinth(self.folder / "session", "outputs:\n  web: {token: secret}\n")
        done = subprocess.run([program, "check", site], capture_output=True, text=True, timeout=60)
        self.assertIn("does not stand in the site file", done.stdout + done.stderr)

    def test_a_certificate_that_does_not_fit_its_key_is_told(self):
        certificate(self.folder, "page", "127.0.0.1", 2)
        certificate(self.folder, "other", "127.0.0.1", 2)
        site = labyrinth(self.folder / "session", f"outputs:\n  web: {{port: {self.port}, tls: {{certificate: {self.folder}/page.crt, key: {self.folder}/other.key}}}}\n")
        done = subprocess.run([program, "run", site], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 2)
        self.assertIn("belong together", done.stderr)

    def test_prometheus_can_read_the_figures(self):
        self.serve()
        address = f"http://127.0.0.1:{self.port}"
        wait_until(lambda: 'roomfix_robot_located{robot="r"} 1\n' in ask(f"{address}/metrics"), "the robot is found")
        text = ask(f"{address}/metrics")
        sample = re.compile(r'^[a-z_]+(\{[a-z]+="[^"]*"(,[a-z]+="[^"]*")*\})? -?[0-9.e+-]+$')
        described = set()
        for line in text.splitlines():
            if line.startswith("# TYPE "):
                described.add(line.split()[2])
            elif not line.startswith("# HELP "):
                self.assertRegex(line, sample)
                self.assertIn(re.split("[{ ]", line)[0], described)
        self.assertIn('roomfix_sink_up{sink="the page"} 1', text)
        self.assertIn("roomfix_robot_sigma_metres", described)

    def test_answers_are_as_they_are_described(self):
        (self.folder / "operator").write_text("turn it\n")
        pgm(self.folder / "plan.pgm", 4, 3)
        site = labyrinth(self.folder / "session", f"outputs:\n  web: {{port: {self.port}, operator: {{file: {self.folder}/operator}}}}\n  history: {{database: {self.folder}/history.db}}\n"
                         f"plan: {{image: {self.folder}/plan.pgm, resolution: 0.5}}\nzones: {{all: [[-50, -50], [50, -50], [50, 50], [-50, 50]]}}\n")
        running = Process(self.folder, "roomfix", program, "run", site)
        self.addCleanup(running.stop, True)
        wait_until(lambda: listens(self.port) or running.ended(), "the page is served")
        address = f"http://127.0.0.1:{self.port}"
        description = Description(json.loads(ask(f"{address}/api/openapi.json")))
        self.assertEqual(description.openapi, json.loads((source / "docs/openapi.json").read_text()))
        wait_until(lambda: "zone_events" in json.loads(ask(f"{address}/api/state")), "the robot is found, and enters the zone")
        wait_until(lambda: ask(f"{address}/api/history?limit=1"), "the history holds something")
        state = json.loads(ask(f"{address}/api/state"))
        self.assertEqual([event["event"] for event in state["zone_events"]], ["enter"])
        self.assertEqual(state["robots"][0]["zones"], ["all"])
        for path in ("/api/site", "/api/state", "/api/access", "/api/openapi.json"):
            description.check(json.loads(ask(address + path)), description.schema_of(path))
        description.check(json.loads(ask(f"{address}/api/robots/r")), description.schema_of("/api/robots/{id}"))
        for line in ask(f"{address}/api/history?limit=50").splitlines():
            fix = json.loads(line)
            description.check(fix, description.schema_of("/api/history", kind="application/x-ndjson"))
        wait_until(lambda: ask(f"{address}/api/history/zones"), "the history has heard of it, too")
        event = json.loads(ask(f"{address}/api/history/zones"))
        description.check(event, description.schema_of("/api/history/zones", kind="application/x-ndjson"))
        self.assertAlmostEqual(event["time"], state["zone_events"][0]["time"], delta=1e-6)
        self.assertEqual({**event, "time": 0}, {**state["zone_events"][0], "time": 0})
        with urllib.request.urlopen(f"{address}/api/events", timeout=30) as events:
            lines = [events.readline().decode().strip() for _ in range(3)]
        self.assertEqual(lines[:2], ["retry: 1000", "event: state"])
        description.check(json.loads(lines[2].removeprefix("data: ")), description.schema_of("/api/state"))
        zone = change("PUT", f"{address}/api/zones/new", "turn it", {"border": [[0, 0], [1, 0], [0, 1]]})
        self.assertEqual(zone[:2], (200, "application/json"), zone)
        description.check(json.loads(zone[2]), description.schema_of("/api/zones/{id}", "put"))

        # Whatever else is answered is described, too: with its status and its type.
        with self.assertRaises(jsonschema.ValidationError):
            description.check({**state, "more": 1}, description.schema_of("/api/state"))
        asked = [("GET", "/api/robots/nobody", "/api/robots/{id}"), ("GET", "/api/cameras/none.jpg", "/api/cameras/{id}.jpg"), ("GET", "/api/plan.png", "/api/plan.png"),
                 ("GET", "/api/history?limit=0", "/api/history"), ("GET", "/api/history/zones?zone=a,b", "/api/history/zones"), ("GET", "/api/history?format=csv", "/api/history"), ("GET", "/metrics", "/metrics"),
                 ("PUT", "/api/zones/a", "/api/zones/{id}"), ("DELETE", "/api/zones/none", "/api/zones/{id}"), ("DELETE", "/api/zones/new", "/api/zones/{id}")]
        for method, path, route in asked:
            status, kind, text = change(method, address + path, "turn it", {"border": []} if method == "PUT" else None)
            described = description.openapi["paths"][route][method.lower()]["responses"]
            self.assertIn(str(status), described, f"{method} {path}: {text}")
            if status != 204:
                self.assertIn(kind, described[str(status)]["content"], f"{method} {path}: {text}")
        for path, item in description.openapi["paths"].items():
            for method in item if path != "/api/events" else ():  # it has no end
                self.assertNotEqual(change(method.upper(), address + path.replace("{id}", "x"))[2], "there is nothing at this address\n", path)

    def test_zones_that_an_operator_draws_are_in_the_site_file_and_in_force(self):
        (self.folder / "operator").write_text("turn it\n")
        running = self.serve(f", operator: {{file: {self.folder}/operator}}")
        file = self.folder / "session/site.yaml"
        before = file.read_text()
        address = f"http://127.0.0.1:{self.port}"
        border = [[-50, -50], [50, -50], [50, 50], [-50, 50]]
        for token, headers, status in ((None, {}, 401), ("turn", {}, 401), ("turn it", {"Origin": "http://evil.example"}, 403), ("turn it", {"Content_Type": "text/plain"}, 403)):
            self.assertEqual(change("PUT", f"{address}/api/zones/all", token, {"border": border}, **headers)[0], status)
        for content, words in (({"border": border[:2]}, "three or more"), ({"border": [border[0], border[2], border[1], border[3]]}, "crosses"), ({"corners": border}, '"border"')):
            status, _, text = change("PUT", f"{address}/api/zones/all", "turn it", content)
            self.assertEqual(status, 400)
            self.assertIn(words, text)
        self.assertEqual(file.read_text(), before)

        wait_until(lambda: json.loads(ask(f"{address}/api/state")).get("robots"), "the robot is found")
        version = json.loads(ask(f"{address}/api/site"))["version"]
        self.assertEqual(change("PUT", f"{address}/api/zones/all", "turn it", {"border": border}, Origin=address)[0], 200)
        self.assertEqual(file.read_text(), before + "zones:\n  all: [[-50, -50], [50, -50], [50, 50], [-50, 50]]\n")
        wait_until(lambda: json.loads(ask(f"{address}/api/robots/r")).get("zones") == ["all"], "the robot is in it")
        site = json.loads(ask(f"{address}/api/site"))
        self.assertEqual([zone["id"] for zone in site["zones"]], ["all"])
        self.assertGreater(site["version"], version)
        self.assertEqual(json.loads(ask(f"{address}/api/state"))["site"], site["version"])
        self.assertEqual(running.text().count("the map is at"), 1, "nothing began anew")
        self.assertEqual(change("DELETE", f"{address}/api/zones/all", "turn it")[0], 204)
        wait_until(lambda: json.loads(ask(f"{address}/api/site"))["zones"] == [], "the zone is gone")
        self.assertEqual(file.read_text(), before)

        file.with_name("site.yaml.new").mkdir()  # as if there were no room
        status, _, text = change("PUT", f"{address}/api/zones/all", "turn it", {"border": border})
        self.assertEqual(status, 500)
        self.assertIn("cannot be written", text)
        file.write_text("nonsense: [\n")
        self.assertEqual(change("PUT", f"{address}/api/zones/all", "turn it", {"border": border})[0], 409)
        self.assertEqual(file.read_text(), "nonsense: [\n")

    def test_a_plan_that_is_damaged_is_told_before_the_start(self):
        (self.folder / "plan.png").write_bytes(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x04\0\0\0\x04")
        site = labyrinth(self.folder / "session", f"plan: {{image: {self.folder}/plan.png, resolution: 0.05}}\noutputs: {{web: {{port: {self.port}}}}}\n")
        for command, code in (("check", 0), ("run", 2), ("doctor", 1)):
            done = subprocess.run([program, command, site], capture_output=True, text=True, timeout=60)
            self.assertEqual(done.returncode, code, done.stdout + done.stderr)
            if code:
                self.assertIn("plan.png: is damaged", done.stdout + done.stderr)

    def test_crowds_of_slow_clients_do_not_starve_the_page(self):
        running = self.serve()
        crowd = PageCrowd(self.port)
        self.addCleanup(crowd.close)
        times = []

        def visit():
            for _ in range(10):
                begin = time.monotonic()
                self.assertIn("robots", json.loads(ask(f"http://127.0.0.1:{self.port}/api/state")))
                times.append(time.monotonic() - begin)

        visitors = [threading.Thread(target=visit) for _ in range(8)]
        for visitor in visitors:
            visitor.start()
        for visitor in visitors:
            visitor.join()
        self.assertEqual(len(times), 80)
        for stream in crowd.streams:
            self.assertIn(b"event: state", stream.recv(4096) + stream.recv(4096))
        self.assertFalse(running.ended())
        times.sort()
        print(f"with 200 idle and slow clients and 100 event streams: median {1e3 * times[40]:.1f} ms, slowest of 80 {1e3 * times[-1]:.1f} ms")


if __name__ == "__main__":
    unittest.main()
