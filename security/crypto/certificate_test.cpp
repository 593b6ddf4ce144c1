#include "security/crypto/certificate.h"

#include <gtest/gtest.h>

#include "security/crypto/tls_fixture.h"

namespace tims::security::certificate_test {

TEST(Certificate, WhatIsIssuedIsReadBack) {
  const TestPair root = test_root("root");
  const TestPair issuing = test_issued(root, {.kind = Issue::Kind::kIssuing,
                                              .subject = "issuing",
                                              .uris = {},
                                              .host_names = {},
                                              .not_before = 1000,
                                              .not_after = 2000});
  const Issue issue{.kind = Issue::Kind::kMember,
                    .subject = "robot3",
                    .uris = {"tims://f/system/3/1", "tims://f/name/robot3"},
                    .host_names = {"robot3", "robot3.local", "10.9.1.3", "2001:db8::3"},
                    .not_before = -5,
                    .not_after = 253402300799};  // the end of 9999
  const TestPair member = test_issued(issuing, issue);
  EXPECT_EQ(member.certificate.uris(), issue.uris);
  EXPECT_EQ(member.certificate.host_names(), issue.host_names);
  EXPECT_EQ(member.certificate.subject(), "robot3");
  EXPECT_EQ(member.certificate.not_before(), -5);
  EXPECT_EQ(member.certificate.not_after(), 253402300799);
  EXPECT_EQ(member.certificate.serial().size(), 32U);
  EXPECT_FALSE(member.certificate.is_authority());
  EXPECT_TRUE(issuing.certificate.is_authority() && root.certificate.is_authority());
  EXPECT_TRUE(root.certificate.is_self_signed());
  EXPECT_FALSE(issuing.certificate.is_self_signed());
  EXPECT_TRUE(root.certificate.has_signed(issuing.certificate));
  EXPECT_TRUE(issuing.certificate.has_signed(member.certificate));
  EXPECT_FALSE(root.certificate.has_signed(member.certificate));
  EXPECT_TRUE(member.certificate.belongs_to(member.key));
  EXPECT_FALSE(member.certificate.belongs_to(root.key));
  EXPECT_EQ(member.certificate.public_key_hash(), member.key.public_key_hash());
}

TEST(Certificate, PemAndDerAreReadExactly) {
  const TestPair root = test_root("root");
  const std::string pem = root.certificate.to_pem();
  ASSERT_TRUE(Certificate::from_pem(pem).ok());
  EXPECT_EQ(Certificate::from_pem(pem + pem + "\n").value().size(), 2U);
  EXPECT_FALSE(Certificate::from_pem("").ok());
  EXPECT_FALSE(Certificate::from_pem(pem.substr(0, pem.size() / 2)).ok());
  EXPECT_FALSE(Certificate::from_pem(pem + pem.substr(0, pem.size() / 2)).ok());
  std::string many;
  for (int i = 0; i < 16; ++i) many += pem;
  EXPECT_EQ(Certificate::from_pem(many).value().size(), 16U);
  EXPECT_FALSE(Certificate::from_pem(many + pem).ok());

  Bytes der = root.certificate.to_der();
  EXPECT_EQ(Certificate::from_der(der).value(), root.certificate);
  der.push_back({});
  EXPECT_FALSE(Certificate::from_der(der).ok()) << "bytes behind it";
  der.resize(der.size() - 2);
  EXPECT_FALSE(Certificate::from_der(der).ok());
}

TEST(Certificate, AKeyOfAnotherKindIsRefused) {
  EXPECT_FALSE(PrivateKey::from_pem("").ok());
  const auto other = PrivateKey::from_pem(
      "-----BEGIN PRIVATE KEY-----\n"
      "MC4CAQAwBQYDK2VwBCIEIJ1hsZ3v/VpguoRK9JLsLMREScVpezJpGXA7rAMcrn9g\n"
      "-----END PRIVATE KEY-----\n");  // Ed25519
  ASSERT_FALSE(other.ok());
  EXPECT_NE(other.error().detail().find("P-256"), std::string::npos);
  const auto key = PrivateKey::generate().value();
  EXPECT_EQ(PrivateKey::from_pem(key.to_pem()).value().public_key_hash(), key.public_key_hash());
}

TEST(Certificate, SignaturesOfDataAreVerified) {
  const TestPair root = test_root("root");
  const auto signature = root.key.sign(view_of("hello")).value();
  EXPECT_TRUE(root.certificate.verify(view_of("hello"), signature));
  EXPECT_FALSE(root.certificate.verify(view_of("hellO"), signature));
  EXPECT_FALSE(root.certificate.verify(view_of("hello"), View(signature).first(20)));
  EXPECT_FALSE(test_root("root").certificate.verify(view_of("hello"), signature));
}

TEST(CertificateRequest, CarriesKeyAndNamesAndProvesTheKey) {
  const auto key = PrivateKey::generate().value();
  const auto made = CertificateRequest::make(key, {"tims://f/system/3/1"}).value();
  const auto read = CertificateRequest::from_pem(made.to_pem()).value();
  EXPECT_EQ(read.uris(), std::vector<std::string>{"tims://f/system/3/1"});
  EXPECT_EQ(read.public_key_hash(), key.public_key_hash());
  std::string damaged = made.to_pem();
  damaged[damaged.size() - 60] = damaged[damaged.size() - 60] == 'A' ? 'B' : 'A';
  EXPECT_FALSE(CertificateRequest::from_pem(damaged).ok());
}

}  // namespace tims::security::certificate_test
