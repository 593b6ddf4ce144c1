"""Python for messages: data classes of their bodies, types, and proxies."""

from __future__ import annotations

import pprint
from typing import Any, Optional

from .description import FLOAT, INT, Description, method_name

__all__ = ["PythonWriter"]


class PythonWriter:
    def __init__(self, description: Description) -> None:
        self.of = description
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
        for each in self.of.structs:
            self._struct(each)
        for each in self.of.classes:
            if each["messages"]:
                self._class(each)
        self._table()
        return "\n".join(self.out) + "\n"

    # --- structs

    def _struct(self, of: dict[str, Any]) -> None:
        made = self.of.made(of)
        self.out += ["", "@dataclass", f"class {of['name']}(Struct):"]
        shown = [each for each in of["fields"] if each["type"] != "count"]
        for each in shown:
            line = f"    {each['name']}: {self._type(each)} = {self._default(each, made[each['name']])}"
            comment = self.of.comment(of, each)
            self.out.append(line + (f"  # {comment}" if comment else ""))
        if not shown:
            self.out.append("    pass")
        self.out += ["", "", f"_laid_out({of['name']}, {pprint.pformat(self._plain(of), width=116, sort_dicts=False)})",
                     ""]

    def _plain(self, of: dict[str, Any]) -> dict[str, Any]:
        return {key: value for key, value in of.items() if key != "made"}

    def _type(self, of: dict[str, Any]) -> str:
        variable = "at_most" in of or "tail_at_most" in of
        kind = str(of["type"])
        if variable and kind in ("byte", "u8"):
            return "bytes"
        if variable and kind == "char":
            return "str"
        one = "int" if kind in INT else "float" if kind in FLOAT else kind
        one = "str" if one == "text" else one
        return f"list[{one}]" if variable or "times" in of else one

    def _default(self, of: dict[str, Any], made: Any) -> str:
        if isinstance(made, (list, dict)):
            inner = self.of.by_name.get(of["type"])
            if isinstance(made, dict) and inner is not None and made == self.of.made(inner):
                return f"field(default_factory=lambda: {of['type']}())"
            return f"field(default_factory=lambda: {self._literal(of, made)})" if made else "field(default_factory=list)"
        return self._literal(of, made)

    def _literal(self, of: dict[str, Any], made: Any) -> str:
        if isinstance(made, list):
            return "[" + ", ".join(self._literal(of, each) for each in made) + "]"
        if not isinstance(made, dict):
            return repr(made)
        inner = {each["name"]: each for each in self.of.by_name[of["type"]]["fields"]}
        return f"{of['type']}(" + ", ".join(f"{k}={self._literal(inner[k], v)}" for k, v in made.items()) + ")"

    # --- classes

    def _class(self, of: dict[str, Any]) -> None:
        self.out += ["", f"class {of['name']}Type(enum.IntEnum):"]
        self.out += [f"    {each['name']} = {each['type']}" for each in self.of.unique(of["messages"])]
        data = self.of.data(of)
        base = f"DataProxy[{data}]" if data else "Proxy"
        self.out += ["", "", f"class {of['name']}Proxy({base}):", f"    CLASS_ID = {of['id']}"]
        if data:
            self.out.append(f"    DATA = {data}")
        commands = {each["type"]: each["name"] for each in of["messages"] if each["type"] > 0}
        if commands:
            self.out.append(f"    COMMANDS = {commands!r}")
        for message in self.of.commands(of):
            self._method(of, message)
        self.out.append("")

    def _method(self, of: dict[str, Any], message: dict[str, Any]) -> None:
        name = method_name(message)
        arguments, body = self._arguments(message.get("body"))
        answers = self.of.answers(of, message)
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
        fields = self.of.arguments(body)
        if fields is None:
            return f", body: {body}", "body"
        made = self.of.made(self.of.by_name[body])
        arguments = "".join(f", {each['name']}: {self._type(each)} = {made[each['name']]!r}" for each in fields)
        return arguments, f"{body}(" + ", ".join(each["name"] for each in fields) + ")"

    def _table(self) -> None:
        self.out += ["", "# Bodies by class and type of the message: what a program shows that it does not know.",
                     "BODIES: dict[tuple[int, int], type[Struct]] = {"]
        for each in self.of.classes:
            for message in each["messages"]:
                if "body" in message:
                    self.out.append(f"    ({each['id']}, {message['type']}): {message['body']},")
        self.out += ["}", "", "CLASS_NAMES: dict[int, str] = {"]
        self.out += [f"    {each['id']}: {each['name']!r}," for each in self.of.classes]
        self.out += ["}"]
        if self.of.is_own:
            own = self.of.classes[0]
            self.out += ["", "import tims", "", f"tims.name_class({own['id']}, {own['name']!r})"]
