"""The codec against that of C++, proxies against real components, and what the generator writes."""

import json
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import rack.codec
import rack.messages as messages
import tims
from support import PATIENCE, PROGRAMS, Child, WithRouter, eventually

SOURCES = pathlib.Path(os.environ["TIMS_SOURCES"])


def vectors(seed):
    out = subprocess.run([PROGRAMS / "tims-schema", "--vectors", "--seed", str(seed)], capture_output=True, check=True)
    for line in out.stdout.decode("utf-8", "surrogateescape").splitlines():
        name, order, body, result = line.split(" ", 3)
        yield getattr(messages, name), order == "little", b"" if body == "-" else bytes.fromhex(body), result


def plain(value):
    """As JSON has it."""
    if isinstance(value, rack.codec.Struct):
        return {each.name: plain(getattr(value, each.name)) for each in value.layout.fields if each.type != "count"}
    if isinstance(value, list):
        return [plain(each) for each in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


class Codec(unittest.TestCase):
    def test_bodies_of_all_structs_are_those_of_cpp(self):
        self.maxDiff = 2000
        count = damaged = 0
        for struct, little, body, result in vectors(7):
            count += 1
            if result.startswith("!"):
                damaged += 1
                with self.assertRaises(rack.codec.CodecError, msg=f"{struct} {body.hex()}") as caught:
                    struct.decode(body, little)
                self.assertEqual(str(caught.exception), result[1:].strip())
                continue
            value = struct.decode(body, little)
            self._compare(plain(value), json.loads(result), struct.__name__)
            again = struct.decode(value.encode(little), little)
            self.assertEqual(value.encode(little), again.encode(little))
            if len(body) == len(value.encode(little)) and not _has_text(struct):
                self.assertEqual(_quiet(body), _quiet(value.encode(little)), struct.__name__)
        self.assertGreater(count, 200)
        self.assertGreater(damaged, 50)

    def _compare(self, ours, theirs, path):
        if isinstance(theirs, dict):
            for name, value in theirs.items():
                if name in ours:  # not the counts
                    self._compare(ours[name], value, f"{path}.{name}")
        elif isinstance(theirs, list) and isinstance(ours, list):
            self.assertEqual(len(ours), len(theirs), path)
            for i, (a, b) in enumerate(zip(ours, theirs)):
                self._compare(a, b, f"{path}[{i}]")
        elif isinstance(theirs, (int, float)) and isinstance(ours, (int, float)):
            self.assertTrue(math.isclose(ours, theirs, rel_tol=1e-6, abs_tol=1e-44), f"{path}: {ours} {theirs}")

    def test_truncated_bodies_are_never_read_beyond(self):
        for struct, little, body, result in vectors(3):
            if result.startswith("!"):
                continue
            for cut in {0, 1, len(body) // 2, max(len(body) - 1, 0)}:
                try:
                    struct.decode(body[:cut], little)
                except rack.codec.CodecError:
                    pass

    def test_defaults_are_those_of_cpp(self):
        self.assertEqual(messages.CameraParamData().sx, 1.0)
        self.assertEqual(messages.Scan2dData().sectorNum, 1)
        self.assertEqual(messages.ChassisData().activePilot, 0xFFFFFF00)

    def test_values_that_do_not_fit_are_named(self):
        for value, text in (
            (messages.ChassisMoveData(vx=2**31), "ChassisMoveData.vx is 2147483648: expected a whole number from "
             "-2147483648 to 2147483647"),
            (messages.ChassisMoveData(vx=0.5), "ChassisMoveData.vx is 0.5"),
            (messages.ChassisMoveData(omega="fast"), "ChassisMoveData.omega is fast: expected a number"),
            (messages.Parameter(name="x" * 80), "Parameter.name has 80 bytes, allowed are 79: shorten it"),
            (messages.LadarData(points=[messages.LadarPoint()] * 2161), "has 2161 elements, allowed are 2160: send fewer"),
            (messages.LadarData(points=[7]), "LadarData.points is 7: expected LadarPoint"),
            (messages.CameraData(width=2, height=2, depth=8, image=b"abc"), "has 3 elements, but the other fields give 4"),
            (messages.CameraParamData(coordinateRotation=[1.0]), "has 1 elements, not 9"),
            (messages.FileName(name="x" * 128), "has 128 elements, allowed are 127"),
        ):
            with self.assertRaises(rack.codec.CodecError) as caught:
                value.encode()
            self.assertIn(text, str(caught.exception))
        self.assertEqual(len(messages.FileName(name="x").encode()), 132)
        self.assertEqual(len(messages.Parameter(name="x" * 79).encode()), 172)

    def test_text_that_is_not_utf_8_stays_what_it_is(self):
        body = messages.FileName(name="x").encode().replace(b"x", b"\xe4")
        self.assertEqual(messages.FileName.decode(body).encode(), body)

    def test_si_units(self):
        self.assertAlmostEqual(messages.ChassisData(vx=250.0).si("vx"), 0.25)
        with self.assertRaises(AttributeError):
            messages.ChassisData().si("speed")

    def test_arrays_lie_on_the_body(self):
        import numpy

        scan = messages.LadarData(recordingTime=5, points=[
            messages.LadarPoint(angle=-1.5, distance=1234, type=0x80, intensity=-1), messages.LadarPoint(distance=7)])
        for little in (True, False):
            body = scan.encode(little)
            view = messages.LadarData.arrays(body, little)
            self.assertEqual((view.recordingTime, len(view.points)), (5, 2))
            self.assertEqual(list(view.points["distance"]), [1234, 7])
            self.assertAlmostEqual(float(view.points["angle"][0]), -1.5)
            self.assertFalse(view.points.flags.writeable)
            self.assertEqual(view.encode(little), body)
            self.assertEqual(view.encode(not little), scan.encode(not little))
            # The memory is the body's: no copy was made.
            self.assertTrue(numpy.shares_memory(view.points, numpy.frombuffer(body, numpy.uint8)))

    def test_nothing_needs_numpy_but_arrays(self):
        code = ("import sys; sys.modules['numpy'] = None\n"
                "import rack.messages as m\n"
                "assert m.LadarData.decode(m.LadarData(points=[m.LadarPoint(distance=3)]).encode()).points[0].distance == 3\n")
        subprocess.run([sys.executable, "-c", code], check=True)


def _has_text(struct):
    return any(each.type in ("text", "char") or each.inner is not None and _has_text(each.inner)
               for each in struct.layout.fields)


def _quiet(body):
    """Python's floats quiet a signalling NaN of 32 bits: one bit of it."""
    return bytes(each | 0x40 for each in body)


class Proxies(WithRouter):
    def start(self, program, *arguments):
        component = Child(PROGRAMS / program, "--router", self.router, *arguments)
        self.addCleanup(component.end)
        return component

    def proxy(self, kind, name, **options):
        work = self.session().open("Tool(0/9)", slots=4, body_max=70000)
        self.addCleanup(work.close)
        proxy = kind(work, name, rack.proxy.Timeouts(on=PATIENCE, off=PATIENCE, data=PATIENCE), **options)
        eventually(lambda: _status(proxy), f"{name} is there")
        return proxy

    def test_a_component_is_commanded(self):
        self.start("ClockSystem")
        clock = self.proxy(messages.ClockProxy, "Clock(0/0)")
        self.assertEqual(clock.status(), tims.Type.DISABLED)
        with self.assertRaisesRegex(tims.AnsweredError, r"Clock\(0/0\), GET_DATA: the component is off"):
            clock.get_data()
        clock.on()
        self.assertEqual(clock.status(), tims.Type.ENABLED)
        self.assertIsInstance(clock.get_data(), messages.ClockData)
        self.assertGreaterEqual(clock.get_next_data(PATIENCE).recordingTime, 0)
        parameters = clock.parameters()
        self.assertIn("gdosLevel", parameters)
        clock.set_parameter("gdosLevel", 4)
        self.assertEqual(clock.parameters()["gdosLevel"], 4)
        with self.assertRaisesRegex(tims.AnsweredError, "SET_PARAM"):
            clock.set_parameter("gdosLevel", 5)
        self.assertEqual(clock.describe()["program"], "ClockSystem")
        clock.off()

    def test_a_stream_is_read_until_the_component_is_off(self):
        self.start("ClockSystem", "--instance", "1")
        clock = self.proxy(messages.ClockProxy, "Clock(0/1)")
        clock.on()
        data = self.session().open("Tool(0/10)", slots=8)
        self.addCleanup(data.close)
        times = []
        with self.assertRaisesRegex(tims.AnsweredError, "ended its stream"):
            for each in clock.stream(data, timeout=PATIENCE):
                times.append(each.recordingTime)
                if len(times) == 2:
                    clock.off()
        self.assertGreaterEqual(len(times), 2)

    def test_nobody_is_there(self):
        work = self.session().open("Tool(0/11)")
        self.addCleanup(work.close)
        with self.assertRaisesRegex(tims.NoMailbox, r"Ladar\(7/7\), ON"):
            messages.LadarProxy(work, "Ladar(7/7)").on(PATIENCE)

    def test_an_answer_that_is_no_such_message(self):
        session = self.session()
        other = session.open("Ladar(0/3)")
        work = session.open("Tool(0/12)")
        for each in (other, work):
            self.addCleanup(each.close)
        import threading

        def answer():
            request = other.receive(PATIENCE)
            other.send(work.address, 0, seq_nr=(request.seq_nr + 1) % 256)  # to another request
            other.reply(request, tims.Type.DATA, b"short")

        thread = threading.Thread(target=answer)
        thread.start()
        with self.assertRaisesRegex(tims.Malformed, "LadarData has at least 24 bytes, not 5 bytes"):
            messages.LadarProxy(work, "Ladar(0/3)").get_data(timeout=PATIENCE)
        thread.join()


def _status(proxy):
    try:
        return proxy.status() is not None
    except tims.NoMailbox:
        return False


THERMOMETER = {
    "rack_messages": 1, "class": "Thermometer", "class_id": "0x90",
    "structs": [
        {"name": "ThermometerData", "made": "0000000007000000", "fields": [
            {"name": "recordingTime", "type": "time", "unit": "ms", "si_unit": "s", "si": 0.001},
            {"name": "temperature", "type": "i32", "unit": "mK", "si_unit": "K", "si": 0.001}]}],
    "messages": [{"type": -6, "name": "DATA", "body": "ThermometerData"},
                 {"type": 21, "name": "SET_LIMIT", "body": "ThermometerData"},
                 {"type": 22, "name": "GET_LIMIT"}, {"type": -22, "name": "LIMIT", "body": "ThermometerData"}]}


class Generated(unittest.TestCase):
    def generate(self, text, *options):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "thermometer.json"
            file.write_text(text, encoding="utf-8")
            return subprocess.run([sys.executable, "-m", "rack.generate", *options, file], capture_output=True, text=True)

    def test_own_messages(self):
        result = self.generate(json.dumps(THERMOMETER))
        self.assertEqual(result.returncode, 0, result.stderr)
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "thermometer.py").write_text(result.stdout, encoding="utf-8")
            code = ("import thermometer as t\n"
                    "assert t.ThermometerData().temperature == 7 and t.ThermometerProxy.CLASS_ID == 144\n"
                    "assert t.ThermometerProxy.get_limit.__annotations__['return'] == 'ThermometerData'\n"
                    "assert t.ThermometerType.SET_LIMIT == 21\n"
                    "assert t.ThermometerData.decode(t.ThermometerData(1, -2).encode()).temperature == -2\n")
            subprocess.run([sys.executable, "-c", code], check=True,
                           env={**os.environ, "PYTHONPATH": folder + ":" + os.environ["PYTHONPATH"]})

    @unittest.skipUnless(shutil.which("gcc"), "needs a compiler")
    def test_own_messages_in_c(self):
        result = self.generate(json.dumps(THERMOMETER), "--c")
        self.assertEqual(result.returncode, 0, result.stderr)
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            (folder / "thermometer.h").write_text(result.stdout, encoding="utf-8")
            (folder / "main.c").write_text(
                '#include <rack_messages.h>\n#include "thermometer.h"\n'
                "int main(void) {\n  struct rack_ThermometerData data;\n  uint8_t body[RACK_BODY_MAX_ThermometerData];\n"
                "  rack_init_ThermometerData(&data);\n"
                "  return !(data.temperature == 7 && RACK_CLASS_THERMOMETER == 144 && RACK_THERMOMETER_SET_LIMIT == 21 &&\n"
                "           rack_encode_ThermometerData(&data, 0, body, sizeof body, NULL) == 8 && body[7] == 7);\n}\n",
                encoding="utf-8")
            includes = [f"-I{each}" for each in (SOURCES / "proxies" / "include", SOURCES / "libtims" / "include",
                                                 PROGRAMS.parent / "include")]
            clean = {k: v for k, v in os.environ.items() if k != "LD_PRELOAD"}
            subprocess.run(["gcc", "-std=c11", "-Wall", "-Wextra", "-Wconversion", "-Werror", *includes, "main.c", "-o", "main"],
                           cwd=folder, check=True, env=clean)
            subprocess.run([folder / "main"], check=True, env=clean)

    def test_what_is_no_description(self):
        for text in ("", "{}", "[1]", '{"structs": [], "class": "X", "class_id": "x", "messages": []}'):
            result = self.generate(text)
            self.assertEqual(result.returncode, 1)
            self.assertIn("no description of messages", result.stderr)


if __name__ == "__main__":
    unittest.main()
