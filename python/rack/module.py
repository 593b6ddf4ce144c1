"""Components in Python: the runtime of C++ (rack/module.h), whose virtual functions are methods.

    class Sweeper(rack.DataModule[LadarData]):
        DATA, CLASS_ID = LadarData, LadarProxy.CLASS_ID
        PARAMETERS = [rack.integer("period", 100, "period of the data [ms]", 10, 60000)]

        def module_on(self):
            self.period = self.integer("period")

        def module_loop(self):
            self.sleep_until_next()
            self.put(LadarData(recordingTime=rack.time_stamp(), points=measure()))

    if __name__ == "__main__":
        sys.exit(Sweeper().run())

Arguments, commands, life cycle, data of the past, listeners and log texts are those of every component. The methods are
called by other threads than the main one: module_on, module_loop, module_off by the data task, module_command by the
command task. An exception of module_on or module_loop turns the component off, and it is retried; that of a command
is answered by ERROR with the reason.
"""

from __future__ import annotations

import os
import sys
import threading
import traceback
from dataclasses import dataclass
from typing import Any, Callable, ClassVar, Generic, Optional, Sequence, Type, TypeVar, Union

import tims

from . import _rack
from .codec import Struct
from .proxy import Proxy, Timeouts

__all__ = ["Command", "DataModule", "Module", "Parameter", "Refused", "integer", "partner", "real", "text"]

Data = TypeVar("Data", bound=Struct)
Body = TypeVar("Body", bound=Struct)
Other = TypeVar("Other", bound=Proxy)

NOW, AT_ON, AT_START = 0, 1, 2  # when a new value of a parameter takes effect


class Refused(Exception):
    """A command cannot be executed: the text is the reason that its sender gets."""


@dataclass(frozen=True)
class Parameter:
    """A row of PARAMETERS: made by integer(), real(), text() and partner()."""

    name: str
    help: str
    kind: int
    number: float = 0.0
    min: float = 0.0
    max: float = 0.0
    text: Optional[str] = None
    takes_effect: int = AT_ON
    class_id: int = 0
    required: bool = False
    is_host_file: bool = False

    def row(self) -> tuple[Any, ...]:
        return (self.name, self.help, self.kind, self.takes_effect, float(self.number), float(self.min),
                float(self.max), self.text, self.class_id, int(self.required), int(self.is_host_file))


def integer(name: str, initial: int, help: str, min: int = -2**31, max: int = 2**31 - 1, *,
            takes_effect: int = AT_ON, required: bool = False) -> Parameter:
    """A whole number; `help` is one line with the unit in brackets: "period of the data [ms]"."""
    return Parameter(name, help, 0, initial, min, max, takes_effect=takes_effect, required=required)


def real(name: str, initial: float, help: str, min: float = 0.0, max: float = 0.0, *, takes_effect: int = AT_ON,
         required: bool = False) -> Parameter:
    """A number of 32 bits; min and max 0: any."""
    return Parameter(name, help, 1, initial, min, max, takes_effect=takes_effect, required=required)


def text(name: str, initial: str, help: str, *, takes_effect: int = AT_ON, required: bool = False,
         is_host_file: bool = False) -> Parameter:
    """`is_host_file`: it names a file or device of this host, which only programs of this host may change."""
    return Parameter(name, help, 2, text=initial, takes_effect=takes_effect, required=required,
                     is_host_file=is_host_file)


def partner(name: str, proxy: type[Proxy], what: str, instance: int = 0, *, optional: bool = False,
            required: bool = False) -> Parameter:
    """Another component that this one needs: declares NAMESys and NAMEInst. `optional`: -1 is none."""
    return Parameter(name, "", 3, -1 if optional and instance == 0 else instance, -1 if optional else 0, 65535, what,
                     class_id=proxy.CLASS_ID, required=required)


class Command:
    """A command that was received: `module_command` answers it by reply(), or raises."""

    def __init__(self, runtime: _rack.Runtime, header: tuple[int, int, int, int, int, int, int], body: bytes) -> None:
        self._runtime = runtime
        self._header = header
        self.body = body

    @property
    def type(self) -> int:
        return self._header[4]

    @property
    def src(self) -> int:
        return self._header[1]

    def decode(self, struct: Type[Body]) -> Body:
        """CodecError, which refuses the command: its body is not this struct."""
        return struct.decode(self.body, bool(self._header[3] & tims.Flag.LITTLE_ENDIAN))

    def reply(self, type: int = tims.Type.OK, body: Optional[Struct] = None) -> bool:
        """False: its sender does not exist any more."""
        little = sys.byteorder == "little"
        return self._runtime.reply(self._header, type, b"" if body is None else body.encode(little))

    def later(self, work: Callable[[], None]) -> None:
        """`work` answers it: it is called by the worker, while the command task answers others."""

        def guarded() -> Union[None, bytes, tuple[int, str]]:
            return _guarded(work)

        if not self._runtime.later(self._header, guarded):
            raise Refused("too many commands wait for the worker")


