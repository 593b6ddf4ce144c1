#include "os/shared_memory.h"

#include <cerrno>
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

Result<File> make_memfd(const std::string& name, std::span<const std::byte> bytes) {
  File file(::memfd_create(name.c_str(), MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!file) return system_error("memfd_create");
  while (!bytes.empty()) {
    const ssize_t written = ::write(file.get(), bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return system_error("writing to memory");
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  constexpr int kAll = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE | F_SEAL_SEAL;
  if (::fcntl(file.get(), F_ADD_SEALS, kAll) != 0) return system_error("sealing memory");
  return file;
}

Result<std::vector<std::byte>> read_memfd(const File& memfd, std::size_t bytes_max) {
  struct stat status {};
  if (::fstat(memfd.get(), &status) != 0) return system_error("fstat");
  if (static_cast<std::uint64_t>(status.st_size) > bytes_max)
    return Error(Errc::kTooBig, std::to_string(status.st_size) + " bytes of memory");
  std::vector<std::byte> bytes(static_cast<std::size_t>(status.st_size));
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t got =
        ::pread(memfd.get(), bytes.data() + at, bytes.size() - at, static_cast<off_t>(at));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return system_error("reading memory");
    at += static_cast<std::size_t>(got);
  }
  return bytes;
}

void wake_sleeper(const shm::Sender& sender, std::uint32_t sleep, Waker waker) {
  shm::Word32& word = sender.view().header().sleep;
  if (waker.fd < 0) return futex_clear_and_wake(*word.raw());
  waker.is_doorbell ? signal_event_fd(waker.fd) : wake(waker.fd);
  word.compare_exchange(sleep, sleep & ~1U, std::memory_order_acq_rel);
}

}  // namespace tims::os
