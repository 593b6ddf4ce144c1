// A file of texts: the records do not depend on how it is divided, and each record is written as
// one line without control characters that yields the same record when parsed. Sent as a log text,
// the file is one that receivers can format.
#include <algorithm>
#include <vector>

#include "proxies/gdos_texts.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using rack::gdos::Record;
using rack::gdos::RecordReader;

std::vector<Record> read(std::string_view file, std::size_t piece) {
  RecordReader reader;
  std::vector<Record> records;
  for (std::size_t at = 0; at < file.size(); at += piece)
    reader.read(file.substr(at, piece), [&](Record&& r) { records.push_back(std::move(r)); });
  return records;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view file(reinterpret_cast<const char*>(data), size);
  const auto records = read(file, std::max<std::size_t>(size, 1));
  tims::fuzz::require(records == read(file, 7));
  for (const Record& record : records) {
    const std::string line = rack::gdos::to_line(record);
    tims::fuzz::require(std::ranges::none_of(line.substr(0, line.size() - 1), [](char c) {
      return static_cast<unsigned char>(c) < 0x20 || c == 0x7F;
    }));
    tims::fuzz::require(rack::gdos::record_of(line) == record);
  }
  // A text that a component sends can be read, whatever it contains.
  rack::gdos::Body body{};
  const std::size_t sent = rack::gdos::encode(body, file);
  const auto text = rack::gdos::decode(std::span(body).first(sent), std::endian::native);
  tims::fuzz::require(text && text->size() < rack::gdos::kBodyMax);
  return 0;
}
