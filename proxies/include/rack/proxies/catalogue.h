// What any message of any class means: names, and bodies for people and programs. For tools that
// look at messages of which they know nothing but the bytes, and for errors that name commands.
//
// A class of one's own is a table like ours, beside its structs:
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

#pragma GCC visibility push(default)  // what librack.so shows
namespace rack {

struct MessageInfo {
  u32 class_id = 0;  // kEveryClass: of the framework
  i8 type = 0;
  std::string_view name{};       // "MOVE"
  const Schema* body = nullptr;  // null: the message has none
};
inline constexpr u32 kEveryClass = 0xFFFFFFFF;

template <Struct T>
inline constexpr const Schema* kBody = &kSchema<T>;

// A class that is none of RACK's; its number is 128 or more.
struct ClassInfo {
  u32 class_id = 0;
  std::string_view name{};  // "Thermometer"
  std::span<const MessageInfo> messages{};
};
// From now on its messages are found like all others. What it refers to must stay; before the
// program has threads. kAddressInUse: the number, or the name, is another class's.
Result<void> add_class(const ClassInfo& own);
std::span<const ClassInfo> added_classes();
// The same as a file for other programs (JSON; described in proxies/README.md), to be installed in
// share/rack/messages. kInvalidArgument: a struct that cannot be said in a file (a Tail).
Result<std::string> message_file(const ClassInfo& own);

// All that are known: first those of the framework, then class by class.
std::vector<std::span<const MessageInfo>> message_tables();

// Of a class, or of the framework; null when unknown.
const MessageInfo* find_message(u32 class_id, i8 type);
// By its name, without regard to case: "MOVE".
const MessageInfo* find_message(u32 class_id, std::string_view name);
// Commands are told by the class of the receiver, all others by that of the sender. Null also for
// what a router is told (dest = src = 0).
const MessageInfo* find_message(const tims::Header& header, const tims::AddressWidths& widths = {});

}  // namespace rack

#pragma GCC visibility pop
