// What a demo component was told (its role, its mailbox, whom it talks to), and what its ladar
// sees.
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

// Where the demo components are when nobody says otherwise.
inline constexpr Address kLadar = Address::of({.class_id = class_id::kLadar});
inline constexpr Address kServer = Address::of({.class_id = class_id::kTest});
inline constexpr Address kViewer =
    Address::of({.class_id = class_id::kTest, .instance = 1, .local = 1});
inline constexpr Address kClient =
    Address::of({.class_id = class_id::kTest, .instance = 2, .local = 1});

struct Arguments {
  std::string role;   // "ladar"
  Address at{};       // own mailbox
  Address to{};       // whom a viewer watches and a client asks
  Duration period{};  // between two scans or questions
};

// Instead: help, or what is wrong.
struct Refusal {
  int exit_code;
  std::string text;
};

std::variant<Arguments, Refusal> parse_arguments(std::vector<std::string> words);

// A half circle of 361 points, 0.5 degrees apart, in a round room whose wall breathes with
// `number`.
rack::LadarData scan_of_a_room(std::uint32_t number, rack::TimeStamp time);

}  // namespace tims::demo
