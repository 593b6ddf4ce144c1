"""Any message struct to and from bytes, in either byte order, by its description.

Lengths in a body are not trusted: the error names the field, and no memory is taken for elements that are not there.
The texts of errors are those of the codecs in C++ and TypeScript. numpy is used only by `arrays`, and only if it is
asked for.
"""

from __future__ import annotations

import struct
from typing import Any, Callable, ClassVar, Mapping, Optional, Protocol, Self, Sequence, Union

__all__ = ["CodecError", "Layout", "Struct", "tail_sizes"]

Body = Union[bytes, bytearray, memoryview, "Received"]


class Received(Protocol):
    """A tims.Message."""

    @property
    def little_endian(self) -> bool: ...

    def __bytes__(self) -> bytes: ...


class CodecError(ValueError):
    """Bytes that are not this struct, or values that it cannot hold."""


_ADVICE = "; its sender is broken, or has another version of this message"
_CODES = {
    "i8": "b", "u8": "B", "i16": "h", "u16": "H", "i32": "i", "u32": "I", "i64": "q", "u64": "Q", "f32": "f",
    "f64": "d", "byte": "B", "char": "B", "time": "I", "address": "I", "count": "i",
}

# Lengths of the tails of structs: what tail_sizes() of theirs computes in C++. Negative: it is refused.
tail_sizes: dict[str, Callable[[Mapping[str, Any]], Sequence[int]]] = {
    "CameraData": lambda of: [
        of["colorFilterId"] if of["mode"] == 41 else of["width"] * of["height"] * of["depth"] // 8],
    "GridMapData": lambda of: [
        -1 if of["gridNumX"] < 0 or of["gridNumY"] < 0 else of["gridNumX"] * of["gridNumY"]],
    "Scan3dData": lambda of: [0, of["compressed"]] if of["compressed"] != 0 else [of["pointNum"], 0],
    "Scan3dRangeImageData": lambda of: [
        -1 if of["scanNum"] < 0 or of["scanPointNum"] < 0 else of["scanNum"] * of["scanPointNum"]],
}


def _text(raw: bytes) -> str:
    """Bytes that are not UTF-8 stay what they are."""
    return raw.decode("utf-8", "surrogateescape")


def _bytes(text: str) -> bytes:
    return str(text).encode("utf-8", "surrogateescape")


class _Field:
    """One field of a description, and how its elements are read and written."""

    def __init__(self, owner: str, description: Mapping[str, Any], structs: Mapping[str, type[Struct]]) -> None:
        self.owner = owner
        self.name: str = description["name"]
        self.type: str = description["type"]
        self.times: Optional[int] = description.get("times")
        self.at_most: Optional[int] = description.get("at_most")
        self.tail_at_most: Optional[int] = description.get("tail_at_most")
        self.unit: str = description.get("unit", "")
        self.si_unit: str = description.get("si_unit", "")
        self.si: float = description.get("si", 1.0)
        self.is_variable = self.at_most is not None or self.tail_at_most is not None
        self.most = self.times or self.at_most or self.tail_at_most or 1
        self.code = _CODES.get(self.type)
        self.inner: Optional[type[Struct]] = None
        if self.type == "text":
            self.size: int = description["bytes"]
        elif self.code is not None:
            self.size = struct.calcsize("<" + self.code)
        elif self.type in structs:
            self.inner = structs[self.type]
            self.size = self.inner.layout.size
        else:
            raise CodecError(f"{owner}.{self.name}: there is no type {self.type}")

    @property
    def path(self) -> str:
        return f"{self.owner}.{self.name}"

    @property
    def is_bytes(self) -> bool:
        return self.is_variable and self.type in ("byte", "u8", "char")

    def dtype(self, little: bool) -> Any:
        """What numpy calls an element."""
        if self.inner is not None:
            return self.inner.layout.dtype(little)
        if self.code is None:
            return f"S{self.size}"
        kind = {"f": "f4", "d": "f8"}.get(self.code) or ("i" if self.code.islower() else "u") + str(self.size)
        return ("<" if little else ">") + kind

    # --- reading; that the bytes are there has been checked

    def read_many(self, view: memoryview, at: int, count: int, little: bool) -> Any:
        if self.is_bytes:
            raw = bytes(view[at:at + count])
            return _text(raw) if self.type == "char" else raw
        if self.code is not None:
            return list(struct.unpack_from(f"{'<' if little else '>'}{count}{self.code}", view, at))
        if self.inner is not None:
            return self.inner.layout.read_elements(view, at, count, little)
        return [self._read_text(view, at + i * self.size) for i in range(count)]

    def read_fixed(self, view: memoryview, at: int, little: bool) -> Any:
        many = self.read_many(view, at, self.most, little)
        return many if self.times is not None else many[0]

    def _read_text(self, view: memoryview, at: int) -> str:
        return _text(bytes(view[at:at + self.size - 1]).split(b"\0", 1)[0])

    # --- writing

    def write_fixed(self, value: Any, little: bool) -> bytes:
        if self.times is None:
            return self.write_many([value], little)
        if len(value) != self.times:
            raise CodecError(f"{self.path} has {len(value)} elements, not {self.times}")
        return self.write_many(value, little)

    def write_many(self, values: Any, little: bool) -> bytes:
        if self.is_bytes:
            return _bytes(values) if isinstance(values, str) else bytes(values)
        if hasattr(values, "dtype"):  # an array of numpy
            return bytes(values.astype(self.dtype(little)).tobytes())
        if self.code is not None:
            try:
                return struct.pack(f"{'<' if little else '>'}{len(values)}{self.code}", *values)
            except (struct.error, OverflowError):
                raise self._wrong_number(values) from None
        if self.inner is not None:
            return b"".join(self._struct_of(value).layout.write(value, little) for value in values)
        return b"".join(self._write_text(value) for value in values)

    def _struct_of(self, value: Any) -> type[Struct]:
        if self.inner is None or not isinstance(value, self.inner):
            raise CodecError(f"{self.path} is {value!r}: expected {self.type}")
        return self.inner

    def _write_text(self, value: Any) -> bytes:
        raw = _bytes(value)
        if len(raw) >= self.size:
            raise CodecError(f"{self.path} has {len(raw)} bytes, allowed are {self.size - 1}: shorten it")
        return raw.ljust(self.size, b"\0")

    def _wrong_number(self, values: Sequence[Any]) -> CodecError:
        expected = "a number"
        if self.code is not None and self.code not in "fd":
            bits = 8 * self.size
            low, high = (-2 ** (bits - 1), 2 ** (bits - 1) - 1) if self.code.islower() else (0, 2**bits - 1)
            expected = f"a whole number from {low} to {high}"
        for value in values:
            try:
                struct.pack(f"<{self.code}", value)
            except (struct.error, OverflowError):
                return CodecError(f"{self.path} is {value}: expected {expected}")
        return CodecError(f"{self.path}: expected {expected}")


class _Run:
    """Numbers side by side, which are read and written at once."""

    def __init__(self) -> None:
        self.fields: list[_Field] = []

    def complete(self) -> None:
        codes = "".join(field.code or "" for field in self.fields)
        self.names = [field.name for field in self.fields]
        self.by_order = (struct.Struct(">" + codes), struct.Struct("<" + codes))
        self.size = self.by_order[0].size


class Layout:
    """A struct's bytes: made once, when the class of the struct is."""

    def __init__(self, description: Mapping[str, Any], structs: Mapping[str, type[Struct]]) -> None:
        self.name: str = description["name"]
        self.whole_size: int = description.get("whole_size", 0)
        self.pads = bool(description.get("pads", 0))
        self.surplus: int = description.get("surplus", 0)
        self.fields = [_Field(self.name, field, structs) for field in description["fields"]]
        self.size = sum(0 if field.is_variable else field.size * field.most for field in self.fields)
        self.steps: list[Union[_Run, _Field]] = []
        for field in self.fields:
            self._add_step(field)
        for step in self.steps:
            if isinstance(step, _Run):
                step.complete()
        self.is_flat = len(self.steps) == 1 and isinstance(self.steps[0], _Run)
        self.count_of = self._counts()
        self.type: type[Struct]  # set by the class
        if any(field.tail_at_most is not None for field in self.fields) and self.name not in tail_sizes:
            raise CodecError(f"{self.name}: rack.codec.tail_sizes lacks its lengths")

    def _add_step(self, field: _Field) -> None:
        if field.code is None or field.times is not None or field.is_variable:
            self.steps.append(field)
            return
        if not self.steps or not isinstance(self.steps[-1], _Run):
            self.steps.append(_Run())
        run = self.steps[-1]
        assert isinstance(run, _Run)
        run.fields.append(field)

    def _counts(self) -> dict[str, str]:
        """The count of each sequence."""
        counts = {}
        count = ""
        for field in self.fields:
            if field.type == "count":
                count = field.name
            elif field.at_most is not None:
                counts[field.name] = count
        return counts

    def dtype(self, little: bool = True) -> list[tuple[Any, ...]]:
        """What numpy.dtype() takes; only of a struct of fixed size."""
        return [
            (field.name, field.dtype(little)) if field.times is None else (field.name, field.dtype(little), field.times)
            for field in self.fields
        ]

    # --- reading

    def read(self, view: memoryview, little: bool, arrays: bool) -> dict[str, Any]:
        if len(view) < self.size:
            raise CodecError(f"{self.name} has at least {self.size} bytes, not {len(view)} bytes{_ADVICE}")
        values: dict[str, Any] = {}
        at = 0
        for step in self.steps:
            if isinstance(step, _Run):
                values.update(zip(step.names, step.by_order[little].unpack_from(view, at)))
                at += step.size
            elif not step.is_variable:
                values[step.name] = step.read_fixed(view, at, little)
                at += step.size * step.most
            else:
                count = self._checked_count(step, values, len(view) - at)
                values[step.name] = (
                    _array(step, view, at, count, little) if arrays else step.read_many(view, at, count, little))
                at += count * step.size
        self._check_size(at, len(view))
        for field in self.fields:
            if field.type == "count":
                del values[field.name]
        return values

    def _checked_count(self, field: _Field, values: Mapping[str, Any], left: int) -> int:
        if field.tail_at_most is not None:
            tails = [each.name for each in self.fields if each.tail_at_most is not None]
            count = int(tail_sizes[self.name](values)[tails.index(field.name)])
            path = field.path
        else:
            count = int(values[self.count_of[field.name]])
            path = f"{self.name}.{self.count_of[field.name]}"
        if not 0 <= count <= field.most:
            raise CodecError(f"{path} is {count}, allowed are 0 to {field.most}{_ADVICE}")
        if count * field.size > left:
            raise CodecError(f"{path} needs {count * field.size} bytes, only {left} bytes follow{_ADVICE}")
        return count

    def _check_size(self, size: int, given: int) -> None:
        if given not in (size, self.whole_size) and not (self.surplus > 0 and given == size + self.surplus):
            raise CodecError(f"{self.name} is {size} bytes long by its own counts, not {given} bytes{_ADVICE}")

    def read_elements(self, view: memoryview, at: int, count: int, little: bool) -> list[Struct]:
        """Elements of a sequence: structs of fixed size."""
        end = at + count * self.size
        if self.is_flat:
            run = self.steps[0]
            assert isinstance(run, _Run)
            return [self.type(*values) for values in run.by_order[little].iter_unpack(view[at:end])]
        return [self.type(**self.read(view[i:i + self.size], little, False)) for i in range(at, end, self.size or 1)]

    # --- writing

    def write(self, value: Struct, little: bool) -> bytes:
        parts = []
        for step in self.steps:
            if isinstance(step, _Run):
                parts.append(self._write_run(step, value, little))
            elif step.is_variable:
                parts.append(self._write_list(step, value, little))
            else:
                parts.append(step.write_fixed(getattr(value, step.name), little))
        body = b"".join(parts)
        return body.ljust(self.whole_size, b"\0") if self.pads else body

    def _write_run(self, run: _Run, value: Struct, little: bool) -> bytes:
        numbers = [
            self._counted(field, value) if field.type == "count" else getattr(value, field.name)
            for field in run.fields
        ]
        try:
            return run.by_order[little].pack(*numbers)
        except (struct.error, OverflowError):
            for field, number in zip(run.fields, numbers):
                field.write_many([number], little)  # names the wrong one
            raise

    def _counted(self, count: _Field, value: Struct) -> int:
        lists = [name for name, of in self.count_of.items() if of == count.name]
        return len(_raw(getattr(value, lists[0]))) if lists else 0

    def _write_list(self, field: _Field, value: Struct, little: bool) -> bytes:
        values = _raw(getattr(value, field.name))
        if len(values) > field.most:
            raise CodecError(f"{field.path} has {len(values)} elements, allowed are {field.most}: send fewer")
        if field.tail_at_most is not None:
            tails = [each.name for each in self.fields if each.tail_at_most is not None]
            fields = {each.name: getattr(value, each.name) for each in self.fields if each.type != "count"}
            stated = tail_sizes[self.name](fields)[tails.index(field.name)]
            if stated != len(values):
                raise CodecError(f"{field.path} has {len(values)} elements, but the other fields give {stated}: "
                                 "correct one of them")
        return field.write_many(values, little)


def _raw(value: Any) -> Any:
    return _bytes(value) if isinstance(value, str) else value


def _array(field: _Field, view: memoryview, at: int, count: int, little: bool) -> Any:
    """The elements where they lie: an array of numpy, or for bytes a memoryview."""
    if field.is_bytes:
        return view[at:at + count]
    import numpy

    return numpy.frombuffer(view, numpy.dtype(field.dtype(little)), count, at)


class Struct:
    """The base of all bodies. Their fields are those of C++, with its units: mm, rad clockwise, ms."""

    layout: ClassVar[Layout]

    def __init__(self, *values: Any, **fields: Any) -> None:
        raise TypeError("rack.codec.Struct is the base of the structs of messages")

    def encode(self, little: bool = True) -> bytes:
        """The bytes of a body. CodecError names a value that the struct cannot hold."""
        return self.layout.write(self, little)

    @classmethod
    def decode(cls, body: Body, little: Optional[bool] = None) -> Self:
        """A copy of a body. `little`: its byte order, which a message states itself; of plain bytes little endian.

        CodecError: it is not this struct.
        """
        with memoryview(body) as view:  # type: ignore[arg-type]
            try:
                return cls(**cls.layout.read(view, _order(body, little), False))
            except CodecError as error:
                raise error.with_traceback(None)  # its frames hold views of the body, which may have to be released

    @classmethod
    def arrays(cls, body: Body, little: Optional[bool] = None) -> Self:
        """The same without copying its lists: they are arrays of numpy, or memoryviews, on the body itself.

        A message in place cannot be released while they live.
        """
        return cls(**cls.layout.read(memoryview(body), _order(body, little), True))  # type: ignore[arg-type]

    def si(self, field: str) -> Any:
        """A number in SI units: scan.si("maxRange") is metres."""
        for each in self.layout.fields:
            if each.name == field:
                return getattr(self, field) * each.si
        raise AttributeError(f"{self.layout.name} has no field {field}")


def _order(body: Body, little: Optional[bool]) -> bool:
    return bool(getattr(body, "little_endian", True)) if little is None else little
