// The arguments of a demo component (role, mailbox, peer), and the scan of its simulated ladar.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "rack/proxies/ladar.h"
#include "tims/address.h"
#include "tims/time.h"

namespace tims::demo {

// Default addresses of the demo components.
inline constexpr Address kLadar = Address::of({.class_id = class_id::kLadar});
inline constexpr Address kServer = Address::of({.class_id = class_id::kTest});
inline constexpr Address kViewer =
    Address::of({.class_id = class_id::kTest, .instance = 1, .local = 1});
inline constexpr Address kClient =
    Address::of({.class_id = class_id::kTest, .instance = 2, .local = 1});

struct Arguments {
  std::string role;   // "ladar"
  Address at{};       // own mailbox
  Address to{};       // the ladar of a viewer, or the server of a client
  Duration period{};  // between two scans or requests
};

// The result instead of arguments: the help text, or an error.
struct Refusal {
  int exit_code;
  std::string text;
};

std::variant<Arguments, Refusal> parse_arguments(std::vector<std::string> arguments);

// A semicircle of 361 points, 0.5 degrees apart, in a round room whose radius varies with `number`.
rack::LadarData scan_of_a_room(std::uint32_t number, rack::TimeStamp time);

}  // namespace tims::demo
