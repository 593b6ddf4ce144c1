#include "tests/bench/shared_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include "libtims/os/file.h"

namespace tims::bench {
namespace {

Result<SharedFile> map(int fd, int flags, std::size_t bytes) {
  void* memory =
      ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE | flags, fd, 0);
  if (memory == MAP_FAILED) return os::system_error("mmap");
  return SharedFile(static_cast<std::byte*>(memory), Unmap{bytes});
}

}  // namespace

void Unmap::operator()(std::byte* memory) const { ::munmap(memory, bytes); }

Result<SharedFile> map_shared_file(const std::string& path, std::size_t bytes) {
  const os::File file(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
  if (!file) return os::system_error(path);
  if (::ftruncate(file.get(), static_cast<off_t>(bytes)) != 0) return os::system_error(path);
  return map(file.get(), 0, bytes);
}

Result<SharedFile> map_shared(std::size_t bytes) { return map(-1, MAP_ANONYMOUS, bytes); }

}  // namespace tims::bench
