"""Sessions, mailboxes and messages."""

import contextlib
import gc
import os
import pickle
import signal
import sys
import threading
import unittest
import weakref

import tims
from support import PATIENCE, WithRouter, eventually


class Messages(WithRouter):
    def test_a_message_arrives_as_it_was_sent(self):
        a, b = self.pair()
        a.send(b.address, 21, b"hello", priority=9, seq_nr=3, flags=tims.Flag.STREAM | tims.Flag.LITTLE_ENDIAN)
        with b.peek(timeout=PATIENCE) as message:
            self.assertEqual(bytes(message), b"hello")
            self.assertEqual((message.type, message.priority, message.seq_nr), (21, 9, 3))
            self.assertEqual((message.src, message.dest), (a.address, b.address))
            self.assertTrue(message.in_place and message.little_endian)
            self.assertEqual(message.flags & tims.Flag.STREAM, tims.Flag.STREAM)
            self.assertEqual(len(message), 5)
            b.reply(message, -21, memoryview(b"world"))
        answer = a.receive(timeout=PATIENCE)
        self.assertEqual((answer.type, answer.priority, answer.seq_nr, bytes(answer)), (-21, 9, 3, b"world"))
        self.assertFalse(answer.in_place)

    def test_without_waiting_there_is_none(self):
        a, b = self.pair()
        self.assertIsNone(b.try_peek())
        self.assertIsNone(b.try_receive())
        a.send(b.address, 0)
        self.assertEqual(len(b.try_receive()), 0)

    def test_the_time_is_over(self):
        _, b = self.pair()
        with self.assertRaises(tims.Timeout) as caught:
            b.peek(0.01)
        self.assertIsInstance(caught.exception, TimeoutError)
        self.assertEqual(caught.exception.code, tims.Code.TIMEOUT)
        self.assertIn("timsctl", caught.exception.hint)

    def test_sizes_at_and_above_the_limit(self):
        a, b = self.pair(body_max=5000)
        a.send(b.address, 1, bytes(5000))
        self.assertEqual(len(b.receive(PATIENCE)), 5000)
        with self.assertRaises(tims.TooBig):
            a.send(b.address, 1, bytes(5001))

    def test_a_full_mailbox_keeps_what_is_more_important(self):
        a, b = self.pair(slots=1)
        a.send(b.address, 1, b"x", priority=5)
        with self.assertRaises(tims.Full):
            a.send(b.address, 1, b"y", priority=4)
        self.assertEqual(b.counters()["refused"], 1)
        self.assertEqual(b.clean(), 1)

    def test_addresses_are_numbers_or_texts(self):
        session = self.session()
        number = session.address("Ladar(3/0):2")
        self.assertEqual(number, 0x03140002)
        self.assertEqual(session.format(number), "Ladar(3/0):2")
        self.assertEqual(session.make_address(3, 20, 0, 2), number)
        self.assertEqual(session.split_address(number), (3, 20, 0, 2))
        for wrong in ("Nonsense(1/1)", "Ladar", "Ladar(1/1)\0"):
            with self.assertRaises((tims.Error, ValueError)):
                session.address(wrong)
        for wrong in (-1, 2**32):
            with self.assertRaises(ValueError):
                session.address(wrong)
            with self.assertRaisesRegex(ValueError, "instance is"):
                session.make_address(3, 20, wrong)

    def test_wrong_arguments_are_named(self):
        a, b = self.pair()
        for call, text in (
            (lambda: a.send(b.address, 128), "type is 128: expected -128 to 127"),
            (lambda: a.send(b.address, 1, priority=256), "priority is 256"),
            (lambda: a.send(b.address, 1, b"", 5), "at most 3 arguments"),
            (lambda: a.send(b.address), "needs the argument type"),
            (lambda: a.send(b.address, 1, colour=2), "has no argument 'colour'"),
            (lambda: a.send(b.address, 1, type=2), "'type' twice"),
            (lambda: a.send(b.address, 1, "text"), "bytes-like object"),
            (lambda: b.peek("soon"), "must be real number"),
            (lambda: b.peek(float("nan")), "not a number of seconds"),
            (lambda: a.session.open("Tool(1/43)", slots=0), "slots is 0"),
            (lambda: a.session.open("Tool(1/43)", slots=4, held_max=5), "held_max is 5: expected 1 to 4"),
        ):
            with self.assertRaisesRegex((TypeError, ValueError), text):
                call()

        class Undecided:
            def __bool__(self):
                raise ValueError("neither")

        with self.assertRaisesRegex(ValueError, "neither"):
            a.session.open("Tool(1/43)", event_fd=Undecided())

    def test_a_code_that_this_package_does_not_know(self):
        error = tims.errors.error_of(-99, "a newer library")
        self.assertEqual((type(error), error.code, str(error)), (tims.Error, -99, "a newer library"))
        self.assertEqual(pickle.loads(pickle.dumps(error)).code, -99)

    def test_an_address_has_one_owner(self):
        a, _ = self.pair()
        with self.assertRaises(tims.AddressInUse) as caught:
            self.session().open(a.address)
        self.assertEqual(pickle.loads(pickle.dumps(caught.exception)).code, tims.Code.ADDRESS_IN_USE)

    def test_who_does_not_exist_is_reported(self):
        a, _ = self.pair()
        a.send("Ladar(9/9)", 1)
        self.assertEqual(a.receive(PATIENCE).type, tims.Type.NOT_AVAILABLE)

    def test_sessions_end_with_their_last_mailbox(self):
        session = self.session()
        mailbox = session.open("Tool(1/44)")
        session.close()
        with self.assertRaises(tims.Closed):
            session.open("Tool(1/45)")
        mailbox.send(mailbox.address, 5)
        self.assertEqual(mailbox.receive(PATIENCE).type, 5)
        self.assertTrue(mailbox.session.closed)
        mailbox.close()
        self.session().open("Tool(1/44)").close()

    def test_events_can_be_collected(self):
        session = self.session(collect_events=True)
        events = eventually(session.take_events)
        self.assertEqual(events[0][0], tims.Event.CONNECTED)
        self.assertEqual(session.take_events(), [])

    def test_no_router(self):
        with self.assertRaises(tims.Timeout):
            tims.Session(f"unix:{self.folder}/nothing.sock", timeout=0.05, collect_events=True)


