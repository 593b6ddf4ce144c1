"""Components in Python: what timsctl, proxies and other components see of them."""

import json
import os
import pathlib
import signal
import subprocess
import sys
import threading
import unittest
import unittest.mock

import rack
import tims
import rack.messages
from rack.messages import LadarProxy, PilotProxy
from support import PATIENCE, PROGRAMS, Child, WithRouter, component_proxy, eventually

EXAMPLES = pathlib.Path(os.environ["TIMS_SOURCES"]) / "python" / "examples"

THERMOMETER = '''
import os, sys, threading, time
import rack, tims
from rack.messages import ClockData

class Limited(rack.DataModule[ClockData]):
    """Counts."""
    DATA, CLASS_ID, CLASS_NAME = ClockData, 150, "Counter"
    PARAMETERS = [rack.integer("period", 20, "period [ms]", 10, 60000), rack.real("gain", 0.5, "gain", 0, 2),
                  rack.text("mode", "", "what to do", takes_effect=rack.NOW)]
    count = 0

    def module_init(self):
        if self.text("mode") == "no init": raise rack.Refused("there is no sensor")

    def module_on(self):
        if self.text("mode") == "no on": raise rack.Refused("the sensor is not plugged in")
        if self.text("mode") == "broken": self.nothing_has_this_name
        self.period = self.integer("period")
        self.print("counts from %d with %g" % (self.count, self.real("gain")))

    def module_loop(self):
        self.sleep_until_next()
        if self.text("mode") == "fail": raise OSError("the sensor is gone")
        self.count += 1
        self.put(ClockData(recordingTime=rack.time_stamp(), utcTime=self.count))

    def module_off(self): self.print("off")

    def module_command(self, command):
        if command.type == 21: self.count = command.decode(ClockData).utcTime; command.reply()
        elif command.type == 22: command.reply(-22, ClockData(utcTime=self.count))
        elif command.type == 23: command.later(lambda: self.slow(command))
        elif command.type == 24: raise tims.Timeout(tims.Code.TIMEOUT, "the sensor does not answer")
        elif command.type == 25: self.stop()
        elif command.type == 26: command.later(lambda: {}[5])
        elif command.type == 27: command.later(lambda: command.reply(-22, ClockData(utcTime=self.count)))
        elif command.type == 28: command.decode(ClockData); self.set_parameter("period", 2**32 + 50)
        elif command.type == 29: self.period = -1
        elif command.type == 30: command.reply(300)
        else: super().module_command(command)

    def slow(self, command):
        while self.text("mode") != "go": time.sleep(0.002)
        command.reply(-22, ClockData(utcTime=self.count))

sys.exit(Limited().run())
'''


STRAIGHT = '''
import sys
import rack
from rack.messages import OdometryData, OdometryProxy, Position3d

class Straight(rack.DataModule[OdometryData]):
    """Drives straight on: x is the time."""
    DATA, CLASS_ID, HISTORY, AHEAD = OdometryData, OdometryProxy.CLASS_ID, 64, 300
    PARAMETERS = [rack.integer("broken", 0, "what between() does", 0, 2, takes_effect=rack.NOW)]
    at = 0

    def module_on(self): self.period, self.at = 10, 1000

    def module_loop(self):
        self.sleep_until_next()
        if self.at < 2000: self.put(OdometryData(recordingTime=self.at, pos=Position3d(x=10 * self.at)))
        self.at += 100

    def between(self, before, after, time):
        if self.integer("broken") == 1: raise rack.Refused("there is no road")
        if self.integer("broken") == 2: return None
        part = (time - before.recordingTime) / (after.recordingTime - before.recordingTime)
        x = before.pos.x + part * (after.pos.x - before.pos.x)
        return OdometryData(recordingTime=time, pos=Position3d(x=round(x)))

sys.exit(Straight().run())
'''


CAMERA = '''
import sys
import rack
from rack.messages import CameraData, CameraProxy

class Camera(rack.DataModule[CameraData]):
    """Pictures in JPEG."""
    DATA, CLASS_ID = CameraData, CameraProxy.CLASS_ID

    def module_on(self): self.period = 10

    def module_loop(self):
        self.sleep_until_next()
        image = b"\\xff\\xd8 a picture \\xff\\xd9"
        self.put(CameraData(recordingTime=rack.time_stamp(), mode=41, colorFilterId=len(image), image=image))

sys.exit(Camera().run())
'''


