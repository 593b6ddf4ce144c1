"""The files of the project, read once, and the findings of rules."""

import os
import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

SOURCES = (".h", ".cpp", ".c")


@dataclass(frozen=True, order=True)
class Finding:
    path: str
    line: int  # 0: the whole file
    text: str

    def __str__(self):
        return f"{self.path}:{self.line}: {self.text}" if self.line else f"{self.path}: {self.text}"


class Tree:
    """The project's own files: what git knows or would add. `build` is where it was built.
    `commands`: how each source is compiled by itself."""

    def __init__(self, root, build=None):
        self.root = Path(root)
        self.build = Path(build) if build else self.root / "build" / "release"
        alone = self.build.parent / "commands"
        self.commands = (alone if alone.exists() else self.build) / "compile_commands.json"
        self.files = sorted(self._list())
        self._texts = {}

    def text(self, path):
        if path not in self._texts:
            self._texts[path] = (self.root / path).read_text(errors="replace")
        return self._texts[path]

    def sources(self, *suffixes):
        return [f for f in self.files if f.endswith(suffixes or SOURCES)]

    def has(self, path):
        return (self.root / path).exists()

    def folders_of(self, files):
        return sorted({os.path.dirname(f) for f in files})

    def git(self, *arguments):
        # A checkout that belongs to somebody else, as in containers, is fine to read.
        command = ["git", "-c", "safe.directory=*", "-C", str(self.root), *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    def table(self, name):
        """Exceptions of a rule, one a line: `what: reason`. An entry without reason is an error."""
        path = f"tools/check.d/{name}"
        entries = {}
        for number, line in enumerate(self.text(path).splitlines() if self.has(path) else [], 1):
            if not line.strip() or line.startswith("#"):
                continue
            what, _, reason = line.partition(": ")
            if not reason.strip():
                raise ValueError(f"{path}:{number}: an exception needs a reason")
            entries[what.strip()] = reason.strip()
        return entries

    def _list(self):
        listed = self.git("ls-files", "-z", "--cached", "--others", "--exclude-standard")
        if listed.returncode == 0:
            return {f for f in listed.stdout.split("\0") if f and (self.root / f).is_file()}
        # Not a repository: an unpacked archive.
        every = {str(p.relative_to(self.root)) for p in self.root.rglob("*") if p.is_file()}
        return {f for f in every if not f.startswith(("build/", ".git/"))}


_NOISE = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"(?P<mark>[^(\s]*)\(.*?\)(?P=mark)"|"(?:\\.|[^"\\\n])*"'
    r"|(?<![0-9A-Fa-f])'(?:\\.|[^'\\\n])+'", re.DOTALL)


def code_only(text):
    """C++ with comments and literals blanked out; line numbers and columns stay."""
    return _NOISE.sub(lambda m: re.sub(r"[^\n]", " ", m.group()), text)


def line_of(text, offset):
    return text.count("\n", 0, offset) + 1
