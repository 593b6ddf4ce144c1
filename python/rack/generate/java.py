"""Java for messages: a class for each body and for the calls of each class of components."""

from __future__ import annotations

from typing import Any

from .description import Description, Field

__all__ = ["JavaWriter"]

_TYPES = {"i8": "int", "u8": "int", "i16": "int", "u16": "int", "i32": "int", "u32": "long", "i64": "long",
          "f32": "float", "f64": "double", "byte": "int", "time": "long", "address": "int", "count": "int",
          "text": "String"}
# How a field is read and written: by the methods of BodyReader and BodyWriter.
_CALLS = {"byte": "u8", "time": "u32", "address": "i32", "count": "i32"}
_KEYWORDS = {"abstract", "boolean", "break", "byte", "case", "catch", "char", "class", "const", "continue", "default", "do",
             "double", "else", "enum", "extends", "final", "finally", "float", "for", "goto", "if", "implements", "import",
             "instanceof", "int", "interface", "long", "native", "new", "package", "private", "protected", "public",
             "return", "short", "static", "super", "switch", "synchronized", "this", "throw", "throws", "transient", "try",
             "void", "volatile", "while", "wait", "notify"}
_NOTE = "// Written by rack.generate from the description of the messages: do not change it here."


def _name(text: str) -> str:
    """SET_ACTIVE_PILOT is setActivePilot."""
    first, *rest = text.lower().split("_")
    return _safe(first + "".join(part.capitalize() for part in rest))


def _safe(name: str) -> str:
    return name + "_" if name in _KEYWORDS else name


