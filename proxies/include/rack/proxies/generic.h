// The bodies that every component understands (specification, section 1.4), and its states. Their
// message types are tims::type.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "rack/codec/fields.h"
#include "rack/codec/quantity.h"
#include "tims/address.h"
#include "tims/message.h"

#pragma GCC visibility push(default)  // what librack.so shows
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

// --- of our own runtime, which programs of the original do not know

// Who refuses a command with tims::flag::kTellWhy says why, in at most so many bytes of words
// behind its ERROR. Others get none: programs of the original have no room for them.
inline constexpr std::size_t kReasonMax = 240;
// In an ON, where the original has no body: the same for a program at a TCP port, which has no
// flags.
struct OnRequest {
  i32 reasonMax = kReasonMax;
};
// Of the body of an ERROR; empty: it says nothing.
std::string_view reason_of(std::span<const std::byte> body);

// When a new value of a parameter takes effect.
enum class TakesEffect : u8 {
  kNow,
  kAtOn,     // the next one
  kAtStart,  // of its program
};
std::string_view name(TakesEffect when);

struct ParameterEffect {
  Text<80> name = {};
  i32 takesEffect = 0;  // TakesEffect
};

// Of all parameters, in the order of ParameterList.
struct ParameterEffects {
  Count count = {};
  Sequence<ParameterEffect, 128> effects = {};
};

// What a component can see of its own real-time behaviour.
enum class WatchDepth : u8 {
  kOff,
  kCounts,       // how often
  kFaultPlaces,  // also where page faults are
  kAllPlaces,    // also where it gives its CPU away
};
std::string_view name(WatchDepth depth);

// Where the loop of a component was not in real time.
struct RuntimePlace {
  i32 kind = 0;
  i64 count = 0;         // as far as places were looked up
  Text<200> where = {};  // functions, the innermost first

  static constexpr i32 kBlocked = 0;
  static constexpr i32 kPageFault = 1;
  static constexpr std::size_t kWhereMax = 199;
};

struct RuntimeData {
  TimeStamp since = 0;  // when its state became what it is
  i32 watch = 0;        // WatchDepth
  i64 loops = 0;        // that were watched
  i64 blocked = 0;      // gave its CPU away in the middle of a loop
  i64 preempted = 0;    // lost it to somebody more important
  i64 pageFaults = 0;
  i64 lost = 0;  // came faster than they were counted
  Count placeNum = {};
  Sequence<RuntimePlace, 16> places = {};  // the worst first
};

// Who gets the data of a component.
struct ListenerInfo {
  tims::Address mailbox = {};
  Milliseconds<u32> periodTime = 0;  // as granted
  i32 priority = 0;
};

struct ListenersData {
  Milliseconds<u32> periodTime = 0;  // of the data
  i64 dataSets = 0;                  // since it was started
  Count listenerNum = {};
  Sequence<ListenerInfo, 256> listeners = {};
};

// ---

// What GET_STATUS is answered with: the type of the reply.
enum class Status : i8 {
  kEnabled = tims::type::kEnabled,
  kDisabled = tims::type::kDisabled,
  kError = tims::type::kError,
};
std::string_view name(Status status);

// --- A file name for a component, which opens it on its own host (specification, section 9.13).

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

#pragma GCC visibility pop
