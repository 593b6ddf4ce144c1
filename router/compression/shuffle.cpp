#include "router/compression/shuffle.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace tims::compression {
namespace {

constexpr std::size_t kSearched = 1024;  // bytes

// With a constant stride the compiler moves several bytes at once.
template <std::size_t stride>
void shuffle_by(const std::byte* from, std::size_t rows, std::byte* to) {
  for (std::size_t row = 0; row < rows; ++row)
    for (std::size_t place = 0; place < stride; ++place)
      to[place * rows + row] = from[row * stride + place];
}

template <std::size_t stride>
void unshuffle_by(const std::byte* from, std::size_t rows, std::byte* to) {
  for (std::size_t row = 0; row < rows; ++row)
    for (std::size_t place = 0; place < stride; ++place)
      to[row * stride + place] = from[place * rows + row];
}

void shuffle_any(const std::byte* from, std::size_t rows, std::size_t stride, std::byte* to) {
  for (std::size_t place = 0; place < stride; ++place)
    for (std::size_t row = 0; row < rows; ++row) *to++ = from[row * stride + place];
}

void unshuffle_any(const std::byte* from, std::size_t rows, std::size_t stride, std::byte* to) {
  for (std::size_t place = 0; place < stride; ++place)
    for (std::size_t row = 0; row < rows; ++row) to[row * stride + place] = *from++;
}

}  // namespace

void shuffle(std::span<const std::byte> from, std::size_t stride, std::span<std::byte> to) {
  const std::size_t step = std::max<std::size_t>(stride, 1);
  const std::size_t rows = from.size() / step;
  switch (step) {
    case 1:
      break;  // all of it is the rest
    case 16:
      shuffle_by<16>(from.data(), rows, to.data());
      break;
    case 20:
      shuffle_by<20>(from.data(), rows, to.data());
      break;
    default:
      shuffle_any(from.data(), rows, step, to.data());
  }
  const std::size_t whole = step == 1 ? 0 : rows * step;
  std::ranges::copy(from.subspan(whole), to.begin() + static_cast<std::ptrdiff_t>(whole));
}

void unshuffle(std::span<const std::byte> from, std::size_t stride, std::span<std::byte> to) {
  const std::size_t step = std::max<std::size_t>(stride, 1);
  const std::size_t rows = from.size() / step;
  switch (step) {
    case 1:
      break;
    case 16:
      unshuffle_by<16>(from.data(), rows, to.data());
      break;
    case 20:
      unshuffle_by<20>(from.data(), rows, to.data());
      break;
    default:
      unshuffle_any(from.data(), rows, step, to.data());
  }
  const std::size_t whole = step == 1 ? 0 : rows * step;
  std::ranges::copy(from.subspan(whole), to.begin() + static_cast<std::ptrdiff_t>(whole));
}

void subtract(std::span<std::byte> bytes) {
  for (std::size_t i = bytes.size(); i-- > 1;)
    bytes[i] = static_cast<std::byte>(std::to_integer<unsigned>(bytes[i]) -
                                      std::to_integer<unsigned>(bytes[i - 1]));
}

void add_up(std::span<std::byte> bytes) {
  unsigned sum = 0;
  for (std::byte& byte : bytes) {
    sum += std::to_integer<unsigned>(byte);
    byte = static_cast<std::byte>(sum);
  }
}

std::size_t find_stride(std::span<const std::byte> bytes) {
  const auto sample = bytes.first(std::min(bytes.size(), kSearched));
  std::size_t best = 1;
  std::size_t most = 0;
  for (std::size_t stride = 1; stride <= kStrideMax && 2 * stride <= sample.size(); ++stride) {
    std::size_t equal = 0;
    for (std::size_t i = stride; i < sample.size(); ++i)
      equal += sample[i] == sample[i - stride] ? 1 : 0;
    // Per compared byte, in 1/1024. A multiple of the size is hardly better than the size itself.
    const std::size_t share = equal * 1024 / (sample.size() - stride);
    if (share > most + most / 16) {
      best = stride;
      most = share;
    }
  }
  return best;
}

}  // namespace tims::compression
