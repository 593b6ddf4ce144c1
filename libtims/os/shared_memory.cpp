#include "os/shared_memory.h"

#include <utility>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include "os/wakeup.h"

namespace tims::os {

Mapping::Mapping(Mapping&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}

Mapping& Mapping::operator=(Mapping&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(size_, other.size_);
  return *this;
}

Mapping::~Mapping() {
  if (data_ != nullptr) ::munmap(data_, size_);
}

Result<Mapping> Mapping::of(const File& memfd) {
  const int seals = ::fcntl(memfd.get(), F_GET_SEALS);
  if (seals < 0 || (seals & F_SEAL_SHRINK) == 0)
    return Error(Errc::kBadLayout, "shared memory that is not sealed against shrinking");
  struct stat status {};
  if (::fstat(memfd.get(), &status) != 0) return system_error("fstat");
  if (status.st_size <= 0) return Error(Errc::kBadLayout, "empty shared memory");
  if (!std::in_range<std::size_t>(status.st_size))
    return Error(Errc::kBadLayout, "more shared memory than this program can map");
  const auto size = static_cast<std::size_t>(status.st_size);
  void* data = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, memfd.get(), 0);
  if (data == MAP_FAILED) return system_error("mmap");
  return Mapping(static_cast<std::byte*>(data), size);
}

std::byte* Mapping::reserve(std::size_t size) {
  void* data = ::mmap(nullptr, size, PROT_READ | PROT_WRITE,
                      MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  return data == MAP_FAILED ? nullptr : static_cast<std::byte*>(data);
}

void Mapping::move_over(std::byte* fresh) {
  if (::mremap(fresh, size_, size_, MREMAP_MAYMOVE | MREMAP_FIXED, data_) == MAP_FAILED)
    ::munmap(fresh, size_);
}

void Mapping::discard(std::size_t offset, std::size_t size) const {
  ::madvise(data_ + offset, size, MADV_REMOVE);
}

Result<File> make_memfd(const std::string& name, std::uint64_t size) {
  File file(::memfd_create(name.c_str(), MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!file) return system_error("memfd_create");
  if (::ftruncate(file.get(), static_cast<off_t>(size)) != 0) return system_error("ftruncate");
  // Seal only after the size is set: sealed earlier, the file would remain empty.
  if (::fcntl(file.get(), F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0)
    return system_error("sealing shared memory");
  return file;
}

void wake_sleeper(const shm::Sender& sender, std::uint32_t sleep, Waker waker) {
  shm::Word32& word = sender.view().header().sleep;
  if (waker.fd < 0) return futex_clear_and_wake(*word.raw());
  waker.is_doorbell ? signal_event_fd(waker.fd) : wake(waker.fd);
  word.compare_exchange(sleep, sleep & ~1U, std::memory_order_acq_rel);
}

}  // namespace tims::os