class InPlace(WithRouter):
    """Messages that hold their slot."""

    def test_a_view_keeps_the_message(self):
        a, b = self.pair()
        a.send(b.address, 1, b"abc")
        message = b.peek(PATIENCE)
        view = memoryview(message)
        self.assertTrue(view.readonly)
        with self.assertRaisesRegex(BufferError, "1 views of the message live"):
            message.release()
        self.assertEqual(view.tobytes(), b"abc")
        view.release()
        message.release()
        message.release()
        with self.assertRaisesRegex(BufferError, "was released"):
            memoryview(message)

    def test_a_with_block_reports_views_that_stay(self):
        a, b = self.pair()
        a.send(b.address, 1, b"abc")
        with self.assertRaises(BufferError):
            with b.peek(PATIENCE) as message:
                view = memoryview(message)
        del view
        message.release()
        self.assertEqual(b.held, 0)

    def test_slots_held_are_bounded(self):
        a, b = self.pair(slots=8, held_max=3)
        for i in range(4):
            a.send(b.address, 1, bytes([i]))
        held = [b.peek(PATIENCE) for _ in range(3)]
        with self.assertRaisesRegex(tims.Error, "3 messages of the mailbox Tool"):
            b.peek(PATIENCE)
        self.assertEqual(bytes(b.receive(PATIENCE)), b"\3")  # copies go on
        del held
        self.assertEqual(b.held, 0)

    def test_slots_held_are_bounded_for_threads_that_wait(self):
        a, b = self.pair(slots=8, held_max=1)
        got = []
        with _no_forced_switch():
            threads = [threading.Thread(target=lambda: got.append(b.peek(PATIENCE))) for _ in range(4)]
            for thread in threads:
                thread.start()  # returns when the thread has given the GIL up, in its wait
            for i in range(4):
                a.send(b.address, 1, bytes([i]))
            for thread in threads:
                thread.join()
        self.assertEqual(sorted(bytes(message) for message in got), [b"\0", b"\1", b"\2", b"\3"])
        self.assertEqual((b.held, sum(message.in_place for message in got)), (1, 1))

    def test_the_collector_frees_slots(self):
        a, b = self.pair(slots=4)
        a.send(b.address, 1, b"abc")

        class Keeper:
            pass

        keeper = Keeper()
        keeper.message = b.peek(PATIENCE)
        keeper.self = keeper
        there = weakref.ref(keeper)
        del keeper
        gc.collect()
        self.assertIsNone(there())
        self.assertEqual(b.held, 0)

    def test_a_view_outlives_mailbox_and_session(self):
        session = self.session()
        mailbox = session.open("Tool(1/46)")
        mailbox.send(mailbox.address, 1, b"still here")
        view = memoryview(mailbox.peek(PATIENCE))
        mailbox.close()
        session.close()
        del mailbox, session
        gc.collect()
        self.assertEqual(view.tobytes(), b"still here")
        with self.assertRaises(tims.AddressInUse):
            self.session().open("Tool(1/46)")
        del view
        self.session().open("Tool(1/46)").close()

    def test_ten_thousand_messages_leave_nothing(self):
        a, b = self.pair()

        def round_trip():
            a.send(b.address, 1, bytes(64))
            with b.peek(PATIENCE) as message:
                memoryview(message).release()
            a.send(b.address, 1, bytes(64))
            b.receive(PATIENCE)
            b.try_peek()
            try:
                b.peek(0)
            except tims.Timeout:
                pass

        for _ in range(100):
            round_trip()
        before = _allocated()
        for _ in range(10_000):
            round_trip()
        self.assertLess(_allocated() - before, 500)


    def test_memory_of_the_library_does_not_grow(self):
        """What Python does not count: guards, sessions with their threads, mailboxes, events."""
        a, b = self.pair()

        def use(times):
            for _ in range(times):
                a.send(b.address, 1, bytes(64))
                b.peek(PATIENCE).release()
            for _ in range(times // 1000):
                session = tims.Session(self.router, timeout=PATIENCE, collect_events=True)
                mailbox = session.open("Tool(1/50)")
                mailbox.send(mailbox.address, 1)
                mailbox.peek(PATIENCE)
                mailbox.close()
                session.close()

        use(5_000)
        before = _resident()
        use(50_000)
        self.assertLess(_resident() - before, 4_000_000)


def _resident():
    """Bytes."""
    gc.collect()
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def _allocated():
    gc.collect()
    return sys.getallocatedblocks()


@contextlib.contextmanager
def _no_forced_switch():
    """Within, another thread of Python runs only when one has given the GIL up: in start() that is when it waits."""
    former = sys.getswitchinterval()
    sys.setswitchinterval(1000)
    try:
        yield
    finally:
        sys.setswitchinterval(former)


class Waiting(WithRouter):
    def test_other_threads_run_while_one_waits(self):
        a, b = self.pair()
        got = []

        def wait():
            got.append("waits")
            got.append(bytes(b.receive(PATIENCE)))

        with _no_forced_switch():
            thread = threading.Thread(target=wait)
            thread.start()
            self.assertEqual(got, ["waits"])
            a.send(b.address, 1, b"go")
            thread.join()
        self.assertEqual(got, ["waits", b"go"])

    def test_close_ends_a_wait(self):
        _, b = self.pair()
        caught = []

        def wait():
            caught.append("waits")
            try:
                b.peek()
            except tims.Closed as error:
                caught.append(str(error))

        with _no_forced_switch():
            thread = threading.Thread(target=wait)
            thread.start()
            self.assertEqual(caught, ["waits"])
            b.close()
            thread.join(PATIENCE)
        self.assertEqual(caught[1:], ["the mailbox was closed while it waited for a message"])
        self.session().open("Tool(1/41)").close()

    def test_many_threads_share_a_mailbox(self):
        a, b = self.pair(slots=1024)
        got = []

        def take():
            while (message := b.receive(PATIENCE)).type != 2:
                got.append(int.from_bytes(bytes(message), "little"))

        threads = [threading.Thread(target=take) for _ in range(4)]
        for thread in threads:
            thread.start()
        for i in range(900):
            a.send(b.address, 1, i.to_bytes(2, "little"))
        for _ in threads:
            a.send(b.address, 2)
        for thread in threads:
            thread.join(PATIENCE)
        self.assertEqual(sorted(got), list(range(900)))

    def test_ctrl_c_ends_a_wait(self):
        for wait in ("session.open('Tool(2/1)').peek()", "session.open('Tool(2/1)').receive()",
                     "tims.Session('unix:/nowhere/r.sock', collect_events=True)"):
            child = self.child(
                "import os, sys, threading, tims\n"
                "session = tims.Session()\n"
                f"try: print('waits'); {wait}\n"
                "except KeyboardInterrupt: print('interrupted'); sys.exit(7)\n")
            child.wait_for_line("waits")
            child.process.send_signal(signal.SIGINT)
            self.assertEqual(child.wait(), 7, child.lines)


class StoppedRouter(WithRouter):
    """Calls that wait for a router that does not answer: other threads go on, and Ctrl-C ends them."""

    def stop(self):
        self.router_process.process.send_signal(signal.SIGSTOP)
        self.addCleanup(self.let_go_on)

    def let_go_on(self):
        self.router_process.process.send_signal(signal.SIGCONT)

    def assert_others_go_on(self, call, then=lambda: None):
        """While a thread is in this call: `then` is done by another one."""
        done = []

        def work():
            try:
                call()
            finally:
                done.append("the call has ended")

        with _no_forced_switch():
            thread = threading.Thread(target=work)
            thread.start()
            done.append("others go on")
            then()
            thread.join()
        self.assertEqual(done, ["others go on", "the call has ended"])

    def test_close(self):
        _, b = self.pair()
        self.stop()
        self.assert_others_go_on(b.close, self.let_go_on)

    def test_close_by_the_last_message_in_place(self):
        a, b = self.pair()
        a.send(b.address, 1)
        held = [b.peek(PATIENCE)]
        b.close()
        self.stop()
        self.assert_others_go_on(held.clear, self.let_go_on)
        self.session().open("Tool(1/41)").close()

    def test_send_to_a_receiver_that_has_closed(self):
        a, b = self.pair()
        address = b.address
        a.send(address, 1)
        b.close()
        self.stop()
        self.assert_others_go_on(lambda: a.send(address, 1), self.let_go_on)
        self.assertEqual(a.receive(PATIENCE).type, tims.Type.NOT_AVAILABLE)

    def test_send_when_the_way_to_other_hosts_is_full(self):
        a, _ = self.pair()
        a.send("Ladar(9/9)", -6)
        a.session.flush(PATIENCE)
        self.stop()

        def fill():
            with self.assertRaises(tims.Full):
                while True:
                    a.send("Ladar(9/9)", -6)

        self.assert_others_go_on(fill)

    def test_open(self):
        session = self.session()
        self.stop()
        self.assert_others_go_on(lambda: session.open("Tool(1/47)").close(), self.let_go_on)

    def test_closing_the_session_ends_an_open(self):
        session = self.session()
        self.stop()

        def refused():
            with self.assertRaisesRegex(tims.Closed, "session was closed"):
                session.open("Tool(1/48)")

        self.assert_others_go_on(refused, session.close)
        self.let_go_on()
        self.session().open("Tool(1/48)").close()

    def test_ctrl_c_ends_an_open(self):
        self.addCleanup(self.let_go_on)
        child = self.child(
            "import os, signal, sys, threading, tims\n"
            "router = int(sys.argv[1])\n"
            "session = tims.Session()\n"
            "sys.setswitchinterval(1000)\n"
            "begin = threading.Lock(); begin.acquire()\n"
            "def tell(): begin.acquire(); print('waits')\n"
            "threading.Thread(target=tell, daemon=True).start()\n"
            "os.kill(router, signal.SIGSTOP)\n"
            "try: begin.release(); session.open('Tool(2/1)')\n"
            "except KeyboardInterrupt: print('interrupted')\n"
            "os.kill(router, signal.SIGCONT)\n"
            "session.open('Tool(2/1)').close()\n"  # what was asked for is taken back
            "sys.exit(7)\n", self.router_process.process.pid)
        child.wait_for_line("waits")
        child.process.send_signal(signal.SIGINT)
        child.wait_for_line("interrupted")
        self.assertEqual(child.wait(), 7, child.lines)


class Processes(WithRouter):
    """What becomes of a slot, a session or a wait when its process does something else."""

    def test_killed_while_it_holds_a_message(self):
        child = self.child(
            "import tims\n"
            "box = tims.Session().open('Tool(3/1)', slots=2)\n"
            "print('open')\n"
            "message = box.peek(); view = memoryview(message)\n"
            "print('holds')\n"
            "box.peek()\n")
        child.wait_for_line("open")
        a, _ = self.pair()
        a.send("Tool(3/1)", 1, bytes(64))
        child.wait_for_line("holds")
        child.process.kill()
        child.wait()
        # Its mailbox is gone, the sender notices it, and the next owner starts afresh.
        session = self.session()
        again = eventually(lambda: _opened(session, "Tool(3/1)"))
        _send_patiently(a, "Tool(3/1)", b"new")
        self.assertEqual(bytes(again.receive(PATIENCE)), b"new")
        again.close()

    def test_a_child_process_has_no_part_in_it(self):
        child = self.child(
            "import os, sys, gc, tims\n"
            "session = tims.Session(); box = session.open('Tool(3/2)')\n"
            "box.send(box.address, 1, b'parent'); message = box.peek(1)\n"
            "pid = os.fork()\n"
            "if pid == 0:\n"
            "    refused = 0\n"
            "    for call in (lambda: box.try_peek(), lambda: box.send(box.address, 1), lambda: session.open('Tool(3/3)')):\n"
            "        try: call()\n"
            "        except tims.Closed as error: refused += 'fork()' in str(error)\n"
            "    message.release(); del message, box, session; gc.collect()\n"
            "    own = tims.Session(); box = own.open('Tool(3/4)'); box.send(box.address, 1)\n"
            "    sys.exit(refused * 10 + (box.receive(5).type == 1))\n"
            "print(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]))\n"
            "assert bytes(message) == b'parent' and box.held == 1\n"
            "message.release(); box.send(box.address, 2); assert box.receive(1).type == 2\n")
        child.wait_for_line("31")
        self.assertEqual(child.wait(), 0, child.lines)

    def test_the_interpreter_ends_while_all_is_open(self):
        endings = {
            "objects": "",
            "a view": "box.send(box.address, 1, b'x'); view = memoryview(box.peek(5))",
            "a cycle": "box.send(box.address, 1, b'x'); keep = [box.peek(5)]; keep.append(keep)",
            "a thread that waits": "import threading; threading.Thread(target=box.peek, daemon=True).start()",
            "a global of another module": "import sys; sys.kept = (session, box)",
            "an exit in a wait": "import threading, os; threading.Timer(0.05, os._exit, (0,)).start(); box.peek()",
        }
        for what, code in endings.items():
            with self.subTest(what):
                child = self.child(
                    f"import tims\nsession = tims.Session(); box = session.open('Tool(3/5)')\n{code}\n")
                self.assertEqual(child.wait(), 0, child.lines)
                eventually(lambda: _opened(self.session(), "Tool(3/5)")).close()

    def test_two_copies_of_the_module_in_one_process(self):
        child = self.child("import importlib, sys, tims\n"
                           "a = tims.Session(); first = sys.modules.pop('tims._tims'); del sys.modules['tims']\n"
                           "import tims as second\n"
                           "b = second.Session(); box = b.open('Tool(3/6)'); box.send(box.address, 1)\n"
                           "assert box.receive(5).type == 1 and type(a) is not type(b)\n")
        self.assertEqual(child.wait(), 0, child.lines)


def _opened(session, address):
    try:
        return session.open(address)
    except tims.AddressInUse:
        return None


def _send_patiently(mailbox, address, body):
    def sent():
        try:
            mailbox.send(address, 1, body)
            return True
        except tims.NoMailbox:
            return False

    eventually(sent, "the new mailbox is known")


if __name__ == "__main__":
    unittest.main()
