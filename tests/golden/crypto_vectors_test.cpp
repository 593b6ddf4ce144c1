// AEADs and HKDF against known answers: tests/data/crypto.
#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "base/text.h"
#include "security/crypto/aead.h"
#include "security/crypto/digest.h"

namespace tims::security {
namespace crypto_vectors_test {

// The columns of each line.
std::vector<std::vector<std::string>> read(const std::string& name, std::size_t columns) {
  std::ifstream file(TIMS_TEST_DATA_DIR "/crypto/" + name);
  std::vector<std::vector<std::string>> all;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line.starts_with('#')) continue;
    std::istringstream in(line);
    std::vector<std::string> fields(columns);
    for (std::string& field : fields) in >> field;
    EXPECT_TRUE(in && in.peek() == EOF) << line;
    all.push_back(std::move(fields));
  }
  return all;
}

Bytes hex(const std::string& digits) {
  return digits == "-" ? Bytes() : base::parse_hex(digits).value();
}

TEST(CryptoVectors, OfAeads) {
  std::set<std::string> kinds;
  for (const auto& v : read("aead.txt", 9)) {
    SCOPED_TRACE(v[1] + " " + v[0]);
    kinds.insert(v[1] + " " + v[2]);
    const bool valid = v[2] == "valid";
    const Suite suite = v[1] == "aes128gcm" ? Suite::kAes128Gcm : Suite::kChaCha20Poly1305;
    const Bytes header = hex(v[5]);
    const Bytes text = hex(v[6]);
    const Bytes sealed = hex(v[7]);
    Nonce nonce{};
    std::array<std::byte, kTagBytes> tag{};
    std::ranges::copy(hex(v[4]), nonce.begin());
    std::ranges::copy(hex(v[8]), tag.begin());

    Aead open(Aead::Direction::kOpen);
    ASSERT_TRUE(open.set_key(suite, hex(v[3])));
    Bytes bytes = sealed;
    EXPECT_EQ(open.open(nonce, header, bytes, tag), valid);
    EXPECT_TRUE(!valid || bytes == text);

    Aead seal(Aead::Direction::kSeal);
    ASSERT_TRUE(seal.set_key(suite, hex(v[3])));
    bytes = text;
    std::array<std::byte, kTagBytes> own{};
    ASSERT_TRUE(seal.seal(nonce, header, bytes, own));
    EXPECT_EQ(bytes, sealed);
    EXPECT_EQ(own == tag, valid);
    // What is refused leaves nothing behind: the right tag opens afterwards, a shorter text not.
    bytes = sealed;
    EXPECT_TRUE(open.open(nonce, header, bytes, own));
    if (sealed.empty()) continue;
    bytes.assign(sealed.begin(), sealed.end() - 1);
    EXPECT_FALSE(open.open(nonce, header, bytes, own));
  }
  EXPECT_EQ(kinds.size(), 4U) << "valid and invalid ones of both suites";
}

TEST(CryptoVectors, OfHkdf) {
  const auto all = read("hkdf.txt", 5);
  EXPECT_GE(all.size(), 13U);
  for (const auto& v : all) {
    Bytes output(hex(v[4]).size());
    hkdf_expand(hkdf_extract(hex(v[2]), hex(v[1])), hex(v[3]), output);
    EXPECT_EQ(base::to_hex(output), v[4]) << v[0];
  }
}

}  // namespace crypto_vectors_test
}  // namespace tims::security
