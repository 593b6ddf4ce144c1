#include "tims/result.h"

#include <cstddef>
#include <iterator>

namespace tims {
namespace {

struct Description {
  Errc code;
  std::string_view name;
  std::string_view sentence;
};

constexpr Description kDescriptions[] = {
    {Errc::kEmpty, "empty", "no message is waiting"},
    {Errc::kTimeout, "timeout", "the time given has passed"},
    {Errc::kClosed, "closed", "the mailbox or session was closed"},
    {Errc::kNoRouter, "no_router", "no router answers"},
    {Errc::kRefused, "refused", "the router refused"},
    {Errc::kAddressInUse, "address_in_use", "address in use"},
    {Errc::kNoMailbox, "no_mailbox", "no such mailbox"},
    {Errc::kFull, "full", "the receiver is full of more important messages"},
    {Errc::kTooBig, "too_big", "the message is too big"},
    {Errc::kBufferTooSmall, "buffer_too_small",
     "the buffer is too small; the message is still in the mailbox"},
    {Errc::kReclaimed, "reclaimed", "the slot was reclaimed by the router"},
    {Errc::kBadLayout, "bad_layout", "the shared memory is not a valid mailbox"},
    {Errc::kVersion, "version", "client and router share no protocol version"},
    {Errc::kInvalidArgument, "invalid_argument", "invalid argument"},
    {Errc::kSystem, "system", "the operating system refused"},
    {Errc::kAnsweredError, "answered_error", "the component answered with an error"},
    {Errc::kMalformed, "malformed", "the bytes are not a valid message"},
    {Errc::kDiskFull, "disk_full", "the disk is full"},
};

constexpr bool table_is_in_order() {
  for (std::size_t i = 0; i < std::size(kDescriptions); ++i) {
    if (static_cast<std::size_t>(kDescriptions[i].code) != i) return false;
  }
  return true;
}
static_assert(table_is_in_order());
static_assert(std::size(kDescriptions) == static_cast<std::size_t>(Errc::kDiskFull) + 1);

// The code may be out of range when it comes from the C API or a damaged file.
const Description& description(Errc code) {
  static constexpr Description kUnknown = {Errc::kSystem, "unknown", "unknown error code"};
  const auto i = static_cast<std::size_t>(code);
  return i < std::size(kDescriptions) ? kDescriptions[i] : kUnknown;
}

}  // namespace

std::string_view name(Errc code) { return description(code).name; }

std::string_view sentence(Errc code) { return description(code).sentence; }

std::string Error::message() const {
  std::string text(sentence(code_));
  if (!detail_.empty()) text.append(": ").append(detail_);
  return text;
}

}  // namespace tims
