// The bodies that every component understands (specification, section 1.4), and its states. Their
// message types are tims::type.
#pragma once

#include <string_view>

#include "proxies/codec/quantity.h"
#include "proxies/codec/sequence.h"
#include "proxies/codec/text.h"
#include "proxies/codec/time_stamp.h"
#include "tims/address.h"
#include "tims/message.h"

namespace rack {

// Class-specific message types begin here: commands 20 + n, replies -20 - n.
inline constexpr i8 kFirstCommand = 21;
inline constexpr i8 kFirstReply = -21;

struct GetDataRequest {
  TimeStamp recordingTime = 0;  // 0: the newest
};

struct GetContDataRequest {
  Milliseconds<u32> periodTime = 0;  // 0: as fast as possible
  tims::Address dataMbxAdr = {};     // where the data shall go
};

struct ContDataReply {
  Milliseconds<u32> periodTime = 0;  // as granted
};

struct StopContDataRequest {
  tims::Address dataMbxAdr = {};
};

// Only the value that `type` selects has a meaning; programs of the original send whatever was in
// memory in the others.
struct Parameter {
  Text<80> name = {};
  i32 type = 0;
  i32 valueInt = 0;
  f32 valueFloat = 0;
  Text<80> valueString = {};

  static constexpr i32 kInt = 0;
  static constexpr i32 kString = 1;
  static constexpr i32 kFloat = 2;
};

// Original modules take messages with one parameter; their answers hold 30 to 40.
struct ParameterList {
  Count count = {};
  Sequence<Parameter, 128> parameters = {};
};

// What GET_STATUS is answered with: the type of the reply.
enum class Status : i8 {
  kEnabled = tims::type::kEnabled,
  kDisabled = tims::type::kDisabled,
  kError = tims::type::kError,
};
std::string_view name(Status status);

}  // namespace rack
