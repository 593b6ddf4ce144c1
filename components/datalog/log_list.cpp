#include "components/datalog/log_list.h"

#include <charconv>

#include "components/datalog/record_format.h"

namespace rack::datalog {
namespace {

constexpr std::size_t kListMax = 100;

tims::Error bad(std::size_t line, std::string_view what) {
  return {tims::Errc::kMalformed, "line " + std::to_string(line) + ": " + std::string(what)};
}

std::string_view take_line(std::string_view& text) {
  const auto end = text.find('\n');
  std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

tims::Result<DatalogLogInfo> read_entry(std::string_view line, std::size_t number,
                                        const tims::AddressWidths& widths) {
  const auto blank = line.find(' ');
  if (blank == std::string_view::npos || blank + 1 == line.size())
    return bad(number, "expected an address, a blank and a file name");
  std::string_view digits = line.substr(0, blank);
  if (digits.starts_with("0x")) digits.remove_prefix(2);
  u32 address = 0;
  const auto [end, error] =
      std::from_chars(digits.data(), digits.data() + digits.size(), address, 16);
  if (error != std::errc() || end != digits.data() + digits.size())
    return bad(number, "the address is no hexadecimal number");
  DatalogLogInfo info{.moduleMbx = tims::Address(address)};
  const RecordedClass* recorded = recorded_class(info.moduleMbx.fields(widths).class_id);
  if (recorded == nullptr) return bad(number, "data of this class are not recorded");
  info.maxDataLen = static_cast<i32>(recorded->body_max);
  if (!info.filename.assign(line.substr(blank + 1)))
    return bad(number, "the file name is longer than 39 characters");
  return info;
}

}  // namespace

tims::Result<std::vector<DatalogLogInfo>> read_list(std::string_view text,
                                                    const tims::AddressWidths& widths) {
  std::vector<DatalogLogInfo> list;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::string_view line = take_line(text);
    if (line.empty()) break;
    const auto entry = read_entry(line, number, widths);
    if (!entry) return entry.error();
    if (list.size() == kListMax) return bad(number, "more than 100 modules");
    list.push_back(*entry);
  }
  return list;
}

std::string base_of(const std::string& path) {
  const auto name = path.rfind('/') + 1;  // also when there is none
  const auto dot = path.rfind('.');
  return dot == std::string::npos || dot < name ? path : path.substr(0, dot);
}

}  // namespace rack::datalog
