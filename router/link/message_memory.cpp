#include "router/link/message_memory.h"

namespace tims::link {

MessageMemory::MessageMemory(std::span<std::byte> address_space, std::uint32_t message_max,
                             std::size_t bytes_max)
    : memory_(address_space.data()),
      place_bytes_(place_bytes(message_max)),
      bytes_max_(std::max(bytes_max, place_bytes_)),
      touched_(std::min(address_space.size() / place_bytes_, kPlacesMax)) {
  for (std::size_t place = touched_.size(); place > 0; --place)
    free_.push_back(static_cast<std::uint32_t>(place - 1));
}

std::uint32_t MessageMemory::take_place() {
  if (free_.empty()) return kNone;
  const std::uint32_t place = free_.back();
  free_.pop_back();
  return place;
}

bool MessageMemory::grow(std::uint32_t place, std::size_t size, std::size_t larger) {
  if (place == has_kept_) return grow_as_kept(place, size, larger);
  if (larger - size > free_bytes() || larger > place_bytes_) return false;
  used_ += larger - size;
  touch(place, larger);
  return true;
}

bool MessageMemory::grow_as_kept(std::uint32_t place, std::size_t size, std::size_t larger) {
  if ((has_kept_ != kNone && has_kept_ != place) || larger > place_bytes_) return false;
  // What it has so far is free for others.
  if (has_kept_ == kNone) used_ -= size;
  has_kept_ = place;
  kept_used_ = larger;
  touch(place, larger);
  return true;
}

void MessageMemory::touch(std::uint32_t place, std::size_t size) {
  if (size <= touched_[place]) return;
  touched_bytes_ += size - touched_[place];
  touched_[place] = size;
}

void MessageMemory::release(std::uint32_t place, std::size_t size) {
  if (place == has_kept_) {
    has_kept_ = kNone;
    kept_used_ = 0;
  } else {
    used_ -= size;
  }
  free_.push_back(place);
}

std::span<std::byte> MessageMemory::surplus() {
  const bool idle = free_.size() == touched_.size();
  if (touched_bytes_ <= (idle ? std::min(kTouchedIfIdle, bytes_max_) : bytes_max_)) return {};
  const auto place =
      std::ranges::find_if(free_, [&](std::uint32_t free) { return touched_[free] > 0; });
  if (place == free_.end()) return {};
  const std::size_t size = std::exchange(touched_[*place], 0);
  touched_bytes_ -= size;
  return {at(*place), size};
}

}  // namespace tims::link
