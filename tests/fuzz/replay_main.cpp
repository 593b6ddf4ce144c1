// Replaces libFuzzer in builds without it: runs the target on files and on damaged copies of each:
// truncated after every byte, and with single bits of the first bytes inverted, one in seven.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

namespace fs = std::filesystem;
constexpr std::size_t kDamagedBytesMax = 512;
constexpr std::size_t kBitsApart = 7;  // so that each byte and all eight positions occur

std::vector<std::uint8_t> read(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(stream), {}};
  return {bytes.begin(), bytes.end()};
}

std::size_t run(std::vector<std::uint8_t> bytes) {
  std::size_t runs = 1;
  LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
  const std::size_t damaged = std::min(bytes.size(), kDamagedBytesMax);
  for (std::size_t size = 0; size < damaged; ++size, ++runs) {
    // A separate copy, so that the address sanitizer detects reads beyond its end.
    const std::vector<std::uint8_t> cut(bytes.begin(),
                                        bytes.begin() + static_cast<std::ptrdiff_t>(size));
    LLVMFuzzerTestOneInput(cut.data(), cut.size());
  }
  for (std::size_t bit = 0; bit < damaged * 8; bit += kBitsApart, ++runs) {
    const auto mask = static_cast<std::uint8_t>(1U << bit % 8);
    bytes[bit / 8] ^= mask;
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
    bytes[bit / 8] ^= mask;
  }
  return runs;
}

}  // namespace

int main(int argc, char** argv) {
  std::size_t files = 0;
  std::size_t runs = 0;
  for (int i = 1; i < argc; ++i) {
    for (const auto& entry : fs::directory_iterator(argv[i])) {
      runs += run(read(entry.path()));
      ++files;
    }
  }
  std::cout << files << " seeds, " << runs << " runs\n";
  return files == 0 ? 1 : 0;  // a missing corpus is an error
}
