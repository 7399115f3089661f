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

from peers import Process, certificate, free_port, labyrinth, listens, program, temporary_folder, wait_until


def ask(address, headers=None, context=None):
    request = urllib.request.Request(address, headers=headers or {})
    with urllib.request.urlopen(request, timeout=30, context=context) as answer:
        return answer.read().decode()


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

    def test_crowds_of_slow_clients_do_not_starve_the_page(self):
        running = self.serve()
        open_sockets = []
        self.addCleanup(lambda: [one.close() for one in open_sockets])

        def connect(first):
            one = socket.create_connection(("127.0.0.1", self.port), timeout=30)
            open_sockets.append(one)
            one.sendall(first)
            return one

        for _ in range(160):
            connect(b"")  # idle
        for _ in range(20):
            connect(b"GET /api/state HTTP/1.1\r\nHost: ")  # a request that never ends
        for _ in range(20):
            connect(b"GET /api/events HTTP/1.1\r\nHost: x\r\n\r\n")  # listens, but takes nothing
        streams = [connect(b"GET /api/events HTTP/1.1\r\nHost: x\r\n\r\n") for _ in range(100)]
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
        for stream in streams:
            self.assertIn(b"event: state", stream.recv(4096) + stream.recv(4096))
        self.assertFalse(running.ended())
        times.sort()
        print(f"with 200 idle and slow clients and 100 event streams: median {1e3 * times[40]:.1f} ms, slowest of 80 {1e3 * times[-1]:.1f} ms")


if __name__ == "__main__":
    unittest.main()
