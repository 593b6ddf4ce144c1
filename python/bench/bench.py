"""What a message costs in Python, beside the C API in the same run: bench.py [--csv FILE].

Lines are peer,scenario,payload_bytes,metric,value, as of tests/bench. `ratio` is the time in Python by that in C.
"""

import argparse
import os
import pathlib
import subprocess
import sys
import tempfile
import time

import tims

HERE = pathlib.Path(__file__).resolve().parent
ROUNDS = 7
SIZES = (64, 1024, 65536, 1_000_000)


def python_send_peek(session, size, count):
    """The time of one message of a thread to itself, seconds."""
    a = session.open("Tool(1/60)", 16, size)
    b = session.open("Tool(1/61)", 16, size)
    body, dest, send, peek = bytes(size), b.address, a.send, b.try_peek
    send(dest, 5, body)
    peek().release()
    start = time.perf_counter()
    for _ in range(count):
        send(dest, 5, body, priority=20)
        peek().release()
    taken = (time.perf_counter() - start) / count
    a.close()
    b.close()
    return taken


def c_send_peek(program, router, size, count):
    return float(subprocess.check_output([program, router, str(size), str(count)], text=True)) / 1e9


RECEIVER = """
import sys, time, tims
box = tims.Session().open(sys.argv[2], 1024, 64)
print("open", flush=True)
count, wanted, peek = 0, float(sys.argv[1]), box.peek
with peek(): pass
start, start_of_cpu = time.perf_counter(), time.process_time()
end = start
while end - start < wanted:
    for _ in range(256):
        with peek(5) as message: memoryview(message).release()
    count += 256; end = time.perf_counter()
print(count / (end - start), count / (time.process_time() - start_of_cpu), flush=True)
"""


def between_processes(session, instance, seconds):
    """Messages of 64 bytes a second, from a process that sends without pause: sent, received, and received in a second
    of the receiver's own processor time."""
    # Another address each time: one whose owner has gone is asked for at the router with every message.
    receiver = f"Tool(1/{instance})"
    child = subprocess.Popen([sys.executable, "-c", RECEIVER, str(seconds), receiver], stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None and child.stdout.readline() == "open\n"
    a = session.open("Tool(1/66)")
    dest, body, sent = session.address(receiver), bytes(64), 0
    start = time.perf_counter()
    while child.poll() is None:
        try:
            for _ in range(256):
                a.send(dest, 5, body, priority=20)
        except tims.Full:  # it was stopped while it took a message
            continue
        except tims.NoMailbox:  # it has ended
            break
        sent += 256
    rate = sent / (time.perf_counter() - start)
    received, received_by_cpu = map(float, child.stdout.readline().split())
    child.wait()
    a.close()
    return rate, received, received_by_cpu


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--csv", help="append the lines to this file")
    parser.add_argument("--programs", default=os.environ.get("TIMS_PROGRAMS"), help="folder of tims-router")
    parser.add_argument("--c-bench", required=True, help="the same loop in C: python-bench-c of the build")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        router = f"unix:{folder}/r.sock"
        os.environ["TIMS_ROUTER"] = router
        process = subprocess.Popen(
            [f"{chosen.programs}/tims-router", "--set", f"unix.path={folder}/r.sock", "--set", "tcp.listen=off", "--set",
             "http.listen=off"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            lines = measure(tims.Session(router, timeout=10), chosen.c_bench, router)
        finally:
            process.terminate()
            process.wait()
    print("\n".join(lines))
    if chosen.csv:
        with open(chosen.csv, "a", encoding="utf-8") as file:
            file.write("\n".join(lines) + "\n")


def measure(session, c_bench, router):
    lines = []

    def add(scenario, size, metric, value):
        lines.append(f"tims-python,{scenario},{size},{metric},{value:.4g}")

    for size in SIZES:
        count = max(2_000_000_000 // (size * 400 + 100_000), 200)
        in_turns = [(python_send_peek(session, size, count), c_send_peek(c_bench, router, size, count))
                    for _ in range(ROUNDS)]
        in_python, in_c = (min(taken) for taken in zip(*in_turns))  # others on the machine only add to it
        add("send_peek", size, "python_us", in_python * 1e6)
        add("send_peek", size, "c_us", in_c * 1e6)
        add("send_peek", size, "ratio", in_python / in_c)
    rates = [between_processes(session, 70 + i, 0.5) for i in range(ROUNDS)]
    for metric, values in zip(("sent_per_s", "received_per_s", "received_per_cpu_s"), zip(*rates)):
        add("two_processes", 64, metric, max(values))
    return lines


if __name__ == "__main__":
    main()
