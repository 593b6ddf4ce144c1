// Catalogue of all messages of all classes: their names and the schemas of their bodies. For tools
// that process messages without being compiled for them, and for errors that name commands.
//
// A new class needs a table like those of RACK, next to its structs:
//
//   inline constexpr rack::MessageInfo kThermometerMessages[] = {
//       {kThermometer, tims::type::kData, "DATA", rack::kBody<ThermometerData>},
//       {kThermometer, ThermometerType::kSetLimit, "SET_LIMIT", rack::kBody<ThermometerLimit>}};
//   inline constexpr rack::ClassInfo kThermometerClass = {kThermometer, "Thermometer",
//                                                         kThermometerMessages};
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rack/codec/schema.h"
#include "tims/message.h"
#include "tims/result.h"

#pragma GCC visibility push(default)  // exported by librack.so
namespace rack {

struct MessageInfo {
  u32 class_id = 0;  // kEveryClass: a message of the framework
  i8 type = 0;
  std::string_view name{};       // "MOVE"
  const Schema* body = nullptr;  // null: the message has no body
};
inline constexpr u32 kEveryClass = 0xFFFFFFFF;

template <Struct T>
inline constexpr const Schema* kBody = &kSchema<T>;

// A class that RACK does not define; its number must be 128 or more.
struct ClassInfo {
  u32 class_id = 0;
  std::string_view name{};  // "Thermometer"
  std::span<const MessageInfo> messages{};
};
// Adds the messages of a class to the catalogue. Call it before the program starts threads; the
// data that `own` refers to must remain valid. kAddressInUse: the number or the name belongs to
// another class.
Result<void> add_class(const ClassInfo& own);
std::span<const ClassInfo> added_classes();
// As its author may have written it, decimal or hexadecimal: "128 (0x80)".
std::string class_number(u32 class_id);
// The same as a file for other programs (JSON; described in proxies/README.md), to be installed in
// share/rack/messages. kInvalidArgument: a struct that the file format cannot express (a Tail).
Result<std::string> message_file(const ClassInfo& own);

// All known messages: first those of the framework, then class by class.
std::vector<std::span<const MessageInfo>> message_tables();

// A message of a class, or of the framework; null when unknown.
const MessageInfo* find_message(u32 class_id, i8 type);
// By its name, case-insensitive: "MOVE".
const MessageInfo* find_message(u32 class_id, std::string_view name);
// Commands are identified by the class of the receiver, all other messages by that of the sender.
// Null also for messages to a router (dest = src = 0).
const MessageInfo* find_message(const tims::Header& header, const tims::AddressWidths& widths = {});

}  // namespace rack

#pragma GCC visibility pop
