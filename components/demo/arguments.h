// What a demo component was told: its role, its mailbox, whom it talks to. Pure.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <variant>

#include "tims/address.h"
#include "tims/time.h"

namespace tims::demo {

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