class Module:
    """The base of components; a program has one, and runs it in its main thread."""

    PROGRAM: ClassVar[str] = ""  #: default: the name of the class
    PURPOSE: ClassVar[str] = ""  #: for --help; default: the first line of the class's docstring
    CLASS_ID: ClassVar[int]
    CLASS_NAME: ClassVar[Optional[str]] = None  #: of a class that RACK does not define
    PARAMETERS: ClassVar[Sequence[Parameter]] = ()
    COMMAND_BODY_MAX: ClassVar[int] = 0

    def __init__(self) -> None:
        self._runtime = _rack.Runtime()
        self._session: Optional[tims.Session] = None
        self._session_lock = threading.Lock()
        self._next_local = 2

    # --- overridden by a component

    def module_init(self) -> None:
        """Once, before the tasks start. An exception ends the program."""

    def module_cleanup(self) -> None:
        """Once, after they have ended."""

    def module_on(self) -> None:
        """Acquires what it needs while on."""

    def module_loop(self) -> None:
        """Again and again while on; must return within the time that a user accepts for OFF."""
        raise NotImplementedError("module_loop")

    def module_off(self) -> None:
        """Also after one of the two has failed."""

    def module_command(self, command: Command) -> None:
        """Commands of the class (types from 21 on)."""
        raise Refused("unknown command")

    # --- used by a component

    def run(self, arguments: Optional[Sequence[str]] = None) -> int:
        """Runs the program until it is told to end; returns its exit code. `arguments`: default sys.argv[1:]."""
        if threading.current_thread() is not threading.main_thread():
            raise RuntimeError("a component runs in the main thread of its program")
        cls = type(self)
        purpose = cls.PURPOSE or (cls.__doc__ or "").strip().split("\n")[0]
        description = (cls.PROGRAM or cls.__name__, purpose, cls.CLASS_NAME, cls.CLASS_ID, 0, cls.COMMAND_BODY_MAX,
                       *self._data_description())
        rows = [each.row() for each in cls.PARAMETERS]
        return _rack.run(self, self._runtime, description, rows, list(sys.argv[1:] if arguments is None else arguments))

    def stop(self) -> None:
        """Ends run(), from any thread."""
        self._runtime.stop()

    def integer(self, name: str) -> int:
        """The present value of a parameter."""
        return self._runtime.integer(self._declared(name))

    def real(self, name: str) -> float:
        return self._runtime.real(self._declared(name))

    def text(self, name: str) -> str:
        return self._runtime.text(self._declared(name))

    def set_parameter(self, name: str, value: Union[int, str]) -> None:
        """Sets a value that the component has determined; it must be in the allowed range."""
        self._runtime.set(name, value)

    def print(self, text: str) -> None:
        """A log text; the next ones are errors, warnings, ... The parameter gdosLevel selects what is written."""
        self._runtime.log(0, text)

    def error(self, text: str) -> None:
        self._runtime.log(1, text)

    def warning(self, text: str) -> None:
        self._runtime.log(2, text)

    def info(self, text: str) -> None:
        self._runtime.log(3, text)

    @property
    def address(self) -> int:
        return self._runtime.address()

    @property
    def is_on(self) -> bool:
        return self._runtime.is_on()

    @property
    def is_wanted(self) -> bool:
        """It was not turned off and is not stopping: for a module_on() that waits."""
        return self._runtime.is_wanted()

    @property
    def period(self) -> int:
        """The period of the data, or of sleep_until_next(), ms. Set it in module_on()."""
        return self._runtime.period()

    @period.setter
    def period(self, period: int) -> None:
        self._runtime.set_period(period)

    def sleep_until_next(self) -> None:
        """In module_loop(): until the next multiple of the period since ON; missed ones are skipped."""
        self._runtime.sleep_until_next()

    @property
    def session(self) -> tims.Session:
        """A session for proxies and streams; made when it is first needed."""
        with self._session_lock:
            if self._session is None:
                self._session = tims.Session(self._runtime.router(), type(self).__name__, timeout=10)
            return self._session

    def open_mailbox(self, slots: int = 4, body_max: int = 4096, **options: Any) -> tims.Mailbox:
        """A mailbox at the component's address with a local id of its own."""
        with self._session_lock:
            local = self._next_local
            self._next_local += 1
        session = self.session
        system, class_id, instance, _ = session.split_address(self.address)
        return session.open(session.make_address(system, class_id, instance, local), slots, body_max, **options)

    def proxy(self, name: str, kind: type[Other], work: tims.Mailbox,
              timeouts: Timeouts = Timeouts()) -> Optional[Other]:
        """Calls of a partner (a row of PARAMETERS), by its present parameters; None: it works without it."""
        address = self._runtime.partner(name)
        return None if address is None else kind(work, address, timeouts)

    # --- between the runtime and the component

    def _data_description(self) -> tuple[int, int, int, int, int, bool]:
        return 0, 0, 0, 0, 0, False

    def _declared(self, name: str) -> str:
        if name not in _COMMON and all(name not in _names_of(each) for each in self.PARAMETERS):
            raise KeyError(f"{name} is not among the PARAMETERS of {type(self).__name__}")
        return name

    def _call(self, name: str, *arguments: Any) -> Union[None, bytes, tuple[int, str]]:
        return _guarded(getattr(self, name), *arguments)

    def _command(self, header: tuple[int, int, int, int, int, int, int], body: bytes) -> None:
        self.module_command(Command(self._runtime, header, body))


