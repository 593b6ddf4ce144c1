// Replaces libFuzzer in builds without it: runs the target on files and on damaged copies of each:
// truncated after every byte, and with single bits of the first bytes inverted, one in seven.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

namespace fs = std::filesystem;
constexpr std::size_t kDamagedBytesMax = 512;
constexpr std::size_t kBitsApart = 7;  // so that each byte and all eight positions occur

using Bytes = std::vector<std::uint8_t>;

Bytes read(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(stream), {}};
  return {bytes.begin(), bytes.end()};
}

std::size_t cuts_of(const Bytes& bytes) { return std::min(bytes.size(), kDamagedBytesMax); }
std::size_t copies_of(const Bytes& bytes) {
  return cuts_of(bytes) + (cuts_of(bytes) * 8 + kBitsApart - 1) / kBitsApart;
}

// One of copies_of(bytes).
void run_damaged(Bytes& bytes, std::size_t copy) {
  const std::size_t cuts = cuts_of(bytes);
  if (copy < cuts) {
    // A separate copy, so that the address sanitizer detects reads beyond its end.
    const Bytes cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(copy));
    LLVMFuzzerTestOneInput(cut.data(), cut.size());
    return;
  }
  const std::size_t bit = (copy - cuts) * kBitsApart;
  const auto mask = static_cast<std::uint8_t>(1U << bit % 8);
  bytes[bit / 8] ^= mask;
  LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
  bytes[bit / 8] ^= mask;
}

}  // namespace

// replay COPIES FOLDER: of more damaged copies than that, so many are run, spread over all seeds.
// libFuzzer tries the others.
int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const std::size_t copies_max = std::stoul(argv[1]);
  std::vector<fs::path> paths;
  for (const auto& entry : fs::directory_iterator(argv[2])) paths.push_back(entry.path());
  std::ranges::sort(paths);
  std::vector<Bytes> seeds;
  seeds.reserve(paths.size());
  for (const fs::path& path : paths) seeds.push_back(read(path));
  std::size_t copies = 0;
  for (const Bytes& seed : seeds) copies += copies_of(seed);
  const std::size_t apart = copies / copies_max + 1;
  std::size_t number = 0;  // of a copy, over all seeds
  std::size_t runs = 0;
  for (Bytes& seed : seeds) {
    LLVMFuzzerTestOneInput(seed.data(), seed.size());
    ++runs;
    for (std::size_t copy = 0; copy < copies_of(seed); ++copy) {
      if (number++ % apart != 0) continue;
      run_damaged(seed, copy);
      ++runs;
    }
  }
  std::cout << seeds.size() << " seeds, " << runs << " runs\n";
  return seeds.empty() ? 1 : 0;  // a missing corpus is an error
}
