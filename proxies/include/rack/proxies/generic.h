// The message bodies that every component supports (specification, section 1.4), and the states of
// a component. The message types are in tims::type.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "rack/codec/fields.h"
#include "rack/codec/quantity.h"
#include "tims/address.h"
#include "tims/message.h"
#include "tims/result.h"

#pragma GCC visibility push(default)  // exported by librack.so
namespace rack {

// Class-specific message types begin here: commands 20 + n, replies -20 - n.
inline constexpr i8 kFirstCommand = 21;
inline constexpr i8 kFirstReply = -21;

struct GetDataRequest {
  TimeStamp recordingTime = 0;  // 0: the newest
};

struct GetContDataRequest {
  Milliseconds<u32> periodTime = 0;  // 0: as fast as possible
  tims::Address dataMbxAdr = {};     // the mailbox that receives the data
};

struct ContDataReply {
  Milliseconds<u32> periodTime = 0;  // as granted
};

struct StopContDataRequest {
  tims::Address dataMbxAdr = {};
};

// Only the value selected by `type` is valid; original programs send arbitrary memory in the
// others.
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

// Original modules accept messages with one parameter; their answers contain 30 to 40.
struct ParameterList {
  Count count = {};
  Sequence<Parameter, 128> parameters = {};
};

// --- extensions of this runtime, which original programs do not support

// A component that refuses a command with tims::flag::kReportReason appends the reason to its
// ERROR, in at most this number of bytes. Without the flag no reason is sent, because original
// programs do not expect a body there.
inline constexpr std::size_t kReasonMax = 240;
// Body of an ON, which has no body in the original protocol: requests the reason for a program at a
// TCP port, which cannot set flags.
struct OnRequest {
  i32 reasonMax = kReasonMax;
};
// The reason in the body of an ERROR; empty: none was sent.
std::string_view reason_of(std::span<const std::byte> body);
// The reason of a component that is wanted on and has not produced data yet.
inline constexpr std::string_view kNoDataYet = "there are no data yet";

// When a new value of a parameter takes effect.
enum class TakesEffect : u8 {
  kNow,
  kAtOn,     // at the next ON
  kAtStart,  // when the program is started
};
std::string_view name(TakesEffect when);

struct ParameterEffect {
  Text<80> name = {};
  i32 takesEffect = 0;  // TakesEffect
};

// For all parameters, in the order of ParameterList.
struct ParameterEffects {
  Count count = {};
  Sequence<ParameterEffect, 128> effects = {};
};

// How much a component records about its own real-time behaviour.
enum class WatchDepth : u8 {
  kOff,
  kCounts,       // number of events
  kFaultPlaces,  // also the places of page faults
  kAllPlaces,    // also the places where it yields the CPU
};
std::string_view name(WatchDepth depth);

// A place where the loop of a component violated real-time behaviour.
struct RuntimePlace {
  i32 kind = 0;
  i64 count = 0;         // only events whose place was looked up
  Text<200> where = {};  // functions, the innermost first

  static constexpr i32 kBlocked = 0;
  static constexpr i32 kPageFault = 1;
  static constexpr std::size_t kWhereMax = 199;
};

struct RuntimeData {
  TimeStamp since = 0;  // when the present state began
  i32 watch = 0;        // WatchDepth
  i64 loops = 0;        // number of watched loops
  i64 blocked = 0;      // the thread gave up the CPU within a loop
  i64 preempted = 0;    // the CPU was taken by a thread of higher priority
  i64 pageFaults = 0;
  i64 lost = 0;  // events that arrived faster than they could be counted
  Count placeNum = {};
  Sequence<RuntimePlace, 16> places = {};  // the most frequent first
};

// A receiver of the data of a component.
struct ListenerInfo {
  tims::Address mailbox = {};
  Milliseconds<u32> periodTime = 0;  // as granted
  i32 priority = 0;
};

struct ListenersData {
  Milliseconds<u32> periodTime = 0;  // of the data
  i64 dataSets = 0;                  // since the component was started
  Count listenerNum = {};
  Sequence<ListenerInfo, 256> listeners = {};
};

// What a component states about itself: parameters, inputs and outputs as JSON (README.md of
// components/runtime/logic). It is longer than a mailbox of its requester may be, so it is
// requested page by page.
inline constexpr std::size_t kDescriptionMax = std::size_t{1} << 20;

struct DescriptionRequest {
  i32 offset = 0;    // first byte of the page
  i32 bytesMax = 0;  // of the page; 0: as many as fit into one
};

struct DescriptionPage {
  i32 size = 0;  // bytes of the whole description
  i32 offset = 0;
  Count textNum = {};
  Sequence<char, 4000> text = {};
};

// kInvalidArgument: the requested page is outside of the description.
tims::Result<DescriptionPage> page_of(std::string_view description,
                                      const DescriptionRequest& request);
// Appends the next page. True: there are more. kMalformed: it does not continue the description, or
// that is longer than kDescriptionMax.
tims::Result<bool> append_page(std::string& description, const DescriptionPage& page);

// ---

// The type of the reply to GET_STATUS.
enum class Status : i8 {
  kEnabled = tims::type::kEnabled,
  kDisabled = tims::type::kDisabled,
  kError = tims::type::kError,
};
std::string_view name(Status status);

// --- The name of a file that a component opens on its own host (specification, section 9.13).

// C programs send and expect 132 bytes, with a NUL after the name; Java programs send the used
// bytes only.
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
