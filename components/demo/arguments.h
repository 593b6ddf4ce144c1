// What a demo component was told: its role, its mailbox, whom it talks to; and where they are when
// nobody says otherwise. Pure.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <variant>

#include "tims/address.h"
#include "tims/time.h"

namespace tims::demo {

// --- Where the demo components are when nobody says otherwise.

inline constexpr Address kLadar = Address::of({.class_id = class_id::kLadar});
inline constexpr Address kServer = Address::of({.class_id = class_id::kTest});
inline constexpr Address kViewer =
    Address::of({.class_id = class_id::kTest, .instance = 1, .local = 1});
inline constexpr Address kClient =
    Address::of({.class_id = class_id::kTest, .instance = 2, .local = 1});

// --- What a demo component was told: its role, its mailbox, whom it talks to. Pure.

struct Arguments {
  std::string role;           // "ladar"
  std::optional<Address> at;  // own mailbox; default: the role's
  Address to{};               // whom a viewer watches and a client asks
  Duration period{};          // between two scans or questions
};

// Or what is wrong, in words.
std::variant<Arguments, std::string> parse_arguments(std::span<const std::string> words);

std::string usage();

}  // namespace tims::demo
