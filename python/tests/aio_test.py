"""Mailboxes in asyncio."""

import asyncio
import os
import socket
import unittest

import tims
import tims.aio
from support import PATIENCE, WithRouter


class Aio(WithRouter):
    def receiver(self):
        a, b = self.pair(event_fd=True, slots=64)
        return a, tims.aio.Receiver(b)

    def run_patiently(self, work):
        return asyncio.run(asyncio.wait_for(work, PATIENCE))

    def test_a_message_wakes_the_loop(self):
        a, receiver = self.receiver()

        async def work():
            task = asyncio.create_task(receiver.receive())
            await asyncio.sleep(0)
            a.send(receiver.mailbox.address, 1, b"late")
            return bytes(await task)

        self.assertEqual(self.run_patiently(work()), b"late")

    def test_messages_from_before_the_first_wait_are_found(self):
        a, receiver = self.receiver()
        a.send(receiver.mailbox.address, 1, b"1")
        a.send(receiver.mailbox.address, 1, b"2")
        self.assertEqual(bytes(receiver.mailbox.receive(PATIENCE)), b"1")  # taken without asyncio: not armed

        async def work():
            got = [bytes(await receiver.receive())]
            task = asyncio.create_task(receiver.receive())
            await asyncio.sleep(0)
            a.send(receiver.mailbox.address, 1, b"3")
            return [*got, bytes(await task)]

        self.assertEqual(self.run_patiently(work()), [b"2", b"3"])

    def test_two_thousand_messages_among_three_tasks(self):
        a, receiver = self.receiver()

        async def take(got):
            async for message in receiver:
                got.append(bytes(message))
                if len(got) == 2000:
                    return

        async def work():
            got = []
            tasks = [asyncio.create_task(take(got)) for _ in range(3)]
            for i in range(2000):
                a.send(receiver.mailbox.address, 1, i.to_bytes(2, "big"))
                while receiver.mailbox.counters()["waiting"] > i % 50:
                    await asyncio.sleep(0)
            await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            return got

        self.assertEqual(sorted(self.run_patiently(work())), [i.to_bytes(2, "big") for i in range(2000)])

    def test_a_cancelled_wait_takes_nothing(self):
        a, receiver = self.receiver()

        async def work():
            with self.assertRaises(asyncio.TimeoutError):
                await asyncio.wait_for(receiver.peek(), 0.01)
            a.send(receiver.mailbox.address, 1, b"x")
            with await receiver.peek() as message:
                return bytes(message)

        self.assertEqual(self.run_patiently(work()), b"x")

    def test_closing_ends_the_waits(self):
        """By the receiver at once, by the mailbox as soon as no message in place is held."""
        for close in (lambda receiver: receiver.close(), lambda receiver: receiver.mailbox.close()):
            a, receiver = self.receiver()

            async def work():
                tasks = [asyncio.create_task(receiver.receive()) for _ in range(3)]
                await asyncio.sleep(0)
                close(receiver)
                for task in tasks:
                    with self.assertRaises(tims.Closed):
                        await task
                with self.assertRaises(tims.Closed):
                    await receiver.peek()
                receiver.close()

            self.run_patiently(work())
            a.close()

    def test_closing_ends_a_wait_while_a_message_is_held(self):
        a, receiver = self.receiver()
        a.send(receiver.mailbox.address, 1)

        async def work():
            held = await receiver.peek()
            task = asyncio.create_task(receiver.receive())
            await asyncio.sleep(0)
            receiver.close()
            with self.assertRaises(tims.Closed):
                await task
            held.release()

        self.run_patiently(work())

    def test_a_wait_that_is_cancelled_after_closing_leaves_other_files_alone(self):
        _, receiver = self.receiver()

        async def work():
            task = asyncio.create_task(receiver.receive())
            await asyncio.sleep(0)
            used = receiver.mailbox.fileno()
            a, b = socket.socketpair()
            receiver.mailbox.close()
            os.dup2(a.fileno(), used)  # the number is another file's now
            came = asyncio.Event()
            asyncio.get_running_loop().add_reader(used, came.set)
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)
            b.send(b"x")
            await came.wait()
            asyncio.get_running_loop().remove_reader(used)
            os.close(used)
            a.close()
            b.close()

        self.run_patiently(work())

    def test_a_mailbox_without_descriptor_is_refused(self):
        a, _ = self.pair()
        with self.assertRaisesRegex(tims.Error, "event_fd=True"):
            tims.aio.Receiver(a)


if __name__ == "__main__":
    unittest.main()
