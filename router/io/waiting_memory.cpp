#include "router/io/waiting_memory.h"

#include <sys/mman.h>

namespace tims::io {
namespace {

// Up to this amount is kept, because it will be needed again.
constexpr std::size_t kWaitingMemoryKeptBytes = 8 << 20;

std::span<std::byte> reserve(std::size_t bytes) {
  for (; bytes >= core::BlockPool::kBlockSize; bytes /= 2) {
    void* memory = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE,
                          MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (memory != MAP_FAILED) return {static_cast<std::byte*>(memory), bytes};
  }
  return {};
}

}  // namespace

void HalfMessages::set(Time now, std::uint32_t token, std::uint64_t bytes) {
  if (bytes <= kStepBytes && holders_.empty()) return;
  auto at = std::ranges::find(holders_, token, &Holder::token);
  if (bytes <= kStepBytes) {
    if (at == holders_.end()) return;
    bytes_ -= at->bytes;
    holders_.erase(at);
    return;
  }
  if (at == holders_.end()) at = holders_.insert(at, {.token = token, .since = now});
  bytes_ += bytes - at->bytes;
  at->bytes = bytes;
  // Less than before: another message. A client that sends byte by byte does not gain time.
  if (bytes < at->noted || bytes >= at->noted + kStepBytes) {
    at->noted = bytes;
    at->since = now;
  }
}

std::optional<HalfMessages::Victim> HalfMessages::victim() const {
  if (bytes_ <= bytes_max_) return std::nullopt;
  const Holder* victim = nullptr;
  for (const Holder& holder : holders_) {
    if (holder.bytes * holders_.size() < bytes_) continue;
    if (victim == nullptr || holder.since < victim->since) victim = &holder;
  }
  return Victim{victim->token, victim->bytes};
}

WaitingMemory::WaitingMemory(std::size_t bytes) : memory_(reserve(bytes)), pool_(memory_) {}

WaitingMemory::~WaitingMemory() {
  if (!memory_.empty()) ::munmap(memory_.data(), memory_.size());
}

void WaitingMemory::give_back() {
  if (pool_.used() != 0 || pool_.touched_bytes() <= kWaitingMemoryKeptBytes) return;
  pool_.forget();
  discard(memory_);
}

void WaitingMemory::discard(std::span<std::byte> bytes) {
  // Locked memory (router.priority) needs the second call; kernels before 5.18 keep it.
  if (::madvise(bytes.data(), bytes.size(), MADV_DONTNEED) != 0)
    ::madvise(bytes.data(), bytes.size(), MADV_DONTNEED_LOCKED);
}

}  // namespace tims::io
