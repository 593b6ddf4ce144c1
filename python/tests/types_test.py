"""The types of the packages and their examples, by mypy."""

import os
import pathlib
import subprocess
import tempfile
import unittest

PYTHON = pathlib.Path(os.environ["TIMS_SOURCES"]) / "python"
TREE = os.environ["PYTHONPATH"].split(":")[0]

USE = """
import tims
import rack.messages as m

session = tims.Session(timeout=1)
mailbox = session.open("Tool(0/7)", slots=4)
with mailbox.peek(timeout=1.0) as message:
    size: int = len(message)
    text: bytes = bytes(message)
maybe = mailbox.try_peek()
ladar = m.LadarProxy(mailbox, "Ladar(0/0)")
angle: float = ladar.get_data().points[0].angle
gain: m.ChassisParamData = m.ChassisProxy(mailbox, 5).get_parameter()
"""
MISUSE = {
    "mailbox.send(5)": "Missing positional argument",
    "ladar.get_data().colour": 'has no attribute "colour"',
    "m.ChassisProxy(mailbox, 5).move(vx='fast')": "incompatible type",
    "maybe.release()": 'has no attribute "release"',
    "session.open()": "Missing positional argument",
}


class Types(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cache = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.cache.cleanup)

    def mypy(self, *files):
        clean = {k: v for k, v in os.environ.items() if k not in ("LD_PRELOAD", "PYTHONPATH", "PYTHONMALLOC")}
        result = subprocess.run(
            ["/usr/bin/mypy", "--strict", "--no-error-summary", "--cache-dir", self.cache.name, *map(str, files)],
            capture_output=True, text=True, env={**clean, "MYPYPATH": TREE})
        return result.stdout + result.stderr

    def test_the_packages_are_typed_strictly(self):
        files = [f"{TREE}/tims", f"{TREE}/rack/__init__.py", *(f"{TREE}/rack/{name}.py" for name in ("codec", "proxy", "messages", "module")),
                 f"{TREE}/rack/generate",
                 *sorted((PYTHON / "examples").glob("*.py"))]
        self.assertEqual(self.mypy(*files), "")

    def test_a_program_is_checked_against_them(self):
        with tempfile.TemporaryDirectory() as folder:
            program = pathlib.Path(folder) / "program.py"
            program.write_text(USE, encoding="utf-8")
            self.assertEqual(self.mypy(program), "")
            program.write_text(USE + "\n".join(MISUSE), encoding="utf-8")
            found = self.mypy(program)
        for text in MISUSE.values():
            self.assertIn(text, found)
        self.assertEqual(found.count("error:"), len(MISUSE), found)


if __name__ == "__main__":
    unittest.main()
