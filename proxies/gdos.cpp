#include "rack/proxies/gdos.h"

#include <algorithm>
#include <cctype>
#include <numbers>

#include <fmt/format.h>

#include "base/text.h"
#include "rack/codec/codec.h"

namespace rack::gdos {
namespace {

// A conversion of a format, or a run of plain characters.
struct Part {
  std::string_view text;  // without the %
  char conversion = 0;    // 0: plain
};

// Iterates over a format. Width and precision are skipped, as in the original formatter.
class Format {
 public:
  explicit Format(std::string_view format) : left_(format) {}

  std::optional<Part> next() {
    if (left_.empty()) return std::nullopt;
    if (left_[0] != '%') return plain(std::min(left_.find('%'), left_.size()));
    std::size_t at = 1;
    while (at < left_.size() && (std::isdigit(static_cast<unsigned char>(left_[at])) != 0 ||
                                 left_[at] == '.' || left_[at] == '-'))
      ++at;
    if (at == left_.size()) return plain(at);
    const Part part{left_.substr(0, at + 1), left_[at]};
    left_.remove_prefix(at + 1);
    if (part.conversion == '%') return Part{part.text.substr(0, 1)};
    return part;
  }

 private:
  Part plain(std::size_t size) {
    const Part part{left_.substr(0, size)};
    left_.remove_prefix(size);
    return part;
  }
  std::string_view left_;
};

// Bytes of an argument; 0 for a text. Nothing: the conversion is not supported.
std::optional<std::size_t> size_of(char conversion, std::size_t pointer) {
  switch (conversion) {
    case 'd':
    case 'i':
    case 'u':
    case 'x':
    case 'X':
    case 'b':
    case 'n':
      return 4;
    case 'p':
      return pointer;
    case 'f':
    case 'a':
    case 'L':
      return 8;
    case 's':
      return 0;
    default:
      return std::nullopt;
  }
}

// How a sender may have laid out the arguments.
struct Layout {
  std::size_t pointer = 8;
  // C programs of the original: the next argument overwrites the NUL
  bool texts_without_end = false;
};

class Reader {
 public:
  Reader(std::span<const std::byte> left, std::endian order, const tims::AddressWidths& widths,
         const Layout& layout)
      : left_(left), order_(order), widths_(widths), layout_(layout) {}

