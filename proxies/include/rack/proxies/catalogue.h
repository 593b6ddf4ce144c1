// What any message of any class means: names, and bodies for people and programs. For tools that
// look at messages of which they know nothing but the bytes.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rack/codec/parse.h"
#include "rack/codec/print.h"
#include "rack/codec/quantity.h"
#include "tims/message.h"
#include "tims/result.h"

namespace rack {

// The struct in a message's body. Functions fail with kMalformed.
struct BodyInfo {
  using Bytes = std::span<const std::byte>;

  std::string_view name;     // "ChassisMoveData"
  std::size_t body_max = 0;  // bytes
  // As to_json() and to_text() have it.
  tims::Result<std::string> (*json)(Bytes body, std::endian order, const PrintStyle& style);
  tims::Result<std::string> (*text)(Bytes body, std::endian order, const PrintStyle& style);
  // Read and written again, in `to`.
  tims::Result<std::vector<std::byte>> (*recode)(Bytes body, std::endian from, std::endian to);
  // Made of fields by name, the others as the struct has them; kInvalidArgument.
  tims::Result<std::vector<std::byte>> (*make)(std::span<const Assignment> fields,
                                               std::endian order, const PrintStyle& style);
  std::vector<Column> (*columns)();
};

struct MessageInfo {
  u32 class_id = 0;  // kEveryClass: of the framework
  i8 type = 0;
  std::string_view name;           // "MOVE"
  const BodyInfo* body = nullptr;  // null: the message has none
};
inline constexpr u32 kEveryClass = 0xFFFFFFFF;

// All that are known: first those of the framework, then class by class.
std::array<std::span<const MessageInfo>, 4> message_tables();

// Of a class, or of the framework; null when unknown.
const MessageInfo* find_message(u32 class_id, i8 type);
// By its name, without regard to case: "MOVE".
const MessageInfo* find_message(u32 class_id, std::string_view name);
// Commands are told by the class of the receiver, all others by that of the sender. Null also for
// what a router is told (dest = src = 0).
const MessageInfo* find_message(const tims::Header& header, const tims::AddressWidths& widths = {});

}  // namespace rack
