"""Calls of a component: a command is sent, and its answer waited for.

    work = session.open("Tool(0/7)", slots=4, body_max=65536)          # for answers
    chassis = rack.messages.ChassisProxy(work, "Chassis(0/0)")
    chassis.on()
    chassis.move(vx=200)

Errors of every call, with component and command in their text: tims.AnsweredError (the component refused, with its
reason), tims.Timeout, tims.NoMailbox (no such component), tims.Malformed, and those of sending. One call at a time
uses a work mailbox; other messages that arrive there meanwhile are discarded. Its slots need room for the largest
answer.
"""

from __future__ import annotations

import json
import time
from dataclasses import dataclass
from typing import Any, ClassVar, Generic, Iterator, Optional, Sequence, TypeVar, Union

import tims
from tims import Type

from .codec import CodecError, Struct

__all__ = ["DataProxy", "Proxy", "Timeouts"]

Data = TypeVar("Data", bound=Struct)
Answer = TypeVar("Answer", bound=Struct)

REASON_MAX = 240  # bytes of the reason in an ERROR


@dataclass
class Timeouts:
    """Seconds that a call takes at most."""

    on: float = 5.0
    off: float = 1.0
    file: float = 30.0  # commands that load or save a file
    data: float = 0.1  # everything else


class Proxy:
    """Calls that every component has."""

    CLASS_ID: ClassVar[int] = 0
    COMMANDS: ClassVar[dict[int, str]] = {}  # of the class, by their types: for errors

    def __init__(self, work: tims.Mailbox, component: Union[int, str], timeouts: Timeouts = Timeouts(),
                 priority: int = 0) -> None:
        self.work = work
        self.component = work.session.address(component)
        self.timeouts = timeouts
        self.priority = priority
        self._seq_nr = 0
        self._flags = int(tims.Flag.LITTLE_ENDIAN)
        if work.body_max >= REASON_MAX:
            self._flags |= int(tims.Flag.REPORT_REASON)

    def on(self, timeout: Optional[float] = None) -> None:
        """Returns when the component is on; one with data then has its first."""
        self._ask(Type.ON, REASON_MAX.to_bytes(4, "little"), (Type.OK,), timeout or self.timeouts.on).release()

    def off(self, timeout: Optional[float] = None) -> None:
        self._ask(Type.OFF, b"", (Type.OK,), timeout or self.timeouts.off).release()

    def status(self, timeout: Optional[float] = None) -> Type:
        """Type.ENABLED (on), Type.DISABLED (off) or Type.ERROR."""
        with self._ask(Type.GET_STATUS, b"", (Type.ENABLED, Type.DISABLED, Type.ERROR), timeout) as answer:
            return Type(answer.type)

    def parameters(self) -> dict[str, Union[int, float, str]]:
        """All parameters and their values."""
        from . import messages

        got = self._query(Type.GET_PARAM, None, (Type.PARAM,), messages.ParameterList, None)
        return {each.name: (each.valueInt, each.valueString, each.valueFloat)[each.type % 3] for each in got.parameters}

    def set_parameter(self, name: str, value: Union[int, float, str]) -> None:
        """Of the type that the parameter has. AnsweredError: there is none, or the value is out of range."""
        from . import messages

        one = messages.Parameter(name=name)
        if isinstance(value, str):
            one.type, one.valueString = 1, value
        elif isinstance(value, float):
            one.type, one.valueFloat = 2, value
        else:
            one.type, one.valueInt = 0, value
        self._command(Type.SET_PARAM, messages.ParameterList(parameters=[one]), None)

    def describe(self) -> dict[str, Any]:
        """What the component states about itself: purpose, parameters, inputs, outputs."""
        from . import messages

        text = ""
        while True:
            page = self._query(Type.GET_DESCRIPTION, messages.DescriptionRequest(offset=len(text.encode())),
                              (Type.DESCRIPTION,), messages.DescriptionPage, None)
            text += page.text
            if not page.text or len(text.encode()) >= page.size:
                return dict(json.loads(text))

    # --- for commands of a class

    def _command(self, type: int, body: Optional[Struct], timeout: Optional[float]) -> None:
        """A command that is answered by OK."""
        if timeout is None and body is not None and body.layout.name == "FileName":
            timeout = self.timeouts.file
        self._ask(type, b"" if body is None else body.encode(), (Type.OK,), timeout).release()

    def _query(self, type: int, body: Optional[Struct], answers: Sequence[int], answer: type[Answer],
              timeout: Optional[float]) -> Answer:
        """A request that is answered by a message of one of these types, which has this body."""
        with self._ask(type, b"" if body is None else body.encode(), answers, timeout) as message:
            try:
                return answer.decode(message)
            except CodecError as error:
                raise tims.Malformed(tims.Code.MALFORMED, f"{self._name(type)}: {error}") from error

    def _ask(self, type: int, body: bytes, answers: Sequence[int], timeout: Optional[float] = None) -> tims.Message:
        """Sends a request; the component's answer of one of these types."""
        self._seq_nr = (self._seq_nr + 1) % 256
        end = time.monotonic() + (self.timeouts.data if timeout is None else timeout)
        try:
            self.work.send(self.component, type, body, priority=self.priority, seq_nr=self._seq_nr, flags=self._flags)
            while True:
                message = self.work.peek(max(end - time.monotonic(), 0))
                is_answer = message.src == self.component and message.seq_nr == self._seq_nr
                if is_answer and message.type in answers:
                    return message
                refusal = _refusal(message) if is_answer else None
                message.release()  # before it is raised: an exception keeps what its frames refer to
                if refusal is not None:
                    raise refusal
        except (tims.Timeout, tims.NoMailbox) as error:
            raise tims.errors.error_of(error.code, f"{self._name(type)}: {error.text}") from None
        except tims.AnsweredError as error:
            raise tims.AnsweredError(error.code, f"{self._name(type)}: {error.text}") from None

    def _name(self, type: int) -> str:
        known = self.COMMANDS.get(type) or (Type(type).name if type in Type._value2member_map_ else f"type {type}")
        return f"{self.work.session.format(self.component)}, {known}"


