#include "components/devices/core/datagram_assembly.h"

#include <algorithm>

namespace rack::device {

std::optional<std::span<const std::byte>> DatagramAssembly::add(const Fragment& fragment) {
  const std::size_t end = fragment.offset + fragment.bytes.size();
  // Only the last fragment may end between two units.
  if (end > kBytesMax || fragment.offset % kUnit != 0 || (!fragment.is_last && end % kUnit != 0)) {
    ++given_up_;
    return std::nullopt;
  }
  Open& datagram = open(fragment.key);
  if (!put(datagram, fragment)) return std::nullopt;
  complete_ = std::move(datagram.bytes);
  complete_.resize(*datagram.size);
  std::erase_if(open_, [&](const Open& other) { return other.key == fragment.key; });
  return complete_;
}

DatagramAssembly::Open& DatagramAssembly::open(const Key& key) {
  const auto known = std::ranges::find(open_, key, &Open::key);
  if (known != open_.end()) return *known;
  if (open_.size() == kOpenMax) {
    given_up_ += open_.front().fragments;
    open_.pop_front();
  }
  return open_.emplace_back(Open{.key = key});
}

// Returns whether the datagram is complete.
bool DatagramAssembly::put(Open& datagram, const Fragment& fragment) {
  const std::size_t end = fragment.offset + fragment.bytes.size();
  ++datagram.fragments;
  if (fragment.is_last) datagram.size = end;
  if (datagram.bytes.size() < end) datagram.bytes.resize(end);
  const std::size_t units = (datagram.bytes.size() + kUnit - 1) / kUnit;
  if (datagram.has_unit.size() < units) datagram.has_unit.resize(units);
  std::ranges::copy(fragment.bytes,
                    datagram.bytes.begin() + static_cast<std::ptrdiff_t>(fragment.offset));
  for (std::size_t at = fragment.offset; at < end; at += kUnit)
    datagram.has_unit[at / kUnit] = true;
  if (!datagram.size || datagram.bytes.size() > *datagram.size) return false;
  return std::ranges::find(datagram.has_unit, false) == datagram.has_unit.end();
}

std::uint64_t DatagramAssembly::incomplete() const {
  std::uint64_t count = given_up_;
  for (const Open& datagram : open_) count += datagram.fragments;
  return count;
}

}  // namespace rack::device