  // False: the arguments do not match the format. The text then contains what could be read.
  bool run(std::string_view format) {
    Format rest(format);
    while (const auto part = rest.next()) {
      if (part->conversion == 0) {
        text_ += part->text;
      } else if (!argument(part->conversion, rest)) {
        text_ += part->text;
        return false;
      }
    }
    return left_.size() == (stray_ ? 1U : 0U);
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  template <typename T>
  T take() {
    T value{};
    (void)bytes::read(left_.data(), order_, value);
    left_ = left_.subspan(sizeof value);
    return value;
  }

  bool argument(char conversion, const Format& rest) {
    const auto size = size_of(conversion, layout_.pointer);
    if (!size || *size > left_.size()) return false;
    switch (conversion) {
      case 's':
        return text_argument(rest);
      case 'x':
      case 'X':
        text_ += fmt::format("{:x}", take<std::uint32_t>());
        return true;
      case 'b':
        text_ += fmt::format("{:b}", take<std::uint32_t>());
        return true;
      case 'n':
        text_ += tims::Address(take<std::uint32_t>()).to_string(widths_);
        return true;
      case 'p':
        text_ += fmt::format("{:#x}", *size == 8 ? take<std::uint64_t>() : take<std::uint32_t>());
        return true;
      case 'f':
        text_ += fmt::format("{:.3f}", take<double>());
        return true;
      case 'a':
        text_ += fmt::format("{:.2f}", take<double>() * 180 / std::numbers::pi);
        return true;
      case 'L':
        text_ += fmt::format("{}", take<std::int64_t>());
        return true;
      default:
        text_ += fmt::format("{}", take<std::int32_t>());
        return true;
    }
  }

  bool text_argument(const Format& rest) {
    const std::string_view all(reinterpret_cast<const char*>(left_.data()), left_.size());
    std::size_t size = all.find('\0');
    std::size_t used = size + 1;
    const std::size_t behind = fixed_size(rest);
    if (layout_.texts_without_end && behind > 0) {
      // One byte is left over at the end, because the sender counted the NUL.
      if (behind + 1 > all.size()) return false;
      used = size = all.size() - behind - 1;
      stray_ = true;
    } else if (size == std::string_view::npos) {
      return false;
    }
    text_ += all.substr(0, size);
    left_ = left_.subspan(used);
    return true;
  }
  // Total size of the remaining arguments; 0 when there are none, or one of them is a text.
  [[nodiscard]] std::size_t fixed_size(Format rest) const {
    std::size_t size = 0;
    while (const auto part = rest.next()) {
      if (part->conversion == 0) continue;
      const auto needed = size_of(part->conversion, layout_.pointer);
      if (needed.value_or(0) == 0) return 0;
      size += *needed;
    }
    return size;
  }

  std::span<const std::byte> left_;
  std::endian order_;
  const tims::AddressWidths& widths_;
  const Layout layout_;
  std::string text_;
  bool stray_ = false;
};

std::string one_line(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < ' ' || c == 0x7F) c = ' ';
  }
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

// Of at least as many bytes as the character: a receiver formats the text.
std::string_view sent_as(const tims::base::Character& c, std::string_view bytes) {
  constexpr std::string_view kBlanks = "  ";
  if (bytes == "%") return "%%";
  return c.bytes > 0 && tims::base::is_control(c.code) ? kBlanks.substr(0, c.bytes) : bytes;
}

// Index: the value of the parameter gdosLevel.
constexpr std::array<std::string_view, 5> kLevels = {"print", "error", "warning", "info", "detail"};
constexpr Layout kLayouts[] = {{8, false}, {4, false}, {8, true}, {4, true}};

}  // namespace

std::string_view name(Level level) {
  const auto i =
      static_cast<std::size_t>(static_cast<int>(Level::kPrint) - static_cast<int>(level));
  return i < kLevels.size() ? kLevels[i] : "unknown";
}

std::optional<Level> level_of(std::int8_t message_type) {
  if (message_type > static_cast<std::int8_t>(Level::kPrint)) return std::nullopt;
  return static_cast<Level>(message_type);
}

std::optional<Level> level_of(std::string_view text) {
  const auto found = std::ranges::find(kLevels, text);
  if (found == kLevels.end()) return std::nullopt;
  return level_of_parameter(static_cast<int>(found - kLevels.begin()));
}

std::size_t encode(Body& body, std::string_view text) {
  std::size_t size = 0;
  std::size_t end = 0;  // without the blanks at the end
  const auto bytes = std::span(body);
  while (!text.empty()) {
    const tims::base::Character c = tims::base::first_character(text);
    const std::string_view character = text.substr(0, std::max<std::size_t>(c.bytes, 1));
    const std::string_view written = sent_as(c, character);
    if (size + written.size() >= kBodyMax) break;
    std::ranges::copy(std::as_bytes(std::span(written)), bytes.subspan(size).begin());
    size += written.size();
    if (written[0] != ' ') end = size;
    text.remove_prefix(character.size());
  }
  body[end] = std::byte{0};
  return end + 1;
}

tims::Result<std::string> decode(std::span<const std::byte> body, std::endian order,
                                 const tims::AddressWidths& widths) {
  const std::string_view all(reinterpret_cast<const char*>(body.data()), body.size());
  const std::size_t end = all.find('\0');
  const std::string_view format = all.substr(0, end);
  const auto arguments = body.subspan(std::min(body.size(), format.size() + 1));
  std::string first;
  for (const Layout& layout : kLayouts) {
    Reader reader(arguments, order, widths, layout);
    if (reader.run(format)) return one_line(reader.text());
    if (first.empty()) first = reader.text();
  }
  return tims::Error(tims::Errc::kMalformed, one_line(std::move(first)));
}

}  // namespace rack::gdos
