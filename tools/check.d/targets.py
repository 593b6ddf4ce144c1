"""No dead files: every source is compiled by some target, every header included by somebody."""

import json
import os
import re

from layers import INCLUDE, PUBLIC, RACK, resolve
from tree import Finding


def projects_apart(tree):
    """Folders with a CMake project of their own: examples and tests that use an installed tims."""
    return [os.path.dirname(f) + "/" for f in tree.files
            if f.endswith("/CMakeLists.txt") and re.search(r"^project\(", tree.text(f), re.MULTILINE)]


def compiled(tree):
    if not tree.commands.exists():
        return None
    root = tree.root.resolve()
    files = (os.path.normpath(os.path.join(c["directory"], c["file"]))
             for c in json.loads(tree.commands.read_text()))
    return {os.path.relpath(f, root) for f in files}


def check(tree):
    in_targets = compiled(tree)
    if in_targets is None:
        yield Finding(str(tree.build), 0, "has no compile_commands.json: tools/dev build release all")
        return
    apart = tuple(projects_apart(tree))
    for path in tree.sources(".cpp", ".c"):
        if path not in in_targets and not path.startswith(apart):
            yield Finding(path, 0, "is compiled by no target: add it to a CMakeLists.txt or delete it")
    included = {resolve(tree, path, name) for path in tree.sources()
                for name in INCLUDE.findall(tree.text(path))}
    for path in tree.sources(".h"):
        if path not in included and not path.startswith((PUBLIC, *RACK, *apart)):
            yield Finding(path, 0, "is included by nobody")
