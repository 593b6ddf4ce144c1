"""Writes Python for the messages of a description: data classes of their bodies, types, and proxies.

    python3 -m rack.generate thermometer.json > thermometer.py

The description is what tims-schema prints, or a message file of one class (share/rack/messages). This file imports
nothing of the package: the package is made by it.
"""

from __future__ import annotations

import json
import keyword
import pprint
import struct
import sys
from typing import Any, Optional

_INT = {"i8": "b", "u8": "B", "i16": "h", "u16": "H", "i32": "i", "u32": "I", "i64": "q", "u64": "Q", "byte": "B",
        "char": "B", "time": "I", "address": "I", "count": "i"}
_FLOAT = {"f32": "f", "f64": "d"}
_CODES = {**_INT, **_FLOAT}
# Answers that the name of their command does not tell: (class, command) to the answer's name.
_ANSWERS = {("World", "PUT"): "OBSTACLE", ("Planner", "GET_COMMAND"): "COMMAND"}


class Generator:
    def __init__(self, description: dict[str, Any]) -> None:
        self.structs: list[dict[str, Any]] = description["structs"]
        self.by_name = {each["name"]: each for each in self.structs}
        self.is_own = "rack_messages" in description
        self.classes = description.get("classes") or [
            {"id": int(str(description["class_id"]), 0), "name": description["class"],
             "messages": description["messages"]}]
        self.values = {each["field"]: each for each in description.get("values", [])}
        self.out: list[str] = []

    def text(self) -> str:
        self.out = [
            '"""Written by rack.generate from the description of the messages: do not change it here."""', "",
            "from __future__ import annotations", "",
            "import enum", "from dataclasses import dataclass, field", "from typing import Any, Mapping", "",
            "from rack.codec import Layout, Struct", "from rack.proxy import DataProxy, Proxy", "",
            "_structs: dict[str, type[Struct]] = {}", "", "",
            "def _laid_out(cls: type[Struct], description: Mapping[str, Any]) -> None:",
            "    cls.layout = Layout(description, _structs)",
            "    cls.layout.type = cls",
            "    _structs[cls.__name__] = cls", "",
        ]
        for each in self.structs:
            self._struct(each)
        for each in self.classes:
            if each["messages"]:
                self._class(each)
        self._table()
        return "\n".join(self.out) + "\n"

    # --- structs

    def _struct(self, of: dict[str, Any]) -> None:
        made = _Made(self.by_name).of(of, bytes.fromhex(of["made"]))
        self.out += ["", "@dataclass", f"class {of['name']}(Struct):"]
        shown = [each for each in of["fields"] if each["type"] != "count"]
        for each in shown:
            line = f"    {each['name']}: {self._type(each)} = {self._default(each, made[each['name']])}"
            comment = self._comment(of["name"], each)
            self.out.append(line + (f"  # {comment}" if comment else ""))
        if not shown:
            self.out.append("    pass")
        self.out += ["", "", f"_laid_out({of['name']}, {pprint.pformat(self._plain(of), width=116, sort_dicts=False)})",
                     ""]

    def _plain(self, of: dict[str, Any]) -> dict[str, Any]:
        return {key: value for key, value in of.items() if key != "made"}

    def _comment(self, struct_name: str, of: dict[str, Any]) -> str:
        known = self.values.get(f"{struct_name}.{of['name']}")
        if known is None:
            return str(of.get("unit", ""))
        names = [f"{value} {name}" for name, value in known["names"].items()]
        return ", ".join(names + [f"+{value} {name}" for name, value in known["flags"].items()])

    def _type(self, of: dict[str, Any]) -> str:
        variable = "at_most" in of or "tail_at_most" in of
        kind = str(of["type"])
        if variable and kind in ("byte", "u8"):
            return "bytes"
        if variable and kind == "char":
            return "str"
        one = "int" if kind in _INT else "float" if kind in _FLOAT else kind
        one = "str" if one == "text" else one
        return f"list[{one}]" if variable or "times" in of else one

    def _default(self, of: dict[str, Any], made: Any) -> str:
        if isinstance(made, (list, dict)):
            inner = self.by_name.get(of["type"])
            if isinstance(made, dict) and inner is not None and made == self._made_of(inner):
                return f"field(default_factory=lambda: {of['type']}())"
            return f"field(default_factory=lambda: {self._literal(of, made)})" if made else "field(default_factory=list)"
        return self._literal(of, made)

    def _made_of(self, of: dict[str, Any]) -> dict[str, Any]:
        return _Made(self.by_name).of(of, bytes.fromhex(of["made"]))

    def _literal(self, of: dict[str, Any], made: Any) -> str:
        if isinstance(made, list):
            return "[" + ", ".join(self._literal(of, each) for each in made) + "]"
        if not isinstance(made, dict):
            return repr(made)
        inner = {each["name"]: each for each in self.by_name[of["type"]]["fields"]}
        return f"{of['type']}(" + ", ".join(f"{k}={self._literal(inner[k], v)}" for k, v in made.items()) + ")"

    # --- classes

    def _class(self, of: dict[str, Any]) -> None:
        messages = of["messages"]
        self.out += ["", f"class {of['name']}Type(enum.IntEnum):"]
        names: set[str] = set()
        for message in messages:
            if message["name"] not in names:
                self.out.append(f"    {message['name']} = {message['type']}")
            names.add(message["name"])
        data = next((m.get("body") for m in messages if m["type"] == -6), None)
        base = f"DataProxy[{data}]" if data else "Proxy"
        self.out += ["", "", f"class {of['name']}Proxy({base}):", f"    CLASS_ID = {of['id']}"]
        if data:
            self.out.append(f"    DATA = {data}")
        commands = {each["type"]: each["name"] for each in messages if each["type"] > 0}
        if commands:
            self.out.append(f"    COMMANDS = {commands!r}")
        for message in messages:
            if message["type"] > 0 and not self._is_answer(of, message):
                self._method(of, message)
        self.out.append("")

    def _answers(self, of: dict[str, Any], command: dict[str, Any]) -> list[dict[str, Any]]:
        name = command["name"]
        wanted = _ANSWERS.get((of["name"], name)) or (
            name[4:] if name.startswith("GET_") else name.split("_TO_")[1] if "_TO_" in name else "")
        return [each for each in of["messages"] if each["name"] == wanted and each.get("body")]

    def _is_answer(self, of: dict[str, Any], message: dict[str, Any]) -> bool:
        """Of a type above 0, as STATUS of Pilot."""
        return any(message in self._answers(of, each) for each in of["messages"]
                   if each is not message and each["name"] != message["name"] and each["type"] > 0
                   and (of["name"], each["name"]) not in _ANSWERS)

    def _method(self, of: dict[str, Any], message: dict[str, Any]) -> None:
        name = message["name"].lower()
        name += "_" if keyword.iskeyword(name) else ""
        arguments, body = self._arguments(message.get("body"))
        answers = self._answers(of, message)
        answer = answers[0]["body"] if answers else None
        self.out += ["", f"    def {name}(self{arguments}, *, within: float | None = None) -> {answer}:"]
        call = f"{message['type']}, {body}"
        if answer:
            types = ", ".join(str(each["type"]) for each in answers)
            self.out.append(f"        return self._query({call}, ({types},), {answer}, within)")
        else:
            self.out.append(f"        self._command({call}, within)")

    def _arguments(self, body: Optional[str]) -> tuple[str, str]:
        """The fields of a body if they are few and plain, else the body."""
        if body is None:
            return "", "None"
        fields = self.by_name[body]["fields"]
        lists = {"times", "at_most", "tail_at_most"}
        plain = all(each["type"] in (*_CODES, "text") and (each["type"] == "char" or not lists & each.keys())
                    for each in fields)
        if not plain:
            return f", body: {body}", "body"
        fields = [each for each in fields if each["type"] != "count"]
        made = self._made_of(self.by_name[body])
        arguments = "".join(f", {each['name']}: {self._type(each)} = {made[each['name']]!r}" for each in fields)
        return arguments, f"{body}(" + ", ".join(each["name"] for each in fields) + ")"

    def _table(self) -> None:
        self.out += ["", "# Bodies by class and type of the message: what a program shows that it does not know.",
                     "BODIES: dict[tuple[int, int], type[Struct]] = {"]
        for each in self.classes:
            for message in each["messages"]:
                if "body" in message:
                    self.out.append(f"    ({each['id']}, {message['type']}): {message['body']},")
        self.out += ["}", "", "CLASS_NAMES: dict[int, str] = {"]
        self.out += [f"    {each['id']}: {each['name']!r}," for each in self.classes]
        self.out += ["}"]
        if self.is_own:
            own = self.classes[0]
            self.out += ["", "import tims", "", f"tims.name_class({own['id']}, {own['name']!r})"]


