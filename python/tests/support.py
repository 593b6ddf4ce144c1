"""A router and programs of the build for tests; ctest names the folder of programs in TIMS_PROGRAMS."""

import os
import pathlib
import queue
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import rack
import tims

PROGRAMS = pathlib.Path(os.environ["TIMS_PROGRAMS"])
PATIENCE = 60.0  # s, for what takes milliseconds: a busy machine is no failure


def eventually(condition, what="the condition"):
    """Waits until it holds; returns its value."""
    end = time.monotonic() + PATIENCE
    while not (value := condition()):
        if time.monotonic() > end:
            raise AssertionError(f"{what} did not become true in {PATIENCE:.0f} s")
        time.sleep(0.005)
    return value


def component_proxy(test, session, kind, name):
    """A proxy of this kind, once the component is there; the test closes its mailbox."""
    work = session.open("Tool(0/9)", slots=4, body_max=70000)
    test.addCleanup(work.close)
    proxy = kind(work, name, rack.Timeouts(on=PATIENCE, off=PATIENCE, data=PATIENCE))

    def there():
        try:
            return proxy.status() is not None
        except tims.NoMailbox:
            return False

    eventually(there, f"{name} is there")
    return proxy


class Child:
    """A program whose lines can be waited for; it ends with the test."""

    def __init__(self, *command, env=None, cwd=None):
        clean = {k: v for k, v in os.environ.items() if k != "LD_PRELOAD"}
        python = pathlib.Path(str(command[0])).name.startswith("python")
        self.process = subprocess.Popen(
            [str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            env={**(os.environ if python else clean), **(env or {})}, cwd=cwd)
        self.lines = []
        self._queue = queue.Queue()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        for line in self.process.stdout:
            self._queue.put(line.rstrip("\n"))
        self._queue.put(None)

    def wait_for_line(self, part):
        end = time.monotonic() + PATIENCE
        while True:
            line = self._queue.get(timeout=max(end - time.monotonic(), 0.01))
            if line is None:
                raise AssertionError(f"it ended without the line {part!r}:\n" + "\n".join(self.lines))
            self.lines.append(line)
            if part in line:
                return line

    def wait(self):
        """The exit status; the rest of its output is in `lines`."""
        status = self.process.wait(PATIENCE)
        self._reader.join(PATIENCE)
        while (line := self._queue.get()) is not None:
            self.lines.append(line)
        return status

    def end(self):
        if self.process.poll() is None:
            self.process.terminate()
            try:
                self.process.wait(PATIENCE)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        self._reader.join(PATIENCE)
        self.process.stdout.close()


def python(code, *arguments, env=None):
    """A child that runs this code with the packages under test."""
    return Child(sys.executable, "-u", "-c", code, *arguments, env=env)


def start_router(folder):
    router = Child(PROGRAMS / "tims-router", "--set", f"unix.path={folder}/r.sock", "--set", "tcp.listen=off",
                   "--set", "http.listen=off")
    router.wait_for_line("listening unix")
    return router


class WithRouter(unittest.TestCase):
    """One router for the tests of a class."""

    @classmethod
    def setUpClass(cls):
        cls._folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls._folder.cleanup)
        cls.folder = pathlib.Path(cls._folder.name)
        cls.router = f"unix:{cls.folder}/r.sock"
        cls.router_process = start_router(cls.folder)
        cls.addClassCleanup(cls.router_process.end)
        os.environ["TIMS_ROUTER"] = cls.router

    def session(self, **options):
        session = tims.Session(self.router, timeout=PATIENCE, **options)
        self.addCleanup(session.close)
        return session

    def pair(self, **options):
        """Two mailboxes of one session."""
        session = self.session()
        a = session.open("Tool(1/40)", **options)
        b = session.open("Tool(1/41)", **options)
        self.addCleanup(a.close)
        self.addCleanup(b.close)
        return a, b

    def child(self, code, *arguments):
        child = python(code, *arguments)
        self.addCleanup(child.end)
        return child
