"""A mailbox in asyncio.

    mailbox = tims.aio.Receiver(session.open("Tool(0/7)", event_fd=True))
    async for message in mailbox:
        ...

Its descriptor becomes readable only after a receive that found no message. So every wait begins with one: who waited
at the descriptor alone, after having taken one message, might never wake.
"""

from __future__ import annotations

import asyncio
from typing import Callable, Optional

from . import Mailbox, Message

__all__ = ["Receiver"]


class Receiver:
    """Receives from a mailbox that was opened with event_fd=True. Any number of tasks of one loop may wait."""

    def __init__(self, mailbox: Mailbox) -> None:
        self.mailbox = mailbox
        self._descriptor = mailbox.fileno()
        self._turn = asyncio.Lock()

    async def peek(self) -> Message:
        """The next message in place, which holds its slot until it is released."""
        return await self._take(self.mailbox.try_peek)

    async def receive(self) -> Message:
        """A copy of the next message."""
        return await self._take(self.mailbox.try_receive)

    def __aiter__(self) -> Receiver:
        return self

    async def __anext__(self) -> Message:
        return await self.receive()

    async def _take(self, attempt: Callable[[], Optional[Message]]) -> Message:
        async with self._turn:
            while (message := attempt()) is None:
                await self._readable()
            return message

    async def _readable(self) -> None:
        loop = asyncio.get_running_loop()
        came: asyncio.Future[None] = loop.create_future()

        def ready() -> None:
            if not came.done():
                came.set_result(None)

        loop.add_reader(self._descriptor, ready)
        try:
            await came
        finally:
            loop.remove_reader(self._descriptor)
