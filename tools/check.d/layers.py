"""Includes only go down. The table in layers.md is the truth: it is read, not repeated."""

import os
import re

from tree import Finding, line_of

TABLE = "tools/check.d/layers.md"
ROW = re.compile(r"^\| `([^`]+)`( ★)? \|[^|]*\| ([^|]+) \|$", re.MULTILINE)
INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.MULTILINE)
# Public headers lie apart, as they are installed; each belongs to the layer of its sources.
RACK = "proxies/include/", "components/runtime/include/", "components/devices/include/"
SEARCH = ("", "libtims/", "libtims/include/", *RACK)
LAYER_OF_HEADERS = {"proxies/include/rack/codec": "proxies/codec", "proxies/include": "proxies",
                    "components/runtime/include/rack/parameters.h": "components/runtime/logic",
                    "components/runtime/include/rack/data_history.h": "components/runtime/logic",
                    "components/runtime/include": "components/runtime",
                    "components/devices/include/rack/devices/capture.h": "components/recordings",
                    **{f"components/devices/include/rack/devices/{name}.h": "components/devices/io"
                       for name in ("device", "emulator", "recording", "transport", "wakeup")},
                    "components/devices/include/rack/devices/driver.h": "components/devices/drivers",
                    "components/devices/include": "components/devices/core"}
# Those of libtims are values that everybody may use, except those that speak to the system.
PUBLIC = "libtims/include/"
PUBLIC_OF_CLIENT = ("libtims/include/tims.h", "libtims/include/tims/session.h",
                    "libtims/include/tims/mailbox.h")


class Layers:
    def __init__(self, tree):
        self.pure, self.may_use = set(), {}
        rows = ROW.findall(tree.text(TABLE)) if tree.has(TABLE) else []
        folders = [folder for folder, _, _ in rows]
        # "core" is the neighbour of that name, router/core for router/link; else the first one.
        short = {os.path.basename(folder): folder for folder in reversed(folders)}
        for folder, star, uses in rows:
            near = {os.path.basename(f): f for f in folders
                    if os.path.dirname(f) == os.path.dirname(folder)}
            if star:
                self.pure.add(folder)
            names = [n.strip() for n in uses.split(",") if n.strip() not in ("–", "-")]
            self.may_use[folder] = None if names == ["all"] else {
                near.get(n, short.get(n, n)) for n in names}

    def layer_of(self, path):
        """The row a file belongs to: the longest that is its beginning."""
        if path in PUBLIC_OF_CLIENT:
            return "libtims/client"
        if path.startswith(PUBLIC):
            return PUBLIC
        for begin, layer in LAYER_OF_HEADERS.items():
            if path.startswith(begin) and layer in self.may_use:
                return layer
        rows = [r for r in self.may_use if path == r or path.startswith(r + "/")]
        return max(rows, key=len, default=None)

    def allows(self, user, used):
        if user == used or used == PUBLIC:
            return True
        allowed = self.may_use.get(user, set())
        return allowed is None or used in allowed


def resolve(tree, path, included):
    """The project file behind an include, or None."""
    for prefix in (os.path.dirname(path) + "/", *SEARCH):
        candidate = os.path.normpath(prefix + included) if prefix else included
        if tree.has(candidate):
            return candidate
    return None


def check(tree):
    layers = Layers(tree)
    for path in tree.sources():
        user = layers.layer_of(path)
        if user is None:
            yield Finding(path, 0, "lies in no layer: add its folder to tools/check.d/layers.md")
            continue
        text = tree.text(path)
        for match in INCLUDE.finditer(text):
            line = line_of(text, match.start(1))
            target = resolve(tree, path, match.group(1))
            if target is None:
                yield Finding(path, line, f'includes "{match.group(1)}", which is no file of the '
                                          "project: use <...> for others")
                continue
            used = layers.layer_of(target)
            if path.endswith(("_test.cpp", "_fixture.h")) and target.startswith("tests/support/"):
                continue  # a test beside its file, and what several of them share, may use what all tests are made of
            if not layers.allows(user, used):
                yield Finding(path, line, f"{user} may not use {used or target} "
                                          "(tools/check.d/layers.md)")
