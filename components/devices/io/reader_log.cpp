#include "components/devices/io/reader_log.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "rack/devices/device_address.h"

namespace rack::device {
namespace {

constexpr std::size_t kReasonBytesMax = 300;

// From what explains least to what explains most.
enum class Rank : std::uint8_t { kNothing, kHint, kText, kElement, kPipeline };

struct Line {
  Rank rank = Rank::kNothing;
  std::string_view text{};
};

std::string_view behind(std::string_view text, std::string_view mark) {
  const std::size_t at = text.find(mark);
  return at == std::string_view::npos ? std::string_view() : text.substr(at + mark.size());
}

// "0:00:00.002 27462 0x56 ERROR GST_PIPELINE gst/parse/grammar.y:570:gst_parse: no element "x"".
Line line_of_gstreamer(std::string_view line) {
  const bool is_error = line.find(" ERROR ") != std::string_view::npos;
  const std::string_view category = behind(line, is_error ? " ERROR " : " WARN ");
  std::string_view text = behind(category, ": ");
  const bool names_error = category.find("> error: ") != std::string_view::npos;
  if (names_error) text = behind(category, "> error: ");
  if (text.empty()) text = behind(category, "> ");
  if (is_error) return {Rank::kPipeline, text};
  return {names_error ? Rank::kElement : Rank::kHint, text};
}

// "[ WARN:0@0.016] global ./modules/cap_gstreamer.cpp (1356) open OpenCV | GStreamer warning:
// text".
Line line_of_opencv(std::string_view line) {
  const std::string_view text = behind(line, "GStreamer warning: ");
  constexpr std::array<std::string_view, 3> kNoReasons = {
      "Cannot query video", "unhandled property", "pipeline have not been created"};
  for (const std::string_view none : kNoReasons)
    if (text.starts_with(none)) return {};
  if (!text.empty()) return {Rank::kHint, text};
  const std::string_view error = behind(line, "error: ");
  return {error.empty() ? Rank::kNothing : Rank::kHint, error};
}

Line line_of(std::string_view line) {
  if (line.starts_with("[OPENCV:FFMPEG:")) return {Rank::kText, behind(line, "] ")};
  if (line.starts_with("[ WARN:") || line.starts_with("[ERROR:")) return line_of_opencv(line);
  if (line.find("GStreamer-CRITICAL") != std::string_view::npos ||
      line.find("GLib-") != std::string_view::npos)
    return {};
  if (line.starts_with("0:") && (line.find(" ERROR ") != std::string_view::npos ||
                                 line.find(" WARN ") != std::string_view::npos))
    return line_of_gstreamer(line);
  // FFmpeg without OpenCV: "[tcp @ 0x55d9] text"
  if (line.starts_with('[') && line.find(" @ 0x") < line.find(']'))
    return {Rank::kText, behind(line, "] ")};
  return {Rank::kText, line};
}

std::string cleaned(std::string_view text) {
  std::string clean;
  for (const char c : text.substr(0, kReasonBytesMax)) clean += c >= ' ' && c <= '~' ? c : ' ';
  const std::size_t end = clean.find_last_not_of(" .:");
  clean.resize(end == std::string::npos ? 0 : end + 1);
  return without_passwords(clean);
}

}  // namespace

// Of equal lines of GStreamer the first is the cause, of FFmpeg the last is the most general.
std::string reason_in_log(std::string_view log) {
  Line best;
  while (!log.empty()) {
    const std::string_view whole = log.substr(0, log.find('\n'));
    log.remove_prefix(std::min(log.size(), whole.size() + 1));
    const std::size_t begin = whole.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) continue;
    const Line line = line_of(whole.substr(begin));
    if (line.text.empty() || line.rank < best.rank) continue;
    if (line.rank > best.rank || line.rank == Rank::kText) best = line;
  }
  return cleaned(best.text);
}

}  // namespace rack::device
