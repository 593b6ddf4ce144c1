"""Every folder of sources has a README.md; every pure source is tested in its folder."""

import os

from layers import PUBLIC, RACK, Layers
from tree import Finding

KNOWN = "tests_elsewhere.txt"


def check_readmes(tree):
    for folder in tree.folders_of(tree.sources(".h", ".cpp", ".c", ".py")):
        if (folder + "/").startswith((PUBLIC, *RACK)):
            continue  # public headers are their own manual
        if not tree.has(os.path.join(folder, "README.md")):
            yield Finding(folder, 0, "has no README.md: describe what is here, and why")


def check_tests(tree):
    """Pure: ★ in layers.md, and router/config, which is pure but for read_files()."""
    pure = Layers(tree).pure | {"router/config"}
    known = tree.table(KNOWN)  # "path test: reason"
    elsewhere = dict(key.split() for key in known)
    for path in tree.sources(".cpp"):
        if path.endswith("_test.cpp") or not any(path.startswith(p + "/") for p in pure):
            continue
        test = elsewhere.pop(path, path.removesuffix(".cpp") + "_test.cpp")
        if not tree.has(test) and not is_included_by_a_test_beside(tree, path):
            yield Finding(path, 0, f"is pure but has no {os.path.basename(test)} beside it")
    for path in elsewhere:
        yield Finding(f"tools/check.d/{KNOWN}", 0, f"{path} is gone: strike it off")


def is_included_by_a_test_beside(tree, path):
    """As a device's dialogue and its other side, which are tested together."""
    include = f'#include "{path.removesuffix(".cpp")}.h"'
    folder = os.path.dirname(path)
    return any(os.path.dirname(test) == folder and include in tree.text(test)
               for test in tree.sources("_test.cpp"))