def _refusal(message: tims.Message) -> Optional[tims.Error]:
    """What the answer states; None: it is none."""
    if message.type == Type.NOT_AVAILABLE:
        return tims.NoMailbox(tims.Code.NO_MAILBOX, "is it running, and is there a route to it?")
    if message.type == Type.TIMEOUT:
        return tims.AnsweredError(tims.Code.ANSWERED_ERROR, "it waited for another component, which did not answer")
    if message.type == Type.ERROR:
        reason = bytes(message)[:REASON_MAX].split(b"\0", 1)[0].decode("utf-8", "replace")
        return tims.AnsweredError(tims.Code.ANSWERED_ERROR, reason or "see its log texts for the reason")
    return None


class DataProxy(Proxy, Generic[Data]):
    """A component that publishes data, on request or as a stream."""

    DATA: ClassVar[Any]

    def get_data(self, recording_time: int = 0, timeout: Optional[float] = None) -> Data:
        """The data recorded nearest to that time [ms]; 0: the newest."""
        with self._ask(Type.GET_DATA, recording_time.to_bytes(4, "little"), (Type.DATA,), timeout) as message:
            return self._decoded(message)

    def get_next_data(self, timeout: float = 2.0) -> Data:
        """The next data that are produced: the timeout should be longer than the component's period."""
        with self._ask(Type.GET_NEXT_DATA, b"", (Type.DATA,), timeout) as message:
            return self._decoded(message)

    def subscribe(self, mailbox: tims.Mailbox, period: int = 0) -> int:
        """Its data go to this mailbox from now on; returns the granted period [ms]. 0: as fast as possible."""
        body = period.to_bytes(4, "little") + mailbox.address.to_bytes(4, "little")
        with self._ask(Type.GET_CONT_DATA, body, (Type.CONT_DATA,)) as message:
            return int.from_bytes(bytes(message)[:4], "little" if message.little_endian else "big")

    def unsubscribe(self, mailbox: tims.Mailbox) -> None:
        self._ask(Type.STOP_CONT_DATA, mailbox.address.to_bytes(4, "little"), (Type.OK,)).release()

    def stream(self, mailbox: tims.Mailbox, period: int = 0, timeout: float = 2.0) -> Iterator[Data]:
        """Subscribes, and yields the data until the loop is left. AnsweredError: the component was turned off."""
        self.subscribe(mailbox, period)
        try:
            while True:
                with mailbox.peek(timeout) as message:
                    data = self.decode_stream(message)
                if data is not None:
                    yield data
        finally:
            try:
                self.unsubscribe(mailbox)
            except (tims.Error, OSError):
                pass  # it is gone, or the session is: nothing is sent any more

    def decode_stream(self, message: tims.Message) -> Optional[Data]:
        """Data of a stream; None: another message. AnsweredError: the stream has ended."""
        if message.src != self.component:
            return None
        if message.type == Type.ERROR:
            name = self.work.session.format(self.component)
            raise tims.AnsweredError(tims.Code.ANSWERED_ERROR, f"{name} ended its stream (off, or failed): subscribe "
                                     "again when it is on")
        return self._decoded(message) if message.type == Type.DATA else None

    def _decoded(self, message: tims.Message) -> Data:
        try:
            data: Data = self.DATA.decode(message)
        except CodecError as error:
            raise tims.Malformed(tims.Code.MALFORMED, f"{self.work.session.format(message.src)}: {error}") from error
        return data
