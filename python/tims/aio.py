"""A mailbox in asyncio.

    receiver = tims.aio.Receiver(session.open("Tool(0/7)", event_fd=True))
    async for message in receiver:
        ...

Its descriptor becomes readable only after a receive that found no message. So every wait begins with one: who waited
at the descriptor alone, after having taken one message, might never wake.
"""

from __future__ import annotations

import asyncio
import os
from typing import Callable, Optional

from . import Closed, Mailbox, Message

__all__ = ["Receiver"]


class Receiver:
    """Receives from a mailbox that was opened with event_fd=True. Any number of tasks of one loop may wait.

    They get tims.Closed when it is closed: by close() at once; by close() of the mailbox as soon as no message in place
    is held.
    """

    def __init__(self, mailbox: Mailbox) -> None:
        self.mailbox = mailbox
        # A descriptor of its own: the loop would forget that of a mailbox that is closed, and its number may be another
        # file's then.
        self._descriptor: Optional[int] = os.dup(mailbox.fileno())
        self._came: Optional[asyncio.Future[None]] = None
        self._turn = asyncio.Lock()

    def __del__(self) -> None:
        self._close_descriptor()

    async def peek(self) -> Message:
        """The next message in place, which holds its slot until it is released."""
        return await self._take(self.mailbox.try_peek)

    async def receive(self) -> Message:
        """A copy of the next message."""
        return await self._take(self.mailbox.try_receive)

    def close(self) -> None:
        """Closes the mailbox; tasks that wait for a message get tims.Closed. To be called in their loop."""
        self.mailbox.close()
        if self._came is None:
            self._close_descriptor()
        else:
            _finish(self._came)

    def __aiter__(self) -> Receiver:
        return self

    async def __anext__(self) -> Message:
        return await self.receive()

    async def _take(self, attempt: Callable[[], Optional[Message]]) -> Message:
        async with self._turn:
            try:
                while (message := attempt()) is None:
                    await self._readable()
                return message
            except Closed:
                self._close_descriptor()
                raise

    async def _readable(self) -> None:
        if self._descriptor is None:
            return  # closed: the next attempt raises it
        loop = asyncio.get_running_loop()
        self._came = loop.create_future()
        loop.add_reader(self._descriptor, _finish, self._came)
        try:
            await self._came
        finally:
            loop.remove_reader(self._descriptor)
            self._came = None
            if self.mailbox.closed:
                self._close_descriptor()

    def _close_descriptor(self) -> None:
        descriptor, self._descriptor = self._descriptor, None
        if descriptor is not None:
            os.close(descriptor)


def _finish(came: asyncio.Future[None]) -> None:
    if not came.done():
        came.set_result(None)