class _Made:
    """Default values out of a default body: sequences are empty there."""

    def __init__(self, structs: dict[str, dict[str, Any]]) -> None:
        self.structs = structs
        self.at = 0

    def of(self, description: dict[str, Any], body: bytes) -> dict[str, Any]:
        values = {}
        for each in description["fields"]:
            value = self._field(each, body)
            if each["type"] != "count":
                values[each["name"]] = value
        return values

    def _field(self, of: dict[str, Any], body: bytes) -> Any:
        if "at_most" in of or "tail_at_most" in of:
            return b"" if of["type"] in ("byte", "u8") else "" if of["type"] == "char" else []
        if "times" in of:
            return [self._one(of, body) for _ in range(of["times"])]
        return self._one(of, body)

    def _one(self, of: dict[str, Any], body: bytes) -> Any:
        if of["type"] == "text":
            self.at += of["bytes"]
            return body[self.at - of["bytes"]:self.at].split(b"\0", 1)[0].decode()
        if of["type"] in self.structs:
            return self.of(self.structs[of["type"]], body)
        code = "<" + _CODES[of["type"]]
        self.at += struct.calcsize(code)
        return struct.unpack_from(code, body, self.at - struct.calcsize(code))[0]


def main() -> int:
    if len(sys.argv) != 2:
        print("usage: python3 -m rack.generate DESCRIPTION.json > MODULE.py", file=sys.stderr)
        return 2
    try:
        with open(sys.argv[1], encoding="utf-8") as file:
            text = Generator(json.load(file)).text()
    except (OSError, ValueError, KeyError, TypeError) as error:
        print(f"{sys.argv[1]}: no description of messages: {error!r}", file=sys.stderr)
        return 1
    sys.stdout.write(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
