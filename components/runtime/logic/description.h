// A component describes itself as JSON: its parameters, the components that it uses, and its data.
// `PROGRAM --describe` prints it, and GET_DESCRIPTION returns it. The format is in README.md. Pure.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "rack/parameters.h"

namespace rack {

// A component that it uses: which one, two parameters state.
struct UsedComponent {
  std::uint32_t class_id = 0;
  std::string_view system{};  // the names of these parameters
  std::string_view instance{};
};

struct Described {
  std::string_view purpose{};
  std::uint32_t class_id = 0;
  std::span<const UsedComponent> inputs{};
  bool has_data = false;  // its class's DATA
};

std::string description(const Parameters& parameters, const Described& component);

}  // namespace rack
