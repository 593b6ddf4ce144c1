"""Files of at most 900 lines, functions of at most 70. A ratchet: what is larger for a reason is
listed in size_known.txt with its size and may not grow; everything else may not cross the mark."""

import re

from tree import SOURCES, Finding, code_only, line_of

FILE_LINES_MAX = 900
FUNCTION_LINES_MAX = 70
KNOWN = "size_known.txt"
CHECKED = (*SOURCES, ".py", ".sh")

_PREPROCESSOR = re.compile(r"^[ \t]*#(?:[^\n\\]|\\.|\\\n)*", re.MULTILINE | re.DOTALL)
_OPENS_SCOPE = re.compile(r"\b(namespace|extern)\b|^\s*(?:template\s*<.*>\s*)?(?:typedef\s+)?"
                          r"(?:class|struct|union|enum)\b[^()]*$", re.DOTALL)
_NAME = re.compile(r"([~\w:]+|operator\s*\S+)\s*\(")


def functions(text):
    """(name, first line, number of lines) of every function body, by matching braces.

    A brace outside of any function begins one when a parameter list stands before it.
    """
    code = _PREPROCESSOR.sub(lambda m: re.sub(r"[^\n]", " ", m.group()), code_only(text))
    stack, head, parens = [], 0, 0
    for match in re.finditer(r"[{}();]", code):
        token, at = match.group(), match.start()
        if token in "()":
            parens += 1 if token == "(" else -1
        elif token == "{":
            before = code[head:at]
            inside = any(kind == "function" for kind, _, _ in stack)
            is_scope = inside or _OPENS_SCOPE.search(before) or "(" not in before
            stack.append(("scope" if is_scope else "function", before, head))
            head = at + 1
        elif token == "}":
            if stack:
                kind, before, start = stack.pop()
                if kind == "function" and code[at + 1:].lstrip()[:1] in (",", "{"):
                    head = start  # a member's initial value; the constructor's body comes later
                    continue
                if kind == "function":
                    first = line_of(code, start + len(before) - len(before.lstrip()))
                    yield _name(before), first, line_of(code, at) - first + 1
            head = at + 1
        elif parens == 0:
            head = at + 1


def _name(before):
    test = re.search(r"\b(?:TEST|TEST_F|TEST_P|TYPED_TEST)\s*\(\s*(\w+)\s*,\s*(\w+)", before)
    if test:
        return f"{test.group(1)}.{test.group(2)}"
    name = _NAME.search(before)
    return name.group(1) if name else "function"


def _over(tree):
    """(key of the list, path, line, lines, limit) of everything beyond its mark."""
    for path in tree.files:
        if not path.endswith(CHECKED) and not tree.text(path).startswith("#!"):
            continue
        lines = tree.text(path).count("\n")
        if lines > FILE_LINES_MAX:
            yield path, path, 0, lines, FILE_LINES_MAX
        if path.endswith(SOURCES):
            for name, line, length in functions(tree.text(path)):
                if length > FUNCTION_LINES_MAX:
                    yield f"{path} {name}", path, line, length, FUNCTION_LINES_MAX


def check(tree):
    # A key is "path" or "path function", with "<= lines" behind it.
    known = {}
    for entry in tree.table(KNOWN):
        key, _, lines = entry.partition(" <= ")
        known[key] = int(lines)
    for key, path, line, lines, limit in _over(tree):
        what = "the file" if key == path else key.removeprefix(path + " ")
        if key not in known:
            yield Finding(path, line, f"{what} has {lines} lines, more than {limit}: look for the "
                                      f"second idea in it (or list it in tools/check.d/{KNOWN})")
        elif lines > known[key]:
            yield Finding(path, line, f"{what} has grown from {known[key]} to {lines} lines: it is "
                                      f"listed in tools/check.d/{KNOWN} because it is too large")
        known.pop(key, None)
    for key in known:
        yield Finding(f"tools/check.d/{KNOWN}", 0, f"{key} is small now, or gone: strike it off")