class DataModule(Module, Generic[Data]):
    """A component that produces data: they are kept for a while, sent to listeners, and requested by their time."""

    DATA: ClassVar[Any]  #: the struct, whose first field is recordingTime
    DATA_MAX: ClassVar[int] = 0  #: bytes; default: what the struct needs at most
    HISTORY: ClassVar[int] = 10  #: data sets that can be requested
    LISTENERS: ClassVar[int] = 64
    AHEAD: ClassVar[int] = 0  #: ms after the newest data that between() extrapolates
    SAMPLES: ClassVar[bool] = True  #: a newer data set replaces an older one on a slow link

    def put(self, data: Data) -> None:
        """Keeps a data set and sends it. CodecError: a value that does not fit."""
        self._runtime.publish(getattr(data, "recordingTime"), data.encode(sys.byteorder == "little"))

    def between(self, before: Data, after: Data, time: int) -> Data:
        """Data of a requested time [ms], from those before and after it: a component that has this method interpolates.

        Up to AHEAD ms after the newest, `before` and `after` are the newest two. Called by the command task. Without it a
        request gets the data that are nearest to its time.
        """
        raise NotImplementedError("between")

    def _data_description(self) -> tuple[int, int, int, int, int, bool]:
        layout = self.DATA.layout
        most = layout.size + sum(each.size * each.most for each in layout.fields if each.is_variable)
        interpolates = type(self).between is not DataModule.between
        return self.DATA_MAX or most, self.HISTORY, self.LISTENERS, int(not self.SAMPLES), self.AHEAD, interpolates

    def _between(self, time: int, before: bytes, after: bytes) -> bytes:
        little = sys.byteorder == "little"
        result = self.between(self.DATA.decode(before, little), self.DATA.decode(after, little), time)
        return result.encode(little)


_COMMON = {"system", "instance", "gdosLevel", "targetStatus", "cmdTaskPrio", "dataTaskPrio", "cpu", "errorTimeout"}


def _names_of(parameter: Parameter) -> tuple[str, ...]:
    if parameter.kind == 3:
        return f"{parameter.name}Sys", f"{parameter.name}Inst"
    return (parameter.name,)


def _guarded(function: Callable[..., Optional[bytes]], *arguments: Any) -> Union[None, bytes, tuple[int, str]]:
    """Calls it, and returns what it does; an exception as the runtime takes it. Those of the code itself are shown with their place."""
    try:
        return function(*arguments)
    except tims.Error as error:
        return int(error.code), error.text
    except (Refused, OSError, ValueError) as error:
        return int(tims.Code.INVALID), str(error) or type(error).__name__
    except BaseException as error:  # noqa: BLE001: whatever it is, the component goes to the state ERROR
        traceback.print_exc()
        last = traceback.extract_tb(error.__traceback__)[-1]
        place = f"{os.path.basename(last.filename)}:{last.lineno}"
        return int(tims.Code.INVALID), f"{type(error).__name__}: {error} ({place})"
