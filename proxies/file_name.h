// A file name for a component, which opens it on its own host (specification, section 9.13).
#pragma once

#include <string_view>

#include "proxies/codec/sequence.h"

namespace rack {

// C programs send and expect 132 bytes, with NUL behind the name; Java sends the used bytes only.
struct FileName {
  Count length = {};
  Sequence<char, 127> name = {};

  static constexpr std::size_t kWholeSize = 4 + 128;
  static constexpr bool kPads = true;

  static FileName of(std::string_view text) {
    FileName file;
    file.name.assign(text.begin(), text.end());
    return file;
  }
  [[nodiscard]] std::string_view view() const { return {name.data(), name.size()}; }
};

}  // namespace rack
