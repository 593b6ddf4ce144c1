#include "tests/support/golden_vectors.h"

#include <fstream>
#include <optional>
#include <sstream>

#include "base/text.h"

namespace tims::test {
namespace {

constexpr const char* kPath = TIMS_TEST_DATA_DIR "/vectors.txt";

std::optional<GoldenVector> parse(const std::string& line) {
  std::istringstream in(line);
  GoldenVector v;
  unsigned flags = 0;
  int type = 0;
  unsigned priority = 0;
  unsigned seq_nr = 0;
  std::uint32_t dest = 0;
  std::uint32_t src = 0;
  std::string header;
  std::string body;
  in >> v.name >> v.origin >> std::hex >> flags >> std::dec >> type >> priority >> seq_nr >>
      std::hex >> dest >> src >> std::dec >> v.stated.length >> header >> body;
  const auto bytes = base::parse_hex(body == "-" ? header : header + body);
  if (!in || header.size() != 2 * kHeaderSize || !bytes) return std::nullopt;
  v.bytes = *bytes;
  v.stated.flags = static_cast<std::uint8_t>(flags);
  v.stated.type = static_cast<std::int8_t>(type);
  v.stated.priority = static_cast<std::uint8_t>(priority);
  v.stated.seq_nr = static_cast<std::uint8_t>(seq_nr);
  v.stated.dest = Address(dest);
  v.stated.src = Address(src);
  return v;
}

}  // namespace

Result<std::vector<GoldenVector>> read_golden_vectors() {
  std::ifstream file(kPath);
  if (!file) return Error(Errc::kSystem, std::string("cannot open ") + kPath);
  std::vector<GoldenVector> vectors;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    if (line.empty() || line.starts_with('#')) continue;
    auto vector = parse(line);
    if (!vector) {
      return Error(Errc::kInvalidArgument, std::string(kPath) + ":" + std::to_string(number));
    }
    vectors.push_back(*std::move(vector));
  }
  return vectors;
}

}  // namespace tims::test
