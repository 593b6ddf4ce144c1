// Filters that make arrays of structs compressible, as those of Blosc and HDF5: the bytes of the
// same place in all structs are put side by side (shuffle), and of neighbours only the differences
// are kept (delta). A filter changes no size and is undone exactly, whatever the bytes are.
#pragma once

#include <cstddef>
#include <span>

namespace tims::compression {

// Strides are sizes of structs in bytes; 0 and 1 leave the order as it is.
inline constexpr std::size_t kStrideMax = 48;

// `to` has the size of `from` and does not overlap it. Bytes after the last whole struct stay last.
void shuffle(std::span<const std::byte> from, std::size_t stride, std::span<std::byte> to);
void unshuffle(std::span<const std::byte> from, std::size_t stride, std::span<std::byte> to);

// Each byte is replaced by its difference to the one before it; and back.
void subtract(std::span<std::byte> bytes);
void add_up(std::span<std::byte> bytes);

// The distance, 1 to kStrideMax, at which most bytes at the beginning are equal: the size of the
// structs, if there are any.
std::size_t find_stride(std::span<const std::byte> bytes);

}  // namespace tims::compression
