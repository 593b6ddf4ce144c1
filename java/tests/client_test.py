"""The client in Java against a router and components of the build; components in Java, seen by timsctl and Python."""

import json
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

import rack.messages
import tims
from support import PATIENCE, PROGRAMS, Child, component_proxy, eventually

JAVA = (os.environ["TIMS_JAVA"], "-XX:TieredStopAtLevel=1", "-cp", os.environ["TIMS_CLASS_PATH"])


class Client(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.router = f"unix:{self.folder}/r.sock"
        self.ports = ["127.0.0.1:0", "127.0.0.1:0"]
        self.start_router()

    def start_router(self):
        router = Child(PROGRAMS / "tims-router", "--set", f"unix.path={self.folder}/r.sock",
                       "--set", f"tcp.listen={self.ports[0]}", "--set", f"http.listen={self.ports[1]}")
        self.addCleanup(router.end)
        for i, kind in enumerate(("tcp", "http")):
            line = router.wait_for_line(f"listening {kind}")
            self.ports[i] = re.search(r"127\.0\.0\.1:\d+", line).group()
        self.router_process = router

    def start(self, *command):
        child = Child(*command)
        self.addCleanup(child.end)
        return child

    def talk(self, address):
        self.start(PROGRAMS / "SweeperC", "--router", self.router, "--instance", "3", "--period", "10")
        self.wait_for("Ladar(0/3)")
        client = self.start(*JAVA, "ClientTest", address())
        client.wait_for_line("ready")
        self.router_process.end()
        client.wait_for_line("lost")
        self.start_router()
        client.wait_for_line("again")
        self.assertEqual(client.wait(), 0, client.lines)

    def test_over_tcp(self):
        self.talk(lambda: self.ports[0])

    def test_over_a_websocket(self):
        self.talk(lambda: f"ws://{self.ports[1]}")

    def wait_for(self, name):
        session = tims.Session(self.router, timeout=PATIENCE)
        self.addCleanup(session.close)
        return component_proxy(self, session, rack.messages.LadarProxy, name)

    def timsctl(self, *arguments):
        return subprocess.run([PROGRAMS / "timsctl", "-H", self.router, *arguments], capture_output=True, text=True,
                              timeout=PATIENCE)

    def test_a_component_in_java_is_like_any_other(self):
        sweeper = self.start(*JAVA, "Sweeper", "--router", f"ws://{self.ports[1]}", "--period", "20")
        ladar = self.wait_for("Ladar(0/0)")
        self.assertEqual(ladar.status(), tims.Type.DISABLED)
        with self.assertRaisesRegex(tims.AnsweredError, "it is off"):
            ladar.get_data()
        self.assertEqual(self.timsctl("component", "on", "Ladar/0/0").returncode, 0)
        scan = ladar.get_next_data(PATIENCE)
        self.assertEqual((len(scan.points), scan.points[180].distance, scan.duration), (181, 3000, 20))
        self.assertEqual(self.timsctl("component", "param", "set", "Ladar/0/0", "radius", "700").returncode, 0)
        eventually(lambda: ladar.get_next_data(PATIENCE).points[0].distance == 700)
        described = json.loads(self.timsctl("component", "describe", "Ladar/0/0", "--json").stdout)
        self.assertEqual((described["program"], described["class"], described["purpose"]), ("Sweeper", "Ladar", "Scans a round room."))
        rows = {row["name"]: row for row in described["parameters"]}
        self.assertEqual([rows["radius"][key] for key in ("type", "min", "max", "unit", "help", "takes_effect")],
                         ["int", 100, 30000, "mm", "radius of the room", "on"])
        self.assertEqual(described["outputs"][0]["period"], "period")
        echoed = self.timsctl("msg", "echo", "Ladar/0/0", "-n", "2")
        self.assertEqual(echoed.returncode, 0, echoed.stderr)
        self.assertIn("700", echoed.stdout)
        with self.assertRaisesRegex(tims.AnsweredError, "radius is 5, allowed are 100 to 30000"):
            ladar.set_parameter("radius", 5)
        with self.assertRaisesRegex(tims.AnsweredError, "unknown command 21"):
            ladar._command(21, None, None)
        now = ladar.get_data()
        self.assertEqual(ladar.get_data(now.recordingTime).recordingTime, now.recordingTime)
        with self.assertRaisesRegex(tims.AnsweredError, "no longer available"):
            ladar.get_data((now.recordingTime - 3_600_000) % 2**32)
        shown = self.start(*JAVA, "ShowScans", self.ports[0], "2")
        shown.wait_for_line("181 points, nearest at 700 mm")
        self.assertEqual(shown.wait(), 0, shown.lines)
        self.assertEqual(self.timsctl("component", "off", "Ladar/0/0").returncode, 0)
        eventually(lambda: ladar.status() == tims.Type.DISABLED)
        sweeper.process.terminate()
        sweeper.wait()
        eventually(lambda: "NOT_AVAILABLE" in self.status_error(ladar) or "is it running" in self.status_error(ladar))

    @staticmethod
    def status_error(proxy):
        try:
            return str(proxy.status())
        except tims.NoMailbox as error:
            return str(error)

    def test_what_the_command_line_refuses(self):
        for arguments, text in ((("--speed", "1"), "there is no parameter speed"), (("--period",), "has no value"),
                                (("--period", "5"), "allowed are 10 to 60000"), (("x",), "is no option")):
            child = self.start(*JAVA, "Sweeper", *arguments)
            child.wait_for_line(text)
            self.assertEqual(child.wait(), 2)
        child = self.start(*JAVA, "Sweeper", "--help")
        child.wait_for_line("--radius")
        self.assertEqual(child.wait(), 0)


if __name__ == "__main__":
    unittest.main()
