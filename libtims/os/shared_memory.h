// Shared memory: a sealed memfd and its mapping, and waking the owner of a mailbox in it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

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

  // Maps the whole file, readable and writable. Refuses a file that could shrink under the mapping
  // (kBadLayout).
  static Result<Mapping> of(const File& memfd);

  [[nodiscard]] std::span<std::byte> bytes() const { return {data_, size_}; }

  // Replaces the shared pages atomically by private memory that `prepare` has filled, at the same
  // addresses. Threads that are still writing there do no harm, and the shared pages are freed.
  template <typename Prepare>
  void replace(Prepare prepare) {
    std::byte* fresh = reserve(size_);
    if (fresh == nullptr) return;  // the old pages remain: costs memory, not safety
    prepare(std::span(fresh, size_));
    move_over(fresh);
  }

  // Releases the pages from `offset` on to the system; they read as zeros afterwards.
  void discard(std::size_t offset, std::size_t size) const;

 private:
  Mapping(std::byte* data, std::size_t size) : data_(data), size_(size) {}
  static std::byte* reserve(std::size_t size);
  void move_over(std::byte* fresh);

  std::byte* data_ = nullptr;
  std::size_t size_ = 0;
};

// Creates a zeroed memfd of `size` bytes whose size can no longer change.
Result<File> make_memfd(const std::string& name, std::uint64_t size);

// A memfd with these bytes, which can no longer change.
Result<File> make_memfd(const std::string& name, std::span<const std::byte> bytes);
// The content of a memfd. kTooBig: it has more than `bytes_max`.
Result<std::vector<std::byte>> read_memfd(const File& memfd, std::size_t bytes_max);

// How the owner of a mailbox is woken; descriptor -1: by its futex.
struct Waker {
  int fd = -1;
  bool is_doorbell = false;  // an eventfd created by the router; else a socket (os/wakeup.h)
};

// Wakes the owner of a mailbox if it sleeps; call it after each message that was put into the
// mailbox.
//
// Every kind of waker first wakes and then clears the sleep flag, or does both atomically. If a
// sender crashes in between, the owner is awake or the flag is still set for the next sender. The
// router decides which kind of waker is used, not the shared memory, which the owner can change: a
// waker from a client is checked, and a doorbell is created by the router.
void wake_sleeper(const shm::Sender& sender, std::uint32_t sleep, Waker waker);
inline void wake_owner(const shm::Sender& sender, Waker waker) {
  if (const std::uint32_t sleep = sender.sleeper()) wake_sleeper(sender, sleep, waker);
}

}  // namespace tims::os
