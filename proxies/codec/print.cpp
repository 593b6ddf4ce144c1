#include "rack/codec/print.h"

#include <array>
#include <charconv>
#include <cmath>

namespace rack::print {

namespace {

constexpr std::string_view kDigits = "0123456789abcdef";

template <typename T>
void append_chars(std::string& out, T value) {
  std::array<char, 32> text{};  // the longest double has 24 characters
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  out.append(text.data(), end);
}

template <typename T>
void append_float(std::string& out, T value) {
  if (std::isfinite(value)) {
    append_chars(out, value);
  } else {
    out += std::isnan(value) ? "nan" : value < 0 ? "-inf" : "inf";
  }
}

}  // namespace

void append(std::string& out, std::int64_t value) { append_chars(out, value); }
void append(std::string& out, std::uint64_t value) { append_chars(out, value); }
void append(std::string& out, float value) { append_float(out, value); }
void append(std::string& out, double value) { append_float(out, value); }

void append_hex(std::string& out, std::span<const std::byte> bytes) {
  out += '"';
  for (const std::byte byte : bytes) {
    const auto value = std::to_integer<unsigned>(byte);
    out += kDigits[value >> 4];
    out += kDigits[value & 0xF];
  }
  out += '"';
}

void append_quoted(std::string& out, std::string_view text) {
  out += '"';
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (c >= ' ' && c <= '~') {
      out += c;
    } else {
      const auto value = static_cast<unsigned char>(c);
      out.append("\\u00") += kDigits[value >> 4U];
      out += kDigits[value & 0xFU];
    }
  }
  out += '"';
}

void begin_entry(std::string& out, std::string_view name, const PrintStyle& style) {
  if (style.one_line && !out.empty()) out += ", ";
  out.append(name).append(style.one_line ? " " : ": ");
}

void end_entry(std::string& out, const PrintStyle& style) {
  if (!style.one_line) out += '\n';
}

}  // namespace rack::print
