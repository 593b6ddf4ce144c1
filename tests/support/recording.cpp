#include "tests/support/recording.h"

#include <array>
#include <cerrno>
#include <filesystem>
#include <memory>
#include <optional>
#include <string_view>
#include <system_error>

#include <boost/json.hpp>
#include <zlib.h>

#include "base/text.h"
#include "wire/header.h"

namespace tims::test {
namespace {

namespace json = boost::json;
using GzFile = std::unique_ptr<gzFile_s, decltype(&::gzclose)>;
using Line = recorded::Line;

// The error of one line.
struct Malformed {
  std::string text;
};

Result<std::string> unpack(const std::string& path) {
  const GzFile file(::gzopen(path.c_str(), "rb"), &::gzclose);
  if (!file)
    return Error(Errc::kSystem,
                 "cannot open " + path + ": " + std::generic_category().message(errno));
  std::string text;
  std::vector<char> buffer(1 << 20);
  int n = 0;
  while ((n = ::gzread(file.get(), buffer.data(), static_cast<unsigned>(buffer.size()))) > 0) {
    text.append(buffer.data(), static_cast<std::size_t>(n));
  }
  if (n < 0) return Error(Errc::kSystem, path + " is not a complete gzip file");
  return text;
}

// One JSON object with checked access to its members.
class Fields {
 public:
  explicit Fields(std::string_view line) {
    json::error_code error;
    const json::value value = json::parse(line, error);
    if (error || !value.is_object()) throw Malformed{"not a JSON object"};
    object_ = value.as_object();
  }

  [[nodiscard]] bool has(const char* key) const { return object_.contains(key); }
  [[nodiscard]] std::string text(const char* key) const {
    const json::value* value = object_.if_contains(key);
    if (value == nullptr || !value->is_string()) throw Malformed{std::string("no text ") + key};
    return std::string(value->as_string());
  }
  [[nodiscard]] std::int64_t number(const char* key) const {
    const json::value* value = object_.if_contains(key);
    if (value == nullptr || !value->is_int64()) throw Malformed{std::string("no number ") + key};
    return value->as_int64();
  }
  [[nodiscard]] std::vector<std::byte> bytes(const char* key) const {
    auto bytes = base::parse_hex(text(key));
    if (!bytes) throw Malformed{std::string("no hex digits in ") + key};
    return *std::move(bytes);
  }
  // Whether the value is `first`; it must be one of the two.
  [[nodiscard]] bool is_first(const char* key, const char* first, const char* second) const {
    const std::string value_text = text(key);
    if (value_text != first && value_text != second) throw Malformed{std::string("unknown ") + key};
    return value_text == first;
  }

 private:
  json::object object_;
};

recorded::Message parse_message(const Fields& fields) {
  recorded::Message message{fields.is_first("dir", "c2r", "r2c"), fields.bytes("hex")};
  if (message.bytes.size() < kHeaderSize || message.view().header.length != message.bytes.size()) {
    throw Malformed{"the length in the header does not match the message"};
  }
  return message;
}

Line parse_line(std::string_view text) {
  const Fields fields(text);
  Line line;
  line.time = std::chrono::microseconds(fields.number("t_us"));
  const std::string event = fields.has("ev") ? fields.text("ev") : "message";
  if (event == "mark") {
    line.event = recorded::Mark{fields.text("text")};
    return line;
  }
  line.conn = static_cast<int>(fields.number("conn"));
  line.peer = fields.text("peer");
  if (event == "message") {
    line.event = parse_message(fields);
  } else if (event == "connect") {
    line.event = recorded::Connect{};
  } else if (event == "close") {
    line.event = recorded::Close{fields.is_first("by", "router", "client"),
                                 fields.is_first("how", "reset", "eof")};
  } else if (event == "partial") {
    line.event = recorded::Partial{fields.is_first("dir", "c2r", "r2c"), fields.bytes("hex"),
                                   static_cast<std::size_t>(fields.number("bytes"))};
  } else {
    throw Malformed{"unknown event " + event};
  }
  return line;
}

}  // namespace

MessageView recorded::Message::view() const {
  const std::span all(bytes);
  return {wire::decode_header(all.first<kHeaderSize>()), all.subspan(kHeaderSize)};
}

Result<Recording> read_recording(const std::string& path) {
  const auto text = unpack(path);
  if (!text) return text.error();
  Recording recording{std::filesystem::path(path).filename().string(), {}};
  std::string_view rest = *text;
  for (int number = 1; !rest.empty(); ++number) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    try {
      recording.lines.push_back(parse_line(rest.substr(0, end)));
    } catch (const Malformed& problem) {
      return Error(Errc::kInvalidArgument,
                   path + ":" + std::to_string(number) + ": " + problem.text);
    }
    recording.lines.back().number = number;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return recording;
}

}  // namespace tims::test
