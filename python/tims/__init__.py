"""Messages between the programs of robots: mailboxes, and the router that connects them.

    import tims

    with tims.Session() as session, session.open("Tool(0/7)") as mailbox:
        mailbox.send("Ladar(0/0)", tims.Type.GET_STATUS)
        with mailbox.peek(timeout=1) as answer:       # in place: its slot is held until the block ends
            print(answer.type, bytes(answer))

`rack` has the messages of RACK's components, calls for them, and components in Python.
"""

import enum

from ._tims import Mailbox, Message, Session, __version__, default_router, error_name, name_class
from .errors import (
    AddressInUse, AnsweredError, Closed, Code, Error, Full, Malformed, NoMailbox, NoRouter, Refused, Timeout, TooBig,
)

__all__ = [
    "AddressInUse", "AnsweredError", "Closed", "Code", "Error", "Event", "Flag", "Full", "Mailbox", "Malformed",
    "Message", "NoMailbox", "NoRouter", "Refused", "Session", "Timeout", "TooBig", "Type", "__version__",
    "default_router", "error_name", "name_class",
]


class Flag(enum.IntFlag):
    """Bits of a message's flags."""

    LITTLE_ENDIAN = 0x02  #: byte order of the body; not set: big endian
    FOREIGN = 0x04  #: set by the router: over TCP, WebSocket, or from another host
    STREAM = 0x10  #: a sample: a newer one may replace it on a slow link
    TRACE = 0x20  #: every router on the path reports to the sender
    REPORT_IF_GONE = 0x40  #: answer NOT_AVAILABLE when the receiver does not exist, as for commands
    REPORT_REASON = 0x80  #: a receiver that refuses the command adds the reason to ERROR


class Event(enum.IntEnum):
    """What happens to a session."""

    WAITING = 0  #: no router answers; retrying
    CONNECTED = 1  #: connected to a router, for the first time or again
    LOST = 2  #: connection to the router lost; retrying
    MAILBOX_LOST = 3  #: another program owns the address now; retried later
    MESSAGES_LOST = 4  #: messages for the former router were too old


class Type(enum.IntEnum):
    """Types of messages that all components have; those of a class are in rack.messages."""

    OK = 0
    ERROR = -1
    TIMEOUT = -2
    NOT_AVAILABLE = -3
    ENABLED = -4
    DISABLED = -5
    DATA = -6
    ON = 1
    OFF = 2
    GET_STATUS = 3
    GET_DATA = 4
    GET_CONT_DATA = 6
    STOP_CONT_DATA = 7
    GET_NEXT_DATA = 8
    GET_PARAM = 9
    SET_PARAM = 10
    GET_DESCRIPTION = 13
    CONT_DATA = -7
    PARAM = -9
    DESCRIPTION = -13
