"""Words and constructs that are not written here, and what to write instead."""

import re
from dataclasses import dataclass

from tree import SOURCES, Finding, code_only, line_of

KNOWN = "words_known.txt"


@dataclass(frozen=True)
class Banned:
    name: str      # as words_known.txt calls it
    pattern: str
    instead: str
    where: str = ""         # a regular expression for paths; empty: everywhere
    but: str = "^$"         # except these
    comments: bool = False  # search comments and texts too, in every text file


TEST = r"(^tests/|_test\.(cpp|py)$|_contract\.h$)"
BENCH = r"^tests/bench/"  # paces what it measures
PROGRAM = r"^(tools/|tests/|python/bench/|components/|router/program/)"

BANNED = [
    Banned("todo", r"\b(TODO|FIXME|XXX|HACK)\b", "do it, or leave it out", comments=True),
    Banned("using-std", r"\busing\s+namespace\s+std\s*;", "name what you use"),
    Banned("singleton", r"(::\s*instance\s*\(\s*\)|\b[gG]etInstance\b|\bstatic\s+\w+\s*&\s*instance\b)",
           "build it in main and hand it over"),
    Banned("sleep", r"\b(sleep_for|sleep_until|usleep|nanosleep)\s*\(|\bsleep\s*\(\s*\d",
           "wait for the condition (tests/support/eventually.h)", where=TEST, but=BENCH),
    Banned("sleep", r"\b(sleep_for|usleep)\s*\(|\bsleep\s*\(\s*\d",
           "wait for what you are waiting for; timers belong to the loop", but=TEST),
    Banned("print", r"\b(printf|fprintf|puts|putchar)\s*\(|\bstd::(cout|cerr|clog)\b",
           "only programs print: return the text or log it", but=PROGRAM),
    Banned("iostream", r"#\s*include\s*<iostream>", "only programs print", but=PROGRAM),
    Banned("endl", r"\bstd::endl\b", "'\\n'"),
    Banned("rand", r"\b(rand|srand|drand48)\s*\(", "<random> with a seed that is handed in"),
    Banned("unbounded", r"\b(gets|strcpy|strcat|sprintf|vsprintf|strtok|alloca)\s*\(",
           "std::string, std::span or a bounded function"),
    Banned("atoi", r"\b(atoi|atol|atoll|atof)\s*\(", "std::from_chars: it reports errors"),
    Banned("shell", r"\b(system|popen)\s*\(", "run the program itself (tests/support/child_process.h)",
           where=r"\.(cpp|h|c)$"),
    Banned("detach", r"\.detach\s*\(\s*\)", "somebody must own the thread and join it"),
    Banned("goto", r"\bgoto\b", "a function with a return"),
    Banned("regex", r"\bstd::regex\b", "std::string_view and from_chars", but=TEST),
    Banned("fence", r"\batomic_thread_fence\b",
           "acquire and release on the variables themselves: sanitizers do not see fences",
           but=BENCH),
    Banned("toml", r"#\s*include\s*<toml\+\+/", "libtims/base/toml.h",
           but=r"^libtims/base/toml\.cpp$"),
    Banned("boost", r"#\s*include\s*<boost/", "Boost belongs to the router and the tools",
           where=r"^(libtims|proxies|router/core|router/config)/",
           # Boost.PFR: headers only, nothing at run time. Boost.JSON: what programs only have.
           but=r"^proxies/(include/rack/codec/reflect\.h|(message_files|gdos_texts)\.cpp)$"),
]


def _hits(tree, banned, path):
    text = tree.text(path)
    if not banned.comments:
        text = code_only(text)
    for match in re.finditer(banned.pattern, text):
        yield line_of(text, match.start())


def check(tree):
    known = tree.table(KNOWN)  # "path name: reason"
    used = set()
    for path in tree.files:
        is_source = path.endswith(SOURCES)
        for banned in BANNED:
            searched = is_source or (banned.comments and _is_text(path))
            if not searched or not re.search(banned.where, path) or re.search(banned.but, path):
                continue
            for line in _hits(tree, banned, path):
                key = f"{path} {banned.name}"
                used.add(key)
                if key not in known:
                    yield Finding(path, line, f"{banned.name}: instead, {banned.instead}")
    for key in set(known) - used:
        yield Finding(f"tools/check.d/{KNOWN}", 0, f"{key} is gone: strike it off")


def _is_text(path):
    in_check = path.startswith("tools/check")  # its rules and bad examples name what they look for
    return not in_check and path.endswith((".md", ".txt", ".cmake", ".py", ".toml", ".yml", ".sh",
                                           "CMakeLists.txt", "tools/dev"))
