#include "router/link/message_memory.h"

#include <algorithm>
#include <bit>

namespace tims::link {

MessageMemory::MessageMemory(std::span<std::byte> memory) : memory_(memory.data()) {
  free_.fill(kNone);
  const std::size_t count = std::bit_floor(memory.size() / kPieceMin);
  if (count == 0) return;
  order_max_ = std::min(static_cast<std::size_t>(std::countr_zero(count)), kOrders - 1);
  pieces_.resize(std::size_t{1} << order_max_);
  push(0, order_max_);
}

void MessageMemory::push(std::uint32_t piece, std::size_t order) {
  pieces_[piece] = {.next = free_[order],
                    .previous = kNone,
                    .order = static_cast<std::uint8_t>(order),
                    .free = true};
  if (free_[order] != kNone) pieces_[free_[order]].previous = piece;
  free_[order] = piece;
}

void MessageMemory::unlink(std::uint32_t piece) {
  Piece& p = pieces_[piece];
  if (p.previous == kNone) {
    free_[p.order] = p.next;
  } else {
    pieces_[p.previous].next = p.next;
  }
  if (p.next != kNone) pieces_[p.next].previous = p.previous;
  p.free = false;
}

std::span<std::byte> MessageMemory::allocate(std::size_t size) {
  if (pieces_.empty()) return {};
  const std::size_t units =
      std::bit_ceil(std::max<std::size_t>(1, (size + kPieceMin - 1) / kPieceMin));
  const std::size_t wanted = static_cast<std::size_t>(std::countr_zero(units));
  std::size_t order = wanted;
  while (order <= order_max_ && free_[order] == kNone) ++order;
  if (order > order_max_) return {};
  const std::uint32_t piece = free_[order];
  unlink(piece);
  while (order > wanted) {
    --order;
    push(piece + (std::uint32_t{1} << order), order);
  }
  pieces_[piece].order = static_cast<std::uint8_t>(wanted);
  used_ += units * kPieceMin;
  return {memory_ + std::size_t{piece} * kPieceMin, units * kPieceMin};
}

void MessageMemory::release(std::span<std::byte> bytes) {
  auto piece = static_cast<std::uint32_t>((bytes.data() - memory_) / std::ptrdiff_t{kPieceMin});
  std::size_t order = pieces_[piece].order;
  used_ -= bytes.size();
  while (order < order_max_) {
    const std::uint32_t buddy = piece ^ (std::uint32_t{1} << order);
    if (!pieces_[buddy].free || pieces_[buddy].order != order) break;
    unlink(buddy);
    piece = std::min(piece, buddy);
    ++order;
  }
  push(piece, order);
}

}  // namespace tims::link
