// Log texts of components, in one message to the sink (specification, section 8). They are not
// answered. Programs of the original send a format and its arguments; ours send the text itself.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "tims/address.h"
#include "tims/message.h"
#include "tims/result.h"

#pragma GCC visibility push(default)  // exported by librack.so
namespace rack::gdos {

// The message types of log texts; a more important text has a higher number.
enum class Level : std::int8_t {
  kPrint = -124,
  kError = -125,
  kWarning = -126,
  kInfo = -127,
  kDetail = -128,
};
std::string_view name(Level level);  // "print", "error", ...
std::optional<Level> level_of(std::int8_t message_type);
std::optional<Level> level_of(std::string_view name);
// From the value of the parameter gdosLevel: 0 print to 4 detail.
constexpr Level level_of_parameter(int value) { return static_cast<Level>(-124 - value); }

inline constexpr std::size_t kBodyMax = 256;
inline constexpr std::size_t kTextMax = 1024;  // of the format; the formatted numbers may exceed it

using Body = std::array<std::byte, kBodyMax>;

// Writes the body of a message with this text, and returns its length. Allocates nothing. Receivers
// read the text as a format, those of the original too: each % is doubled, and there are no
// arguments. Control characters become blanks. A text that does not fit is cut between characters
// of UTF-8.
std::size_t encode(Body& body, std::string_view text);

// The formatted text of a message from any sender: programs of 32 and 64 bits, of either byte
// order, with the arguments after a text at the positions that original programs use. Conversions:
//   %d %i %u %x %X %b   an integer of 32 bits      %L   one of 64 bits
//   %f                  a number                   %a   radians, printed as degrees
//   %n                  an address, printed as name  %s   a text
//   %p                  a pointer
// Line ends become blanks. kMalformed when the body does not match its format; the error's detail
// is the text that could be read.
tims::Result<std::string> decode(std::span<const std::byte> body, std::endian order,
                                 const tims::AddressWidths& widths = {});

}  // namespace rack::gdos

#pragma GCC visibility pop
