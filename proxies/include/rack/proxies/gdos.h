// Log texts of components: a format and its arguments, in one message to the sink (specification,
// section 8). They are not answered.
#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

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
inline constexpr tims::Address kSink = tims::kTextSink;

// Arguments of the conversions:
//   %d %i %u %x %X %b   an integer of 32 bits      %L   one of 64 bits
//   %f                  a number                   %a   radians, printed as degrees
//   %n                  an address, printed as name  %s   a text
class Argument {
 public:
  using Value = std::variant<std::int32_t, std::int64_t, double, tims::Address, std::string_view>;

  template <std::integral T>
  constexpr Argument(T value)  // NOLINT(google-explicit-constructor)
      : value_(make(value)) {}
  constexpr Argument(double value) : value_(value) {}                         // NOLINT
  constexpr Argument(tims::Address value) : value_(value) {}                  // NOLINT
  constexpr Argument(std::string_view value) : value_(value) {}               // NOLINT
  Argument(const std::string& value) : value_(value) {}                       // NOLINT
  constexpr Argument(const char* value) : value_(std::string_view(value)) {}  // NOLINT

  [[nodiscard]] constexpr const Value& value() const { return value_; }

 private:
  template <std::integral T>
  static constexpr Value make(T value) {
    if constexpr (sizeof(T) > 4) {
      return static_cast<std::int64_t>(value);
    } else {
      return static_cast<std::int32_t>(value);
    }
  }
  Value value_;
};

using Body = std::array<std::byte, kBodyMax>;

// Writes the message's body in native byte order; returns its length. Allocates nothing. A text
// argument is shortened when it does not fit. An argument that does not match its conversion or is
// missing is replaced by 0 or an empty text, because logging must never stop a component.
std::size_t encode(Body& body, std::string_view format, std::span<const Argument> arguments);

// The formatted text of a message from any sender: programs of 32 and 64 bits, of either byte
// order, with the arguments after a text at the positions that original programs use. Line ends
// become blanks. kMalformed when the body does not match its format; the error's detail is the text
// that could be read.
tims::Result<std::string> decode(std::span<const std::byte> body, std::endian order,
                                 const tims::AddressWidths& widths = {});

}  // namespace rack::gdos

#pragma GCC visibility pop
