#include "security/crypto/aead.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "base/text.h"

namespace tims::security::aead_test {

Bytes hex(std::string_view digits) { return base::parse_hex(digits).value(); }

struct Vector {
  Suite suite;
  std::string_view key, nonce, aad, text, sealed;
};

// ChaCha20-Poly1305: RFC 8439 2.8.2. AES-128-GCM: the GCM specification's test case 4, whose text
// is not a multiple of a block.
constexpr Vector kVectors[] = {
    {Suite::kChaCha20Poly1305, "808182838485868788898a8b8c8d8e8f909192939495969798999a9b9c9d9e9f",
     "070000004041424344454647", "50515253c0c1c2c3c4c5c6c7",
     "4c616469657320616e642047656e746c656d656e206f662074686520636c617373206f66202739393a20496620492"
     "0"
     "636f756c64206f6666657220796f75206f6e6c79206f6e652074697020666f7220746865206675747572652c20737"
     "5"
     "6e73637265656e20776f756c642062652069742e",
     "d31a8d34648e60db7b86afbc53ef7ec2a4aded51296e08fea9e2b5a736ee62d63dbea45e8ca9671282fafb69da927"
     "2"
     "8b1a71de0a9e060b2905d6a5b67ecd3b3692ddbd7f2d778b8c9803aee328091b58fab324e4fad675945585808b483"
     "1"
     "d7bc3ff4def08e4b7a9de576d26586cec64b61161ae10b594f09e26a7e902ecbd0600691"},
    {Suite::kAes128Gcm, "feffe9928665731c6d6a8f9467308308", "cafebabefacedbaddecaf888",
     "feedfacedeadbeeffeedfacedeadbeefabaddad2",
     "d9313225f88406e5a55909c5aff5269a86a7a9531534f7da2e4c303d8a318a721c3c0c95956809532fcf0e2449a6b"
     "5"
     "25b16aedf5aa0de657ba637b39",
     "42831ec2217774244b7221b784d0d49ce3aa212f2c02a4e035c17e2329aca12e21d514b25466931c7d8f6a5aac84a"
     "a"
     "051ba30b396a0aac973d58e0915bc94fbc3221a5db94fae95ae7121a47"},
};

Nonce nonce_of(std::string_view digits) {
  Nonce nonce{};
  std::ranges::copy(hex(digits), nonce.begin());
  return nonce;
}

TEST(Aead, KnownAnswers) {
  for (const Vector& vector : kVectors) {
    Aead seal(Aead::Direction::kSeal);
    Aead open(Aead::Direction::kOpen);
    ASSERT_TRUE(seal.set_key(vector.suite, hex(vector.key)));
    ASSERT_TRUE(open.set_key(vector.suite, hex(vector.key)));
    const Bytes aad = hex(vector.aad);
    Bytes text = hex(vector.text);
    std::array<std::byte, kTagBytes> tag{};
    ASSERT_TRUE(seal.seal(nonce_of(vector.nonce), aad, text, tag));
    EXPECT_EQ(base::to_hex(text) + base::to_hex(tag), vector.sealed);
    ASSERT_TRUE(open.open(nonce_of(vector.nonce), aad, text, tag));
    EXPECT_EQ(base::to_hex(text), vector.text);
  }
}

TEST(Aead, EveryFlippedBitIsSeenAndTheNextDatagramOpens) {
  for (const Suite suite : {Suite::kAes128Gcm, Suite::kChaCha20Poly1305}) {
    const Bytes key(key_bytes(suite), std::byte{7});
    Aead seal(Aead::Direction::kSeal);
    Aead open(Aead::Direction::kOpen);
    ASSERT_TRUE(seal.set_key(suite, key) && open.set_key(suite, key));
    const Bytes aad(16, std::byte{1});
    const Bytes text(37, std::byte{2});
    Bytes sealed = text;
    std::array<std::byte, kTagBytes> tag{};
    ASSERT_TRUE(seal.seal({}, aad, sealed, tag));
    const auto opens = [&](Nonce nonce, Bytes a, Bytes s, std::array<std::byte, kTagBytes> t) {
      return open.open(nonce, a, s, t) && s == text;
    };
    for (std::size_t bit = 0; bit < 128; ++bit) {
      const auto flip = [bit](auto bytes) {
        bytes[bit / 8 % bytes.size()] ^= static_cast<std::byte>(1U << bit % 8);
        return bytes;
      };
      EXPECT_FALSE(opens(flip(Nonce{}), aad, sealed, tag));
      EXPECT_FALSE(opens({}, flip(aad), sealed, tag));
      EXPECT_FALSE(opens({}, aad, flip(sealed), tag));
      EXPECT_FALSE(opens({}, aad, sealed, flip(tag)));
    }
    EXPECT_TRUE(opens({}, aad, sealed, tag));
  }
}

TEST(Aead, NoKeyOrAWrongOneOfAnotherSize) {
  Aead seal(Aead::Direction::kSeal);
  std::array<std::byte, kTagBytes> tag{};
  EXPECT_FALSE(seal.seal({}, {}, {}, tag));
  EXPECT_FALSE(seal.set_key(Suite::kAes128Gcm, Bytes(15)));
  EXPECT_FALSE(seal.set_key(Suite::kAes128Gcm, Bytes(17)));
  EXPECT_FALSE(seal.set_key(Suite::kChaCha20Poly1305, Bytes(16)));
  EXPECT_TRUE(seal.set_key(Suite::kAes128Gcm, Bytes(16)));
  EXPECT_TRUE(seal.seal({}, {}, {}, tag)) << "also an empty text has a tag";
}

TEST(Aead, ANewKeyAndAnotherSuiteInTheSameObject) {
  Aead seal(Aead::Direction::kSeal);
  for (const auto suite : {Suite::kAes128Gcm, Suite::kChaCha20Poly1305, Suite::kAes128Gcm}) {
    for (const auto byte : {std::byte{1}, std::byte{2}}) {
      const Bytes key(key_bytes(suite), byte);
      ASSERT_TRUE(seal.set_key(suite, key));
      Aead other(Aead::Direction::kSeal);
      ASSERT_TRUE(other.set_key(suite, key));
      Bytes a(20), b(20);
      std::array<std::byte, kTagBytes> tag_a{}, tag_b{};
      ASSERT_TRUE(seal.seal({}, {}, a, tag_a) && other.seal({}, {}, b, tag_b));
      EXPECT_EQ(a, b);
      EXPECT_EQ(tag_a, tag_b);
    }
  }
}

}  // namespace tims::security::aead_test
