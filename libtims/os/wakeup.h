// Waiting until something happens, and waking whoever waits: on a word in shared memory, on a
// counter of the kernel, on a socket between programs that do not trust each other, on any
// descriptor.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>

#include <poll.h>

#include "os/clock.h"
#include "os/file.h"
#include "tims/time.h"

namespace tims::os {

// --- A word in shared memory (futex)

// Until the word is no longer `expected`, a wake-up, or the deadline. May return early.
void futex_wait(const std::atomic<std::uint32_t>& word, std::uint32_t expected, Time deadline);

// Clears bit 0 of the word and wakes one sleeper, as one step of the kernel: a process that dies
// here has done both or nothing.
void futex_clear_and_wake(const std::atomic<std::uint32_t>& word);

// --- A counter (eventfd): an event loop can wait for it. Between threads of one program, and for
// programs that trust whoever made it.

Result<File> make_event_fd();
void signal_event_fd(int fd);
// Never waits: the descriptor's own flags can be changed by whoever shares it.
void drain_event_fd(int fd);

// --- A wake-up between programs that do not trust each other: a pair of datagram sockets. The
// owner keeps one end, for its event loop, and gives the other away; what is sent there wakes it.
//
// An eventfd would not do: its flags belong to everybody who has it, so that its owner could fill
// it, clear O_NONBLOCK, and have whoever wants to wake it wait.

struct WakePair {
  File woken;  // readable until drain_wakes()
  File waker;
};
Result<WakePair> make_wake_pair();
// Whether a descriptor that somebody gave us is a waker. Sockets of other families can be locked
// for as long as another program likes, which MSG_DONTWAIT waits for all the same.
bool is_waker(int fd);
// Never waits, whatever has been done to the sockets. When no more goes in, there is enough to wake
// the owner. Empty: it means nothing to whoever else it may reach.
void wake(int waker);
void drain_wakes(int woken);

// --- Any descriptor

// poll(2) until one of them reports what is asked of it; false at the deadline.
bool poll_until(std::span<pollfd> waits, Time deadline);
// Whether poll() reports one of `events` before the deadline; -1 never is ready.
bool is_ready(int fd, short events, Time deadline);
// Can be read within that time.
bool is_readable(int fd, Duration within = {});
// Readable when one of them is. -1 and plain files, for which nobody can wait, are left out.
Result<File> any_of(std::span<const int> fds);

}  // namespace tims::os
