#include "security/crypto/digest.h"

#include <gtest/gtest.h>

#include "base/text.h"

namespace tims::security::digest_test {

Bytes hex(std::string_view digits) { return base::parse_hex(digits).value(); }

TEST(Digest, KnownAnswers) {
  EXPECT_EQ(base::to_hex(sha256(view_of("abc"))),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  // RFC 4231, test case 2.
  EXPECT_EQ(base::to_hex(hmac_sha256(view_of("Jefe"), view_of("what do ya want for nothing?"))),
            "5bdcc146bf60754e6a042426089575c75a003f089d2739839dec58b964ec3843");
  EXPECT_EQ(base::to_hex(hmac_sha256({}, {})),
            "b613679a0814d9ec772f95d778c35fc5ff1697c493715653c6c712144292c5ad");
}

// RFC 5869, A.1.
TEST(Digest, Hkdf) {
  const Digest secret = hkdf_extract(hex("000102030405060708090a0b0c"),
                                     hex("0b0b0b0b0b0b0b0b0b0b0b0b0b0b0b0b0b0b0b0b0b0b"));
  EXPECT_EQ(base::to_hex(secret),
            "077709362c2e32df0ddc3f0dc47bba6390b6c73bb50f9c3122ec844ad7c2b3e5");
  Bytes out(42);
  hkdf_expand(secret, hex("f0f1f2f3f4f5f6f7f8f9"), out);
  EXPECT_EQ(base::to_hex(out),
            "3cb25f25faacd57a90434f64d0362f2a2d2d0a90cf1a5a4c5db02d56ecc4c5bf34007208d5b887185865");
}

// RFC 9001, A.1: the first keys of QUIC.
TEST(Digest, HkdfExpandLabel) {
  const Digest initial =
      hkdf_extract(hex("38762cf7f55934b34d179ae6a4c80cadccbb7f0a"), hex("8394c8f03e515708"));
  Digest client{};
  hkdf_expand_label(initial, "client in", {}, client);
  EXPECT_EQ(base::to_hex(client),
            "c00cf151ca5be075ed0ebfb5c80323c42d6b7db67881289af4008f1f6c357aea");
  Bytes key(16);
  hkdf_expand_label(client, "quic key", {}, key);
  EXPECT_EQ(base::to_hex(key), "1f369613dd76d5467730efcbe3b1a22d");
  Bytes iv(12);
  hkdf_expand_label(client, "quic iv", {}, iv);
  EXPECT_EQ(base::to_hex(iv), "fa044b2f42a3fd3b46fb255c");
}

TEST(Digest, RandomBytesDiffer) {
  Digest a{}, b{};
  fill_random(a);
  fill_random(b);
  EXPECT_NE(a, b);
  EXPECT_TRUE(equal_secretly(a, a));
  EXPECT_FALSE(equal_secretly(a, b));
  EXPECT_FALSE(equal_secretly(a, View(a).first(31)));
  wipe(a);
  EXPECT_EQ(a, Digest{});
}

}  // namespace tims::security::digest_test
