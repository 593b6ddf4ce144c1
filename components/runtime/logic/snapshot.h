// Where a thread was at one moment, as the kernel has seen it. Pure.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace rack {

struct Snapshot {
  static constexpr std::size_t kChainMax = 32;
  static constexpr std::size_t kRegistersMax = 40;
  static constexpr std::size_t kStackMax = 2048;  // bytes

  // Return addresses found by frame pointers, innermost first. Who called a function without a
  // frame of its own, as many in libc, is missing among them.
  std::array<std::uint64_t, kChainMax> chain;
  std::uint32_t chain_size = 0;
  // In the order of the kernel's numbers for them.
  std::array<std::uint64_t, kRegistersMax> registers;
  std::uint32_t register_count = 0;
  // From the stack pointer upwards.
  std::array<std::byte, kStackMax> stack;
  std::uint32_t stack_size = 0;

  [[nodiscard]] std::span<const std::uint64_t> frames() const {
    return std::span(chain).first(chain_size);
  }
  void clear() { chain_size = register_count = stack_size = 0; }
};

}  // namespace rack