class Components(WithRouter):
    def start(self, *command):
        component = Child(sys.executable, "-u", *command)
        self.addCleanup(component.end)
        return component

    def counter(self, *arguments):
        file = self.folder / "counter.py"
        file.write_text(THERMOMETER, encoding="utf-8")
        return self.start(file, *arguments)

    def proxy(self, kind, name):
        session = self.session()
        self.addCleanup(session.close)
        return component_proxy(self, session, kind, name)

    def counter_proxy(self, instance=0):
        return self.proxy(CounterProxy, self.session().make_address(0, 150, instance))

    def timsctl(self, *arguments):
        clean = {k: v for k, v in os.environ.items() if k != "LD_PRELOAD"}
        return subprocess.run([PROGRAMS / "timsctl", "-H", self.router, *arguments], capture_output=True, text=True,
                              env=clean, timeout=PATIENCE)

    def test_a_component_of_twenty_lines_is_like_any_other(self):
        self.start(EXAMPLES / "sweeper.py", "--instance", "3")
        ladar = self.proxy(LadarProxy, "Ladar(0/3)")
        self.assertEqual(ladar.status(), tims.Type.DISABLED)
        ladar.on()
        scan = ladar.get_data()
        self.assertEqual((len(scan.points), scan.points[0].distance), (181, 3000))
        shown = self.timsctl("component", "param", "get", "Ladar/0/3")
        self.assertIn("radius", shown.stdout + shown.stderr)
        self.timsctl("component", "param", "set", "Ladar/0/3", "radius", "2000")
        eventually(lambda: ladar.get_next_data(PATIENCE).points[0].distance == 2000)
        echoed = self.timsctl("msg", "echo", "Ladar/0/3", "-n", "2")
        self.assertEqual(echoed.returncode, 0, echoed.stderr)
        self.assertIn("2000", echoed.stdout)
        # At the time of a scan that it has kept, and of none.
        now = ladar.get_data()
        self.assertEqual(ladar.get_data(now.recordingTime).recordingTime, now.recordingTime)
        with self.assertRaisesRegex(tims.AnsweredError, "no longer available"):
            ladar.get_data((now.recordingTime - 3_600_000) % 2**32)
        self.assertEqual(self.timsctl("component", "off", "Ladar/0/3").returncode, 0)
        self.assertEqual(ladar.status(), tims.Type.DISABLED)

    def test_it_is_recorded_and_described_as_any_other(self):
        self.start(EXAMPLES / "sweeper.py", "--instance", "11", "--targetStatus", "1", "--radius", "2345")
        self.proxy(LadarProxy, "Ladar(0/11)")
        described = json.loads(self.timsctl("component", "describe", "Ladar/0/11", "--json").stdout)
        self.assertEqual((described["program"], described["class"]), ("Sweeper", "Ladar"))
        self.assertIn("radius", [row["name"] for row in described["parameters"]])
        folder = self.folder / "recorded"
        folder.mkdir()
        recorder = Child(PROGRAMS / "DatalogRec", "--router", self.router, "--record", "Ladar(0/11)", "--logPathName",
                         f"{folder}/", "--targetStatus", "1")
        self.addCleanup(recorder.end)
        eventually(lambda: any(b"2345" in file.read_bytes() for file in folder.iterdir()), "a scan is recorded")

    def test_one_in_c_is_too(self):
        self.addCleanup(Child(PROGRAMS / "SweeperC", "--router", self.router, "--instance", "6", "--period", "10").end)
        ladar = self.proxy(LadarProxy, "Ladar(0/6)")
        ladar.on()
        scan = ladar.get_next_data(PATIENCE)
        self.assertEqual((len(scan.points), scan.points[180].distance, scan.duration), (181, 3000, 10))
        ladar.set_parameter("radius", 500)
        eventually(lambda: ladar.get_next_data(PATIENCE).points[0].distance == 500)
        with self.assertRaisesRegex(tims.AnsweredError, "unknown command"):
            ladar._command(21, None, None)
        self.assertIn("radius", ladar.describe()["purpose"] + json.dumps(ladar.describe()))
        # And in timsctl.
        self.assertEqual(self.timsctl("component", "param", "set", "Ladar/0/6", "radius", "700").returncode, 0)
        eventually(lambda: ladar.get_next_data(PATIENCE).points[0].distance == 700)
        echoed = self.timsctl("msg", "echo", "Ladar/0/6", "-n", "1")
        self.assertEqual(echoed.returncode, 0, echoed.stderr)
        self.assertIn("700", echoed.stdout)
        self.assertEqual(self.timsctl("component", "off", "Ladar/0/6").returncode, 0)
        self.assertEqual(ladar.status(), tims.Type.DISABLED)

    def test_data_between_those_that_were_recorded(self):
        file = self.folder / "straight.py"
        file.write_text(STRAIGHT, encoding="utf-8")
        self.start(file, "--instance", "5")
        odometry = self.proxy(rack.messages.OdometryProxy, "Odometry(0/5)")
        odometry.on()
        eventually(lambda: odometry.get_data().recordingTime == 1900)
        for time in (1000, 1001, 1250, 1899, 1900, 1950, 2200):
            data = odometry.get_data(time)
            self.assertEqual((data.recordingTime, data.pos.x), (time, 10 * time))
        with self.assertRaisesRegex(tims.AnsweredError, "no longer available"):
            odometry.get_data(999)
        with self.assertRaisesRegex(tims.AnsweredError, "not available yet"):
            odometry.get_data(2201)
        odometry.set_parameter("broken", 1)
        with self.assertRaisesRegex(tims.AnsweredError, "there is no road"):
            odometry.get_data(1250)
        odometry.set_parameter("broken", 2)
        with self.assertRaisesRegex(tims.AnsweredError, "encode"):
            odometry.get_data(1250)
        self.assertEqual(odometry.get_data().recordingTime, 1900)

    def test_it_describes_itself(self):
        out = subprocess.run([sys.executable, EXAMPLES / "wall_follower.py", "--describe"], capture_output=True, text=True,
                             check=True).stdout
        described = json.loads(out)
        self.assertEqual(described["program"], "WallFollower")
        self.assertIn("along the wall", described["purpose"])
        self.assertIn("ladarInst", out)
        self.assertIn('"Chassis"', out)
        help_text = subprocess.run([sys.executable, EXAMPLES / "sweeper.py", "--help"], capture_output=True, text=True,
                                   check=True).stdout
        self.assertIn("radius of the room [mm] (3000; a whole number from 100 to 30000)", help_text)
        wrong = subprocess.run([sys.executable, EXAMPLES / "sweeper.py", "--radius", "5"], capture_output=True, text=True)
        self.assertEqual(wrong.returncode, 2)
        self.assertIn("radius", wrong.stderr)

    def test_commands_are_answered(self):
        self.counter()
        counter = self.counter_proxy()
        self.assertEqual(counter.parameters()["gain"], 0.5)
        counter.set_count(1000)
        counter.on()
        self.assertGreater(counter.get_count(), 1000)
        with self.assertRaisesRegex(tims.AnsweredError, "unknown command"):
            counter._command(99, None, None)
        with self.assertRaisesRegex(tims.AnsweredError, "the sensor does not answer"):
            counter._command(24, None, None)
        with self.assertRaisesRegex(tims.AnsweredError, "ClockData has at least"):
            counter._ask(21, b"x", (0,))
        with self.assertRaisesRegex(tims.AnsweredError, r"KeyError: 5 \(counter.py:\d+\)"):
            counter._command(26, None, None)
        self.assertEqual(counter.status(), tims.Type.ENABLED)

    def test_a_long_command_lets_others_be_answered(self):
        self.counter("--instance", "1")
        counter = self.counter_proxy(1)
        slow = rack.messages.ClockData
        result = []
        mailbox = self.session().open("Tool(0/20)", slots=4)
        self.addCleanup(mailbox.close)
        other = CounterProxy(mailbox, counter.component, counter.timeouts)
        thread = threading.Thread(target=lambda: result.append(other._query(23, None, (-22,), slow, PATIENCE).utcTime))
        thread.start()
        for _ in range(20):
            counter.get_count()
        self.assertEqual(result, [])
        counter.set_parameter("mode", "go")
        thread.join(PATIENCE)
        self.assertEqual(len(result), 1)

    def test_many_long_commands_at_once(self):
        """The worker and the command task meet at the interpreter's lock and at that of the worker."""
        self.counter("--instance", "7")
        counter = self.counter_proxy(7)
        answered = []

        def ask(local):
            mailbox = self.session().open(f"Tool(0/{local})", slots=8)
            self.addCleanup(mailbox.close)
            other = CounterProxy(mailbox, counter.component, counter.timeouts)
            for _ in range(500):
                other._query(27, None, (-22,), rack.messages.ClockData, PATIENCE)
            answered.append(local)

        threads = [threading.Thread(target=ask, args=(21 + i,)) for i in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(len(answered), 4)

    def test_numbers_that_do_not_fit_are_refused(self):
        self.counter("--instance", "8")
        counter = self.counter_proxy(8)
        for command, text in ((28, "period is 4294967346"), (29, "period is -1"), (30, "type is 300")):
            with self.assertRaisesRegex(tims.AnsweredError, text):
                counter._command(command, rack.messages.ClockData(), None)

    def test_exceptions_that_are_kept_hold_no_slot(self):
        self.counter("--instance", "9")
        counter = self.counter_proxy(9)
        kept = []
        for call in (lambda: counter._command(99, None, None),
                     lambda: counter._query(22, None, (-22,), rack.messages.LadarData, None)):
            for _ in range(8):
                with self.assertRaises(tims.Error) as caught:
                    call()
                kept.append(caught.exception.with_traceback(caught.exception.__traceback__))
                self.assertEqual(counter.work.held, 0, kept[-1])

    def test_errors_turn_it_off_and_it_comes_back(self):
        component = self.counter("--instance", "2", "--errorTimeout", "10")
        counter = self.counter_proxy(2)
        for mode, reason in (("no on", "the sensor is not plugged in"), ("broken", "AttributeError")):
            counter.set_parameter("mode", mode)
            with self.assertRaises(tims.AnsweredError):
                counter.on()
            component.wait_for_line(reason)
        counter.set_parameter("mode", "")
        eventually(lambda: counter.status() == tims.Type.ENABLED, "on again")
        counter.set_parameter("mode", "fail")
        component.wait_for_line("the sensor is gone")
        counter.set_parameter("mode", "")
        eventually(lambda: counter.status() == tims.Type.ENABLED, "on again")

    def test_it_ends_as_others(self):
        for end in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
            component = self.counter("--instance", "4", "--targetStatus", "1")
            component.wait_for_line("counts from 0 with 0.5")
            component.process.send_signal(end)
            self.assertEqual(component.wait(), 0, component.lines)
            self.assertTrue(any("off" in line for line in component.lines), component.lines)
        component = self.counter("--instance", "4")
        counter = self.counter_proxy(4)
        counter.work.send(counter.component, 25)  # stop()
        self.assertEqual(component.wait(), 0, component.lines)

    def test_it_does_not_start(self):
        component = self.counter("--instance", "5", "--mode", "no init")
        self.assertEqual(component.wait(), 1)
        self.assertIn("there is no sensor", "\n".join(component.lines))

    def test_misuse_is_named(self):
        class Silly(rack.Module):
            CLASS_ID = 151

        silly = Silly()
        with self.assertRaisesRegex(RuntimeError, "does not run"):
            silly.integer("system")
        with self.assertRaisesRegex(KeyError, "radius is not among the PARAMETERS of Silly"):
            silly.integer("radius")
        caught = []

        def elsewhere():
            try:
                silly.run([])
            except RuntimeError as error:
                caught.append(str(error))

        thread = threading.Thread(target=elsewhere)
        thread.start()
        thread.join()
        self.assertEqual(caught, ["a component runs in the main thread of its program"])

    def test_the_wall_follower_drives(self):
        moved = threading.Event()
        session = self.session()
        chassis = session.open("Chassis(0/0)", slots=16)
        self.addCleanup(chassis.close)

        def serve():
            while True:
                try:
                    command = chassis.receive(PATIENCE)
                except tims.Error:
                    return
                if command.type == 21 and rack.messages.ChassisMoveData.decode(command).vx == 150:
                    moved.set()
                chassis.reply(command, tims.Type.OK)

        server = threading.Thread(target=serve, daemon=True)
        server.start()
        self.start(EXAMPLES / "sweeper.py")
        self.proxy(LadarProxy, "Ladar(0/0)").work.close()
        self.start(EXAMPLES / "wall_follower.py", "--speed", "150", "--targetStatus", "1")
        self.assertTrue(moved.wait(PATIENCE))
        pilot = self.proxy(PilotProxy, "Pilot(0/0)")
        eventually(lambda: pilot.status() == tims.Type.ENABLED)
        self.assertEqual(pilot.get_data().speed, 150)
        pilot.off()
        chassis.close()
        server.join(PATIENCE)


    def test_the_notebook_reads_a_scan(self):
        self.start(EXAMPLES / "sweeper.py", "--targetStatus", "1")
        self.proxy(LadarProxy, "Ladar(0/0)").work.close()
        cells = json.loads((EXAMPLES / "plot_scan.ipynb").read_text(encoding="utf-8"))["cells"]
        names = {}
        drawn = unittest.mock.MagicMock()  # matplotlib needs 43 packages, 320 MB
        with unittest.mock.patch.dict(sys.modules, {"matplotlib": drawn, "matplotlib.pyplot": drawn.pyplot}):
            for cell in cells:
                if cell["cell_type"] == "code":
                    exec(compile("".join(cell["source"]), "plot_scan.ipynb", "exec"), names)
        self.assertAlmostEqual(float(names["x"].max()), 3.0, places=3)
        drawn.pyplot.plot.assert_called_once_with(names["x"], names["y"], ".")
        self.assertEqual(names["x"].shape, names["y"].shape)
        names["work"].close()

    def test_the_camera_reader_shows_pictures(self):
        sys.path.insert(0, str(EXAMPLES))
        self.addCleanup(sys.path.remove, str(EXAMPLES))
        import camera_reader

        grey = rack.messages.CameraData(width=3, height=2, depth=8, mode=1, image=bytes(range(6)))
        self.assertEqual(camera_reader.picture(grey).tolist(), [[0, 1, 2], [3, 4, 5]])
        colour = rack.messages.CameraData(width=1, height=1, depth=24, mode=11, image=b"\1\2\3")
        self.assertEqual(camera_reader.picture(colour).tolist(), [[[3, 2, 1]]])
        with self.assertRaisesRegex(ValueError, "mode 21"):
            camera_reader.picture(rack.messages.CameraData(mode=21))
        # A stream in JPEG. OpenCV, of 28 packages, is not among those of the tests.
        file = self.folder / "camera.py"
        file.write_text(CAMERA, encoding="utf-8")
        self.start(file)
        self.proxy(rack.messages.CameraProxy, "Camera(0/0)").work.close()
        opencv = unittest.mock.MagicMock()
        opencv.waitKey.return_value = ord("q")
        with unittest.mock.patch.dict(sys.modules, {"cv2": opencv}), unittest.mock.patch.object(sys, "argv", ["camera_reader"]):
            self.assertEqual(camera_reader.main(), 0)
        self.assertEqual(opencv.imdecode.call_args.args[0].tobytes(), b"\xff\xd8 a picture \xff\xd9")
        opencv.imshow.assert_called_once_with("Camera(0/0)", opencv.imdecode.return_value)


class CounterProxy(rack.DataProxy[rack.messages.ClockData]):
    CLASS_ID, DATA = 150, rack.messages.ClockData

    def set_count(self, count):
        self._command(21, rack.messages.ClockData(utcTime=count), None)

    def get_count(self):
        return self._query(22, None, (-22,), rack.messages.ClockData, None).utcTime


if __name__ == "__main__":
    unittest.main()
