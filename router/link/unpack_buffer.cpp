#include "router/link/unpack_buffer.h"

#include <utility>

namespace tims::link {
namespace {

constexpr std::size_t kAligned = 16;

}  // namespace

bool UnpackBuffer::reserve(std::size_t size) {
  if (open_ && used_ + size <= memory_.place_size()) return open_.grow(used_ + size);
  MessageBuffer next(memory_);
  if (!next || !next.grow(size)) return false;
  if (open_) done_.push_back(std::move(open_));
  open_ = std::move(next);
  used_ = 0;
  return true;
}

std::span<std::byte> UnpackBuffer::take(std::size_t size) {
  if (!reserve(size)) return {};
  const auto taken = open_.bytes().subspan(used_, size);
  used_ += (size + kAligned - 1) / kAligned * kAligned;
  return taken;
}

}  // namespace tims::link
