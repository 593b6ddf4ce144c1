"""The exceptions of tims: each has the library's code, its sentence, and what to do."""

from __future__ import annotations

import enum
from typing import Union

__all__ = [
    "AddressInUse", "AnsweredError", "Closed", "Code", "Error", "Full", "Malformed", "NoMailbox", "NoRouter",
    "Refused", "Timeout", "TooBig", "error_of",
]


class Code(enum.IntEnum):
    """As in tims.h."""

    EMPTY = -1
    TIMEOUT = -2
    CLOSED = -3
    NO_ROUTER = -4
    REFUSED = -5
    ADDRESS_IN_USE = -6
    NO_MAILBOX = -7
    FULL = -8
    TOO_BIG = -9
    BUFFER_TOO_SMALL = -10
    RECLAIMED = -11
    BAD_LAYOUT = -12
    VERSION = -13
    INVALID = -14
    SYSTEM = -15
    ANSWERED_ERROR = -16
    MALFORMED = -17
    DISKFULL = -18


_HINTS: dict[int, str] = {
    Code.TIMEOUT: "wait longer, or see by `timsctl component list` whether the other side runs",
    Code.NO_ROUTER: "start tims-router on this host, or see by `timsctl doctor` why it does not answer",
    Code.ADDRESS_IN_USE: "choose another instance, or end the program that the text names",
    Code.NO_MAILBOX: "`timsctl component list` shows what is there",
    Code.FULL: "the receiver is slower than its messages: send fewer, or with a higher priority",
    Code.TOO_BIG: "the receiver's mailbox needs a larger body_max",
    Code.VERSION: "install the same version of libtims and tims-router",
}


def _known(code: int) -> Union[Code, int]:
    """A library that is newer than this package may have further codes."""
    try:
        return Code(code)
    except ValueError:
        return code


class Error(Exception):
    """A call failed. `code` states the reason, `text` the details, `hint` what to do next (or is empty)."""

    def __init__(self, code: int, text: str) -> None:
        super().__init__(text)
        self.code: Union[Code, int] = _known(code)
        self.text = text

    @property
    def hint(self) -> str:
        return _HINTS.get(self.code, "")

    def __str__(self) -> str:
        return f"{self.text} ({self.hint})" if self.hint else self.text

    def __reduce__(self) -> tuple[type, tuple[int, str]]:
        return type(self), (int(self.code), self.text)


class Timeout(Error, TimeoutError):
    """Nothing came in the given time."""


class NoRouter(Error, ConnectionError):
    """There is no router, or it did not answer."""


class Closed(Error):
    """The session or mailbox was closed, or belongs to the parent process."""


class Refused(Error):
    """The router refused the request."""


class AddressInUse(Error):
    """Another program owns the address; the text names it."""


class NoMailbox(Error):
    """No mailbox has the address."""


class Full(Error):
    """The receiver is full of more important messages."""


class TooBig(Error):
    """The message is larger than the receiver accepts."""


class AnsweredError(Error):
    """A component answered ERROR; the text has its reason."""


class Malformed(Error):
    """Bytes that do not form the expected message."""


_CLASSES: dict[int, type[Error]] = {
    Code.TIMEOUT: Timeout,
    Code.NO_ROUTER: NoRouter,
    Code.CLOSED: Closed,
    Code.REFUSED: Refused,
    Code.ADDRESS_IN_USE: AddressInUse,
    Code.NO_MAILBOX: NoMailbox,
    Code.FULL: Full,
    Code.TOO_BIG: TooBig,
    Code.ANSWERED_ERROR: AnsweredError,
    Code.MALFORMED: Malformed,
}


def error_of(code: int, text: str) -> Error:
    """The exception for a code of the library."""
    return _CLASSES.get(code, Error)(code, text)
