"""clang-format over all sources; clang-tidy over the changed ones, two at a time, remembered."""

import hashlib
import json
import os
import re
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor

from layers import resolve
from targets import compiled, projects_apart
from tree import Finding
from words import TEST

CLANG_FORMAT = "clang-format-16"
CLANG_TIDY = "clang-tidy-16"
PARALLEL = 2
INCLUDE = re.compile(r'^\s*#\s*include\s+["<]([^">]+\.h)[">]', re.MULTILINE)
# Projects apart include what is installed with <>: they are analysed like a source of the same
# language here that includes the same headers.
LIKE = {".cpp": "components/examples/simple_module.cpp", ".c": "tests/system/c_api_example.c"}
NEEDS_MORE = "tests/bench/mrpt/"  # includes MRPT, which only its own build installs
_DIAGNOSTIC = re.compile(r"^(?P<path>/[^:\n]+):(?P<line>\d+):\d+: (?:error|warning): (?P<text>.*)$",
                         re.MULTILINE)


def check_format(tree):
    files = tree.sources()
    if not files:
        return
    if not shutil.which(CLANG_FORMAT):
        yield Finding("tools/check", 0, f"{CLANG_FORMAT} is missing: tools/dev setup")
        return
    run = subprocess.run([CLANG_FORMAT, "--dry-run", *files], cwd=tree.root, capture_output=True,
                         text=True, check=False)
    wrong = {}  # the first line of each file; the rest follows from it
    for match in re.finditer(r"^([^:\n]+):(\d+):\d+: (?:warning|error):", run.stderr, re.MULTILINE):
        wrong.setdefault(match.group(1), int(match.group(2)))
    for path, line in wrong.items():
        yield Finding(path, line, f"is not formatted: {CLANG_FORMAT} -i {path}")
    if run.returncode != 0 and not wrong:
        yield Finding(".clang-format", 0, run.stderr.strip())


def changed_files(tree, base):
    """Names of files that differ from `base`, committed or not; None: all of them."""
    commit = tree.git("merge-base", base, "HEAD").stdout.strip()
    if not commit:
        return None
    names = tree.git("diff", "--name-only", commit).stdout
    names += tree.git("ls-files", "--others", "--exclude-standard").stdout
    return set(names.splitlines())


def default_base(tree):
    """Where this work left the main line; the commit before when it is the main line."""
    def commit(name):
        return tree.git("rev-parse", "--verify", "-q", name).stdout.strip()

    main = commit("origin/main")
    return "origin/main" if main and main != commit("HEAD") else "HEAD~1"


class Includes:
    """Which project headers a file needs, through any number of others."""

    def __init__(self, tree):
        self.tree, self._direct = tree, {}

    def direct(self, path):
        if path not in self._direct:
            names = INCLUDE.findall(self.tree.text(path))
            self._direct[path] = {r for n in names if (r := resolve(self.tree, path, n))}
        return self._direct[path]

    def all(self, path):
        seen, open_ = set(), [path]
        while open_:
            new = self.direct(open_.pop()) - seen
            seen |= new
            open_ += new
        return seen


def selected(tree, includes, changed, commands):
    """Sources to look at: the changed ones, and for a changed header one that includes it."""
    sources = [s for s in tree.sources(".cpp", ".c") if s in commands]
    if changed is None or ".clang-tidy" in changed:
        return sources
    chosen = {s for s in sources if s in changed}
    for header in changed & set(tree.sources(".h")):
        users = [s for s in sources if header in includes.all(s)]
        own = [s for s in users if os.path.splitext(s)[0] == os.path.splitext(header)[0]]
        chosen.update((own or users)[:1])
    return sorted(chosen)


def _commands(tree, folder):
    """Each source's command, as clang takes it: without what g++ alone knows, and has precompiled."""
    text = tree.commands.read_text()
    text = re.sub(r" -include [^ ]*/cmake_pch\.hxx| -Winvalid-pch| -fpch-preprocess"
                  r"| -Wno-(restrict|stringop-\w+)", "", text)
    commands = json.loads(text)
    root = tree.root.resolve()
    known = {os.path.relpath(os.path.join(c["directory"], c["file"]), root): c for c in commands}
    apart = tuple(projects_apart(tree))
    for source in tree.sources(*LIKE):
        like = known.get(LIKE[os.path.splitext(source)[1]])
        if like and source.startswith(apart) and not source.startswith(NEEDS_MORE):
            file = str(root / source)
            command = like["command"].replace(like["file"], file)
            known[source] = {**like, "file": file, "command": command}
    (folder / "compile_commands.json").write_text(json.dumps(list(known.values())))
    return {source: c["command"] for source, c in known.items()}


def _key(tree, includes, path, command):
    """Everything the outcome depends on."""
    digest = hashlib.sha256(f"{CLANG_TIDY}\n{command}\n{_extra_checks(path)}\n".encode())
    for name in (".clang-tidy", path, *sorted(includes.all(path))):
        digest.update(name.encode())
        digest.update(tree.text(name).encode())
    return digest.hexdigest()


def _extra_checks(path):
    """The path analyser takes four fifths of the time in tests, and finds next to nothing there."""
    return ["--checks=-clang-analyzer-*"] if re.search(TEST, path) else []


def _run(tree, folder, path):
    command = [CLANG_TIDY, "--quiet", "-p", str(folder), *_extra_checks(path),
               str(tree.root.resolve() / path)]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    if run.returncode == 0:
        return []
    root = tree.root.resolve()
    found = [Finding(os.path.relpath(m["path"], root), int(m["line"]), m["text"])
             for m in _DIAGNOSTIC.finditer(run.stdout)]
    return found or [Finding(path, 0, (run.stdout + run.stderr).strip()[-2000:])]


def check_tidy(tree, changed):
    if not shutil.which(CLANG_TIDY) or compiled(tree) is None:
        yield Finding("tools/check", 0, f"needs {CLANG_TIDY} and {tree.build}: tools/dev build release all")
        return
    folder = tree.build.parent / "check"
    cache = folder / "tidy"
    cache.mkdir(parents=True, exist_ok=True)
    includes, commands = Includes(tree), _commands(tree, folder)

    def look(path):
        good = cache / _key(tree, includes, path, commands[path])
        if good.exists():
            return []
        found = _run(tree, folder, path)
        if not found:
            good.touch()
        return found

    with ThreadPoolExecutor(PARALLEL) as pool:
        for found in {f for fs in pool.map(look, selected(tree, includes, changed, commands)) for f in fs}:
            yield found
