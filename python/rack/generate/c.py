"""C for messages: structs of their bodies with their layouts, types, and calls of rack_codec.h."""

from __future__ import annotations

from .description import Description, Field, snake

__all__ = ["CWriter"]

_TYPES = {"i8": "int8_t", "u8": "uint8_t", "i16": "int16_t", "u16": "uint16_t", "i32": "int32_t", "u32": "uint32_t",
          "i64": "int64_t", "u64": "uint64_t", "f32": "float", "f64": "double", "byte": "uint8_t", "char": "char",
          "time": "uint32_t", "address": "uint32_t", "count": "int32_t", "text": "char"}


class CWriter:
    def __init__(self, description: Description) -> None:
        self.of = description
        self.out: list[str] = []

    def text(self) -> str:
        guard = (f"RACK_MESSAGES_{snake(self.of.classes[0]['name'])}_H" if self.of.is_own else "RACK_MESSAGES_H")
        self.out = [
            "/* Written by rack.generate from the description of the messages: do not change it here.",
            " * How these structs are used is said in rack_codec.h. */",
            f"#ifndef {guard}", f"#define {guard}", "", '#include "rack_codec.h"', "",
            "#ifdef __cplusplus", "#pragma GCC diagnostic push",
            '#pragma GCC diagnostic ignored "-Wold-style-cast"', 'extern "C" {', "#endif", ""]
        self._every_class()
        for each in self.of.structs:
            self._struct(each)
        for each in self.of.classes:
            self._class(each)
        self._table()
        self.out += ["#ifdef __cplusplus", "}", "#pragma GCC diagnostic pop", "#endif", "", "#endif"]
        return "\n".join(self.out) + "\n"

    def _every_class(self) -> None:
        if not self.of.every_class:
            return
        self.out.append("/* Messages that all classes have. */")
        self._enum("rack_type", "RACK", self.of.every_class)

    def _enum(self, name: str, prefix: str, messages: list[Field]) -> None:
        self.out += [f"enum {name} {{"]
        self.out += [f"  {prefix}_{each['name']} = {each['type']}," for each in self.of.unique(messages)]
        self.out += ["};", ""]

    def _class(self, of: Field) -> None:
        name = snake(of["name"])
        self.out.append(f"enum {{ RACK_CLASS_{name} = {of['id']} }};")
        if of["messages"]:
            self._enum(f"rack_{of['name']}_type", f"RACK_{name}", of["messages"])

    # --- structs

    def _struct(self, of: Field) -> None:
        self.out.append(f"struct rack_{of['name']} {{")
        for each in of["fields"]:
            self._member(of, each)
        if not of["fields"]:
            self.out.append("  uint8_t unused;")
        self.out += ["};"]
        self._sizes(of)
        self._tails(of)
        self._layout(of)
        self._calls(of)

    def _member(self, of: Field, field: Field) -> None:
        kind = _TYPES.get(field["type"], f"struct rack_{field['type']}")
        comment = self.of.comment(of, field).replace("*/", "* /")
        if not self.of.is_list(field):
            times = f"[{field['times']}]" if "times" in field else ""
            times += f"[{field['bytes']}]" if field["type"] == "text" else ""
            self.out.append(f"  {kind} {field['name']}{times};" + (f" /* {comment} */" if comment else ""))
            return
        if "tail_at_most" in field:
            self.out.append(f"  uint32_t {field['name']}_count; /* by the fields before: at most {self.of.most(field)} */")
            self.out.append(f"  const {kind}* {field['name']};")
        else:
            self.out.append(f"  const {kind}* {field['name']}; /* {self.of.count_of(of, field)} of them, "
                            f"at most {self.of.most(field)} */")

    def _memory(self, of: Field) -> list[str]:
        """What decoding needs memory for: lists whose elements are not single bytes, which stay in the body."""
        return [f"{self.of.most(each)} * sizeof({_TYPES.get(each['type'], 'struct rack_' + str(each['type']))}) + 8"
                for each in of["fields"] if self.of.is_list(each) and self.of.size(each) != 1]

    def _sizes(self, of: Field) -> None:
        self.out.append(f"#define RACK_BODY_MAX_{of['name']} {self.of.greatest_size(of)}")
        if memory := self._memory(of):
            self.out.append(f"#define RACK_MEMORY_{of['name']} ({' + '.join(memory)})")

    def _tails(self, of: Field) -> None:
        if tails := self.of.tails(of):
            self.out += [f"static inline void rack_tails_{of['name']}(const void* value, int64_t* counts) {{",
                         f"  const struct rack_{of['name']}* of = (const struct rack_{of['name']}*)value;"]
            for i, each in enumerate(tails):
                self.out.append(f"  counts[{i}] = {each.replace('of.', 'of->').replace('WIDE ', '(int64_t)')};")
            self.out.append("}")

    def _layout(self, of: Field) -> None:
        name = of["name"]
        if of["fields"]:
            self.out.append(f"static const struct rack_field rack_fields_{name}[] = {{")
            self.out += [f"    {self._field(of, each)}," for each in of["fields"]]
            self.out.append("};")
        made = bytes.fromhex(of["made"])
        if any(made):
            self.out.append(f"static const uint8_t rack_made_{name}[] = {{{', '.join(map(str, made))}}};")
        self.out += [
            f"static const struct rack_layout rack_layout_{name} = {{",
            f'    "{name}", {"rack_fields_" + name if of["fields"] else "NULL"}, {len(of["fields"])}, '
            f"sizeof(struct rack_{name}), {self.of.fixed_size(of)}, {of.get('whole_size', 0)}, {of.get('surplus', 0)}, "
            f"{of.get('pads', 0)}, {'rack_made_' + name if any(made) else 'NULL'}, {len(made)}, "
            f"{'rack_tails_' + name if self.of.tails(of) else 'NULL'}}};"]

    def _field(self, of: Field, field: Field) -> str:
        """A row of struct rack_field."""
        name = f"struct rack_{of['name']}"
        kind = ("RACK_KIND_STRUCT" if field["type"] in self.of.by_name else
                "RACK_KIND_TEXT" if field["type"] == "text" else
                "RACK_KIND_REAL" if field["type"] in ("f32", "f64") else
                "RACK_KIND_SIGNED" if field["type"] in ("i8", "i16", "i32", "i64", "count") else "RACK_KIND_UNSIGNED")
        stride = (f"sizeof(struct rack_{field['type']})" if field["type"] in self.of.by_name
                  else str(self.of.size(field)))
        inner = f"&rack_layout_{field['type']}" if field["type"] in self.of.by_name else "NULL"
        role, count = "RACK_FIXED", "0"
        if "at_most" in field:
            role, count = "RACK_SEQUENCE", f"offsetof({name}, {self.of.count_of(of, field)})"
        elif "tail_at_most" in field:
            role, count = "RACK_TAIL", f"offsetof({name}, {field['name']}_count)"
        counter = f'"{self.of.count_of(of, field)}"' if "at_most" in field else f'"{field["name"]}"'
        return (f'{{"{field["name"]}", {counter}, {kind}, {role}, {self.of.size(field)}, {self.of.most(field)}, '
                f"offsetof({name}, {field['name']}), {count}, {stride}, {inner}}}")

    def _calls(self, of: Field) -> None:
        name = of["name"]
        has_memory = bool(self._memory(of))
        memory = ", void* memory, size_t memory_size" if has_memory else ""
        self.out += [
            f"static inline void rack_init_{name}(struct rack_{name}* value) {{",
            f"  rack_init_struct(&rack_layout_{name}, value);", "}",
            f"static inline int64_t rack_encode_{name}(const struct rack_{name}* value, uint8_t flags, void* body,",
            "    size_t size, struct rack_problem* problem) {",
            f"  return rack_encode_struct(&rack_layout_{name}, value, flags, body, size, problem);", "}",
            f"static inline int rack_decode_{name}(struct rack_{name}* value, uint8_t flags, const void* body,",
            f"    size_t size{memory}, struct rack_problem* problem) {{",
            f"  return rack_decode_struct(&rack_layout_{name}, value, flags, body, size, "
            f"{'memory, memory_size' if has_memory else 'NULL, 0'}, problem);", "}", ""]

    def _table(self) -> None:
        table = f"rack_bodies_{self.of.classes[0]['name']}" if self.of.is_own else "rack_bodies"
        self.out += ["/* Bodies by class and type of the message (class 0: of every class), for programs that show messages",
                     " * which they do not know; it ends with a name that is NULL. */",
                     f"static const struct rack_body {table}[] = {{"]
        classes = [{"id": 0, "messages": self.of.every_class}, *self.of.classes]
        self.out += [f'    {{{of["id"]}, {each["type"]}, "{each["name"]}", &rack_layout_{each["body"]}}},'
                     for of in classes for each in of["messages"] if "body" in each]
        self.out += ["    {0, 0, NULL, NULL},", "};", ""]
