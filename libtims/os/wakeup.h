// Waiting for an event and waking the waiter: by a futex in shared memory, by a kernel counter
// (eventfd), by a socket between programs that do not trust each other, or on any descriptor.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>

#include <poll.h>

#include "os/clock.h"
#include "os/file.h"
#include "tims/time.h"

namespace tims::os {

// --- A 32-bit word in shared memory (futex)

// Waits until the word is no longer `expected`, a wake-up, or the deadline. May return early.
void futex_wait(const std::atomic<std::uint32_t>& word, std::uint32_t expected, Time deadline);

// Clears bit 0 of the word and wakes one sleeper, in one system call: a process that is killed here
// has done both or nothing.
void futex_clear_and_wake(const std::atomic<std::uint32_t>& word);

// --- A counter (eventfd), which an event loop can wait for. For threads of one program, and for
// programs that trust its creator.

Result<File> make_event_fd();
void signal_event_fd(int fd);
// Never waits, because any program that shares the descriptor can change its flags.
void drain_event_fd(int fd);

// --- A wake-up between programs that do not trust each other: a pair of datagram sockets. The
// owner keeps one end for its event loop and gives the other end to the senders; a datagram wakes
// the owner.
//
// An eventfd is not suitable: all programs that have it share its flags. Its owner could fill it
// and clear O_NONBLOCK, and a sender that wants to wake the owner would block.

struct WakePair {
  File woken;  // readable until drain_wakes()
  File waker;
};
Result<WakePair> make_wake_pair();
// Checks whether a descriptor received from another program is a waker. Sockets of other families
// can be locked by another program for any time, and a send would wait for the lock in spite of
// MSG_DONTWAIT.
bool is_waker(int fd);
// Never waits, whatever state the sockets are in. When the queue is full, the owner is woken
// already. The datagram is empty, so that it has no meaning for any other receiver.
void wake(int waker);
void drain_wakes(int woken);

// --- Any descriptor

// Calls poll(2) until one of them reports a requested event; false at the deadline.
bool poll_until(std::span<pollfd> waits, Time deadline);
// Whether poll() reports one of `events` before the deadline; a descriptor of -1 is never ready.
bool is_ready(int fd, short events, Time deadline);
// Whether it becomes readable within the given time.
bool is_readable(int fd, Duration within = {});
// A descriptor that is readable when one of `fds` is. -1 and regular files, which cannot be polled,
// are ignored.
Result<File> any_of(std::span<const int> fds);

}  // namespace tims::os
