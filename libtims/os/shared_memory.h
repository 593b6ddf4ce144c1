// Shared memory: a sealed memfd and its mapping; and waking the owner of a mailbox that lies in it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "os/file.h"
#include "shm/sender.h"
#include "tims/result.h"

namespace tims::os {

class Mapping {
 public:
  Mapping() = default;
  Mapping(Mapping&& other) noexcept;
  Mapping& operator=(Mapping&& other) noexcept;
  ~Mapping();

  // Whole, readable and writable. Refuses a file that could shrink under the mapping (kBadLayout).
  static Result<Mapping> of(const File& memfd);

  [[nodiscard]] std::span<std::byte> bytes() const { return {data_, size_}; }

  // Puts private memory that `prepare` has filled in the place of the shared pages, at once and at
  // the same addresses: threads that are still writing there do no harm, and the pages are free.
  template <typename Prepare>
  void replace(Prepare prepare) {
    std::byte* fresh = reserve(size_);
    if (fresh == nullptr) return;  // the old pages stay: memory, not safety
    prepare(std::span(fresh, size_));
    move_over(fresh);
  }

  // Gives the pages from `offset` on back to the system; they read as zeros afterwards.
  void discard(std::size_t offset, std::size_t size) const;

 private:
  Mapping(std::byte* data, std::size_t size) : data_(data), size_(size) {}
  static std::byte* reserve(std::size_t size);
  void move_over(std::byte* fresh);

  std::byte* data_ = nullptr;
  std::size_t size_ = 0;
};

// A new memfd of `size` bytes, zeroed, that can no longer change its size.
Result<File> make_memfd(const std::string& name, std::size_t size);

// How the owner of a mailbox is woken: -1, by its futex.
struct Waker {
  int fd = -1;
  bool is_doorbell = false;  // an eventfd of the router's, else a socket (os/wakeup.h)
};

// Wakes the owner of a mailbox if it sleeps; after each message that was put into it.
//
// Every kind wakes first and clears the sign after it, or both at once: a sender that dies in
// between leaves the owner woken, or the sign standing for the next sender. Which kind it is says
// the router, not the memory, which the owner can change: a waker is checked, a doorbell is the
// router's own.
void wake_sleeper(const shm::Sender& sender, std::uint32_t sleep, Waker waker);
inline void wake_owner(const shm::Sender& sender, Waker waker) {
  if (const std::uint32_t sleep = sender.sleeper()) wake_sleeper(sender, sleep, waker);
}

}  // namespace tims::os