class JavaWriter:
    def __init__(self, description: Description) -> None:
        self.of = description
        self.out: list[str] = []

    def files(self) -> dict[str, str]:
        """The texts of all files by their names in the folder of sources."""
        package = self.of.classes[0]["name"].lower() if self.of.is_own else "rack/messages"
        files = {f"{package}/{each['name']}.java": self._struct(each, package) for each in self.of.structs}
        for each in self.of.classes:
            if each["messages"]:
                files[f"{package}/{each['name']}Proxy.java"] = self._proxy(each, package)
        if not self.of.is_own:
            files["tims/ClassNames.java"] = self._class_names()
            files[f"{package}/Bodies.java"] = self._bodies(package)
        return files

    def _text(self) -> str:
        text = "\n".join(self.out) + "\n"
        self.out = []
        return text

    def _begin(self, package: str, *imports: str) -> None:
        self.out = [_NOTE, f"package {package.replace('/', '.')};", ""]
        self.out += [f"import {each};" for each in imports] + [""] * bool(imports)

    # --- structs

    def _struct(self, of: Field, package: str) -> str:
        name = of["name"]
        lists = any(self.of.is_list(each) and each["type"] in self.of.by_name for each in of["fields"])
        imports = ["java.nio.ByteBuffer", *(["java.util.ArrayList", "java.util.List"] if lists else []),
                   "rack.BodyReader", "rack.BodyWriter", "rack.Struct", "tims.Message"]
        self._begin(package, *imports)
        self.out.append(f"public final class {name} extends Struct {{")
        made = self.of.made(of)
        for each in of["fields"]:
            if each["type"] != "count":
                comment = self.of.comment(of, each)
                self.out.append(f"  public {self._type(each)} {_safe(each['name'])} = {self._default(each, made[each['name']])};"
                                + (f" // {comment}" if comment else ""))
        self.out += ["", f"  public static {name} decode(Message message) {{",
                     f"    return decode(new {name}(), message);", "  }", "",
                     f"  public static {name} decode(ByteBuffer body) {{",
                     f"    return decode(new {name}(), body);", "  }", ""]
        for method, key in (("wholeSize", "whole_size"), ("surplus", "surplus")):
            if key in of:
                self.out += ["  @Override", f"  protected int {method}() {{", f"    return {of[key]};", "  }", ""]
        self._reader(of)
        self._writer(of)
        self.out.append("}")
        return self._text()

    def _type(self, of: Field) -> str:
        kind = str(of["type"])
        if self.of.is_list(of):
            one = {"byte": "byte[]", "u8": "byte[]", "char": "String", "i32": "int[]"}.get(kind)
            return one or f"List<{kind}>"
        one = _TYPES.get(kind, kind)
        return one + "[]" if "times" in of else one

    def _default(self, of: Field, made: Any) -> str:
        kind = self._type(of)
        if kind in ("byte[]", "int[]"):
            return f"new {kind[:-2]}[0]"
        if kind.startswith("List"):
            return "new ArrayList<>()"
        if kind == "String":
            return f'"{made}"'
        if "times" in of:
            return "{" + ", ".join(f"{value}f" for value in made) + "}"
        if kind in self.of.by_name:
            return f"new {kind}()"
        if kind == "int" and made > 0x7fffffff:
            return hex(made)
        return str(made) + {"float": "f", "long": "L"}.get(kind, "")

    def _reader(self, of: Field) -> None:
        self.out += ["  @Override", "  protected void read(BodyReader in) {",
                     f'    in.begin("{of["name"]}", {self.of.fixed_size(of)});']
        tails = iter(self.of.tails(of))
        for each in of["fields"]:
            name = _safe(each["name"])
            if each["type"] == "count":
                self.out.append(f"    int {name} = in.i32();")
            elif self.of.is_list(each):
                self.out.append(f"    {name} = {self._read_list(of, each, next(tails) if 'tail_at_most' in each else None)};")
            else:
                self.out.append(f"    {name} = {self._read_one(each)};")
        self.out += ["  }", ""]

    def _read_one(self, of: Field) -> str:
        if of["type"] == "text":
            return f"in.text({of['bytes']})"
        if "times" in of:
            return f"in.{of['type']}s({of['times']})"
        if of["type"] in self.of.by_name:
            return f"in.struct(new {of['type']}())"
        return f"in.{_CALLS.get(of['type'], of['type'])}()"

    def _read_list(self, of: Field, each: Field, tail: str | None) -> str:
        if tail is None:
            count = self.of.count_of(of, each)
            arguments = f'"{of["name"]}.{count}", {_safe(count)}, {self.of.most(each)}'
        else:
            arguments = f'"{of["name"]}.{each["name"]}", {self._stated(tail)}, {self.of.most(each)}'
        kind = self._type(each)
        if kind.startswith("List"):
            return f"in.structs({arguments}, {self.of.size(each)}, {each['type']}::new)"
        return {"byte[]": "in.bytes", "String": "in.chars", "int[]": "in.i32s"}[kind] + f"({arguments})"

    @staticmethod
    def _stated(tail: str) -> str:
        return tail.replace("of.", "").replace("WIDE ", "(long) ")

    def _writer(self, of: Field) -> None:
        self.out += ["  @Override", "  protected void write(BodyWriter out) {"]
        raw = {each["name"] for each in of["fields"] if self.of.is_list(each) and each["type"] == "char"}
        for name in sorted(raw):
            self.out.append(f"    byte[] {name}Bytes = BodyWriter.utf8({_safe(name)});")
        tails = iter(self.of.tails(of))
        for each in of["fields"]:
            path = f"{of['name']}.{each['name']}"
            name = _safe(each["name"])
            if each["type"] == "count":
                counted = next((other for other in of["fields"] if "at_most" in other
                                and self.of.count_of(of, other) == each["name"]), None)
                if counted:
                    path = f"{of['name']}.{counted['name']}"
                    self.out.append(f'    out.count("{path}", {self._length(counted)}, {self.of.most(counted)});')
                else:
                    self.out.append(f'    out.i32("{path}", 0);')
            elif self.of.is_list(each):
                if "tail_at_most" in each:
                    self.out.append(f'    out.tail("{path}", {self._length(each)}, {self._stated(next(tails))}, '
                                    f"{self.of.most(each)});")
                method = {"byte[]": "bytes", "String": "bytes", "int[]": "i32s"}.get(self._type(each), "structs")
                self.out.append(f"    out.{method}({each['name'] + 'Bytes' if each['type'] == 'char' else name});")
            elif each["type"] == "text":
                self.out.append(f'    out.text("{path}", {name}, {each["bytes"]});')
            elif "times" in each:
                self.out.append(f'    out.{each["type"]}s("{path}", {name}, {each["times"]});')
            elif each["type"] in self.of.by_name:
                self.out.append(f"    out.struct({name});")
            else:
                self.out.append(f'    out.{_CALLS.get(each["type"], each["type"])}("{path}", {name});')
        if of.get("pads"):
            self.out.append(f"    out.pad({of['whole_size']});")
        self.out.append("  }")

    def _length(self, of: Field) -> str:
        kind = self._type(of)
        if kind == "String":
            return f"{of['name']}Bytes.length"
        return _safe(of["name"]) + (".length" if kind.endswith("[]") else ".size()")

    # --- classes

    def _proxy(self, of: Field, package: str) -> str:
        name = f"{of['name']}Proxy"
        data = self.of.data(of)
        self._begin(package, "java.util.Map", "rack.DataProxy" if data else "rack.Proxy", "tims.Address", "tims.Mailbox",
                    "tims.TimsException")
        self.out += [f"public final class {name} extends {f'DataProxy<{data}>' if data else 'Proxy'} {{",
                     f"  public static final int CLASS_ID = {of['id']};"]
        self.out += [f"  public static final int {each['name']} = {each['type']};" for each in self.of.unique(of["messages"])]
        commands = {each["type"]: each["name"] for each in of["messages"] if each["type"] > 0}
        table = ", ".join(f'Map.entry({number}, "{text}")' for number, text in commands.items())
        self.out += ["", f"  private static final Map<Integer, String> COMMANDS = Map.ofEntries({table});", "",
                     "  /** Answers come to `work`, which must accept the largest of them. */",
                     f"  public {name}(Mailbox work, int component) {{",
                     f"    super(work, component, COMMANDS{f', {data}::new' if data else ''});", "  }", "",
                     f"  public {name}(Mailbox work, String component) {{",
                     "    this(work, Address.parse(component));", "  }"]
        for message in self.of.commands(of):
            self._method(of, message)
        self.out.append("}")
        return self._text()

    def _method(self, of: Field, message: Field) -> None:
        name = _name(message["name"])
        body = message.get("body")
        answers = self.of.answers(of, message)
        answer = answers[0]["body"] if answers else "void"
        throws = "throws TimsException, InterruptedException"
        argument = f"{body} body" if body else ""
        self.out += ["", f"  public {answer} {name}({argument}) {throws} {{"]
        if answers:
            types = ", ".join(str(each["type"]) for each in answers)
            self.out.append(f"    return query({message['type']}, {'body' if body else 'null'}, {answer}::new, {types});")
        else:
            self.out.append(f"    command({message['type']}, {'body' if body else 'null'});")
        self.out.append("  }")
        fields = self.of.arguments(body)
        if fields:
            arguments = ", ".join(f"{self._type(each)} {_safe(each['name'])}" for each in fields)
            self.out += ["", f"  public {answer} {name}({arguments}) {throws} {{", f"    {body} body = new {body}();"]
            self.out += [f"    body.{_safe(each['name'])} = {_safe(each['name'])};" for each in fields]
            self.out += [f"    {'' if answer == 'void' else 'return '}{name}(body);", "  }"]

    def _class_names(self) -> str:
        self._begin("tims", "java.util.Map")
        entries = ",\n      ".join(f'Map.entry({each["id"]}, "{each["name"]}")' for each in self.of.classes)
        self.out += ["/** The classes of components. */", "final class ClassNames {",
                     f"  static final Map<Integer, String> BY_ID = Map.ofEntries(\n      {entries});", "",
                     "  private ClassNames() {}", "}"]
        return self._text()

    def _bodies(self, package: str) -> str:
        names = [each["name"] for each in self.of.structs]
        self._begin(package, "java.util.Map", "java.util.function.Supplier", "rack.Struct")
        entries = ",\n      ".join(f'Map.entry("{each}", {each}::new)' for each in names)
        self.out += ["/** All structs by their names: for programs that handle messages which they do not know. */",
                     "public final class Bodies {",
                     f"  public static final Map<String, Supplier<Struct>> BY_NAME = Map.ofEntries(\n      {entries});",
                     "", "  private Bodies() {}", "}"]
        return self._text()
