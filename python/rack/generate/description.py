"""The description of messages as all languages need it."""

from __future__ import annotations

import keyword
import re
import struct
from typing import Any, Optional

__all__ = ["FLOAT", "INT", "Description", "Field", "snake"]

Field = dict[str, Any]  # of a struct, or a struct, message or class: as they are in the JSON

INT = {"i8": "b", "u8": "B", "i16": "h", "u16": "H", "i32": "i", "u32": "I", "i64": "q", "u64": "Q", "byte": "B",
       "char": "B", "time": "I", "address": "I", "count": "i"}
FLOAT = {"f32": "f", "f64": "d"}
_CODES = {**INT, **FLOAT}
# Answers that the name of their command does not tell: (class, command) to the answer's name.
_ANSWERS = {("World", "PUT"): "OBSTACLE", ("Planner", "GET_COMMAND"): "COMMAND"}

# Lengths of tails (tail_sizes() of the struct in C++), in words that C and Java share: `of` is the struct, WIDE a cast
# to 64 bits. Negative: it is refused.
_TAILS = {
    "CameraData": ["of.mode == 41 ? of.colorFilterId : WIDE of.width * of.height * of.depth / 8"],
    "GridMapData": ["of.gridNumX < 0 || of.gridNumY < 0 ? -1 : WIDE of.gridNumX * of.gridNumY"],
    "Scan3dData": ["of.compressed != 0 ? 0 : of.pointNum", "of.compressed"],
    "Scan3dRangeImageData": ["of.scanNum < 0 || of.scanPointNum < 0 ? -1 : WIDE of.scanNum * of.scanPointNum"],
}


def snake(name: str) -> str:
    """GridMap is GRID_MAP."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).upper()


class Description:
    def __init__(self, json: dict[str, Any]) -> None:
        self.structs: list[Field] = json["structs"]
        self.by_name: dict[str, Field] = {each["name"]: each for each in self.structs}
        self.is_own = "rack_messages" in json
        self.classes: list[Field] = json.get("classes") or [
            {"id": int(str(json["class_id"]), 0), "name": json["class"], "messages": json["messages"]}]
        self.every_class: list[Field] = json.get("every_class", [])
        self.values = {each["field"]: each for each in json.get("values", [])}

    # --- structs

    @staticmethod
    def is_list(field: Field) -> bool:
        return "at_most" in field or "tail_at_most" in field

    @staticmethod
    def most(field: Field) -> int:
        """Elements at most."""
        return int(field.get("times") or field.get("at_most") or field.get("tail_at_most") or 1)

    def size(self, field: Field) -> int:
        """Bytes of an element in a body."""
        if field["type"] == "text":
            return int(field["bytes"])
        if field["type"] in self.by_name:
            return self.fixed_size(self.by_name[field["type"]])
        return struct.calcsize("<" + _CODES[field["type"]])

    def fixed_size(self, of: Field) -> int:
        """Bytes of a body without its lists."""
        return sum(0 if self.is_list(each) else self.size(each) * self.most(each) for each in of["fields"])

    def greatest_size(self, of: Field) -> int:
        lists = sum(self.size(each) * self.most(each) for each in of["fields"] if self.is_list(each))
        return max(self.fixed_size(of) + lists + int(of.get("surplus", 0)), int(of.get("whole_size", 0)))

    def count_of(self, of: Field, wanted: Field) -> str:
        """The name of the count of a sequence."""
        count = ""
        for each in of["fields"]:
            if each["type"] == "count":
                count = each["name"]
            if each is wanted:
                return count
        raise KeyError(wanted["name"])

    def tails(self, of: Field) -> list[str]:
        lists = [each for each in of["fields"] if "tail_at_most" in each]
        if len(lists) != len(_TAILS.get(of["name"], [])):
            raise KeyError(f"{of['name']}: rack/generate/description.py lacks the lengths of its tails")
        return _TAILS.get(of["name"], [])

    def comment(self, of: Field, field: Field) -> str:
        """The unit of a field, or what its values mean."""
        known = self.values.get(f"{of['name']}.{field['name']}")
        if known is None:
            return str(field.get("unit", ""))
        names = [f"{value} {name}" for name, value in known["names"].items()]
        return ", ".join(names + [f"+{value} {name}" for name, value in known["flags"].items()])

    def made(self, of: Field) -> dict[str, Any]:
        """The default values."""
        return _Made(self.by_name).of(of, bytes.fromhex(of["made"]))

    # --- messages

    def unique(self, messages: list[Field]) -> list[Field]:
        """The first of each name."""
        return list({each["name"]: each for each in reversed(messages)}.values())[::-1]

    def data(self, of: Field) -> Optional[str]:
        """The struct of the data of a class."""
        return next((each.get("body") for each in of["messages"] if each["type"] == -6), None)

    def commands(self, of: Field) -> list[Field]:
        return [each for each in of["messages"] if each["type"] > 0 and not self._is_answer(of, each)]

    def answers(self, of: Field, command: Field) -> list[Field]:
        name = command["name"]
        wanted = _ANSWERS.get((of["name"], name)) or (
            name[4:] if name.startswith("GET_") else name.split("_TO_")[1] if "_TO_" in name else "")
        return [each for each in of["messages"] if each["name"] == wanted and each.get("body")]

    def _is_answer(self, of: Field, message: Field) -> bool:
        """Of a type above 0, as STATUS of Pilot."""
        return any(message in self.answers(of, each) for each in of["messages"]
                   if each is not message and each["name"] != message["name"] and each["type"] > 0
                   and (of["name"], each["name"]) not in _ANSWERS)

    def arguments(self, body: Optional[str]) -> Optional[list[Field]]:
        """The fields of a body if they are few and plain: arguments of its call."""
        if body is None:
            return []
        fields = self.by_name[body]["fields"]
        plain = all(each["type"] in (*_CODES, "text")
                    and (each["type"] == "char" or not {"times", "at_most", "tail_at_most"} & each.keys())
                    for each in fields)
        return [each for each in fields if each["type"] != "count"] if plain else None


def method_name(message: Field) -> str:
    name = str(message["name"]).lower()
    return name + "_" if keyword.iskeyword(name) else name


class _Made:
    """Default values out of a default body: sequences are empty there."""

    def __init__(self, structs: dict[str, Field]) -> None:
        self.structs = structs
        self.at = 0

    def of(self, description: Field, body: bytes) -> dict[str, Any]:
        values = {}
        for each in description["fields"]:
            value = self._field(each, body)
            if each["type"] != "count":
                values[each["name"]] = value
        return values

    def _field(self, of: Field, body: bytes) -> Any:
        if Description.is_list(of):
            return b"" if of["type"] in ("byte", "u8") else "" if of["type"] == "char" else []
        if "times" in of:
            return [self._one(of, body) for _ in range(of["times"])]
        return self._one(of, body)

    def _one(self, of: Field, body: bytes) -> Any:
        if of["type"] == "text":
            self.at += of["bytes"]
            return body[self.at - of["bytes"]:self.at].split(b"\0", 1)[0].decode()
        if of["type"] in self.structs:
            return self.of(self.structs[of["type"]], body)
        code = "<" + _CODES[of["type"]]
        self.at += struct.calcsize(code)
        return struct.unpack_from(code, body, self.at - struct.calcsize(code))[0]
