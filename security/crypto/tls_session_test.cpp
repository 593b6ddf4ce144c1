#include "security/crypto/tls_session.h"

#include <gtest/gtest.h>

#include "security/crypto/tls_fixture.h"

namespace tims::security::tls_session_test {

class TlsSessionTest : public testing::Test {
 protected:
  TestPair root_ = test_root("root");
  TestPair issuing_ = test_issued(root_, {.kind = Issue::Kind::kIssuing,
                                          .subject = "issuing",
                                          .uris = {},
                                          .host_names = {},
                                          .not_before = 1000,
                                          .not_after = 4000000000});
  TestPair client_ = test_member(issuing_, {"tims://f/system/3/1"});
  TestPair server_ = test_member(issuing_, {"tims://f/top/0/1"});

  TlsSettings settings(TlsSettings::Side side) {
    const TestPair& own = side == TlsSettings::Side::kServer ? server_ : client_;
    TlsSettings made;
    made.side = side;
    made.chain = {own.certificate, issuing_.certificate};
    made.key = own.key;
    made.trusted = {root_.certificate};
    return made;
  }
  TlsSettings client_settings() { return settings(TlsSettings::Side::kClient); }
  TlsSettings server_settings() { return settings(TlsSettings::Side::kServer); }
};

using State = TlsSession::State;

TEST_F(TlsSessionTest, BothSeeEachOthersChainAndTheSameKeys) {
  TlsSession client(TlsContext::make(client_settings()).value());
  TlsSession server(TlsContext::make(server_settings()).value());
  converse(client, server);
  ASSERT_EQ(client.state(), State::kOpen) << client.error();
  ASSERT_EQ(server.state(), State::kOpen) << server.error();
  ASSERT_EQ(server.peer_chain().size(), 3U);
  EXPECT_EQ(server.peer_chain()[0], client_.certificate);
  EXPECT_EQ(server.peer_chain()[2], root_.certificate);
  EXPECT_EQ(client.peer_chain()[0], server_.certificate);
  EXPECT_EQ(client.version(), "TLSv1.3");
  EXPECT_EQ(client.suite(), has_aes() ? Suite::kAes128Gcm : Suite::kChaCha20Poly1305);
  Digest a{}, b{}, c{};
  ASSERT_TRUE(client.export_keys("EXPERIMENTAL tims", view_of("hello"), a));
  ASSERT_TRUE(server.export_keys("EXPERIMENTAL tims", view_of("hello"), b));
  ASSERT_TRUE(server.export_keys("EXPERIMENTAL tims", view_of("other"), c));
  EXPECT_EQ(a, b);
  EXPECT_NE(a, c);
}

TEST_F(TlsSessionTest, NothingComesUnaskedAfterTheHandshake) {
  TlsSession client(TlsContext::make(client_settings()).value());
  TlsSession server(TlsContext::make(server_settings()).value());
  client.feed({});
  const Bytes hello = client.take();
  server.feed(hello);
  const Bytes flight = server.take();
  client.feed(flight);
  const Bytes finish = client.take();
  server.feed(finish);
  EXPECT_EQ(server.waiting(), 0U) << "tickets";
  // Each flight fits into a datagram.
  EXPECT_LT(hello.size(), 300U);
  EXPECT_LT(flight.size(), 1400U);
  EXPECT_LT(finish.size(), 1200U);
}

TEST_F(TlsSessionTest, DataInPiecesOfAnySizeAndAProperEnd) {
  TlsSession client(TlsContext::make(client_settings()).value());
  TlsSession server(TlsContext::make(server_settings()).value());
  client.feed({});
  while (client.waiting() + server.waiting() > 0) {
    for (Bytes bytes = client.take(1); !bytes.empty(); bytes = client.take(1)) server.feed(bytes);
    for (Bytes bytes = server.take(7); !bytes.empty(); bytes = server.take(7)) client.feed(bytes);
  }
  const std::string text(100000, 'x');
  ASSERT_TRUE(client.write(view_of(text)));
  client.close();
  std::string got;
  while (client.waiting() > 0) {
    server.feed(client.take(1000));
    for (std::string more = read_text(server); !more.empty(); more = read_text(server)) got += more;
  }
  EXPECT_EQ(got, text);
  EXPECT_EQ(server.state(), State::kClosed);
}

TEST_F(TlsSessionTest, AForeignCertificateIsRefusedOnBothSides) {
  const TestPair other = test_root("root");
  client_ = test_member(other, {"tims://f/system/3/1"});
  TlsSettings mine = client_settings();
  mine.chain = {client_.certificate};
  TlsSession client(TlsContext::make(mine).value());
  TlsSession server(TlsContext::make(server_settings()).value());
  converse(client, server);
  EXPECT_EQ(server.state(), State::kFailed);
  EXPECT_NE(server.error().find("not accepted"), std::string::npos) << server.error();
  read_text(client);
  EXPECT_EQ(client.state(), State::kFailed);
  EXPECT_NE(client.error().find("other side refuses: unknown CA"), std::string::npos)
      << client.error();
}

TEST_F(TlsSessionTest, WithoutACertificateThereIsNoSession) {
  TlsSettings mine = client_settings();
  mine.chain.clear();
  mine.key.reset();
  TlsSession client(TlsContext::make(mine).value());
  TlsSession server(TlsContext::make(server_settings()).value());
  converse(client, server);
  EXPECT_EQ(server.state(), State::kFailed);
  TlsSettings optional = server_settings();
  optional.peer = TlsSettings::PeerCertificate::kOptional;
  TlsSession client2(TlsContext::make(mine).value());
  TlsSession server2(TlsContext::make(optional).value());
  converse(client2, server2);
  EXPECT_EQ(server2.state(), State::kOpen) << server2.error();
  EXPECT_TRUE(server2.peer_chain().empty());
}

TEST_F(TlsSessionTest, ARefusalOfTheJudgeReachesBothSides) {
  for (const auto& [code, alert] : {std::pair{Refusal::Code::kRevoked, "revoked"},
                                    std::pair{Refusal::Code::kExpired, "expired"},
                                    std::pair{Refusal::Code::kIdentity, "handshake failure"}}) {
    TlsSettings strict = server_settings();
    int depths = 0;
    strict.judge = [&, code = code](const Certificate& one, int depth) -> std::optional<Refusal> {
      ++depths;
      if (depth != 0) return std::nullopt;
      EXPECT_EQ(one, client_.certificate);
      return Refusal{code, "not this one"};
    };
    TlsSession client(TlsContext::make(client_settings()).value());
    TlsSession server(TlsContext::make(strict).value());
    converse(client, server);
    EXPECT_EQ(server.state(), State::kFailed);
    EXPECT_EQ(server.error(), "not this one");
    EXPECT_EQ(depths, 1);
    read_text(client);
    EXPECT_NE(client.error().find(alert), std::string::npos) << client.error();
  }
}

TEST_F(TlsSessionTest, AMemberIsNoAuthority) {
  const TestPair forged = test_member(client_, {"tims://f/top/0/1"});
  TlsSettings mine = server_settings();
  mine.chain = {forged.certificate, client_.certificate, issuing_.certificate};
  mine.key = forged.key;
  TlsSession client(TlsContext::make(client_settings()).value());
  TlsSession server(TlsContext::make(mine).value());
  converse(client, server);
  EXPECT_EQ(client.state(), State::kFailed);
}

TEST_F(TlsSessionTest, ARootIsKnownByItsFingerprint) {
  TlsSettings mine = client_settings();
  mine.trusted.clear();
  mine.trusted_fingerprint.emplace();
  std::ranges::copy_n(root_.certificate.fingerprint().begin(), 16,
                      mine.trusted_fingerprint->begin());
  TlsSettings with_root = server_settings();
  with_root.chain.push_back(root_.certificate);
  TlsSession client(TlsContext::make(mine).value());
  TlsSession server(TlsContext::make(with_root).value());
  converse(client, server);
  EXPECT_EQ(client.state(), State::kOpen) << client.error();

  // Another root of the same name, with a chain that is right in itself.
  TlsSettings wrong = mine;
  wrong.trusted_fingerprint->at(15) ^= std::byte{1};
  TlsSession client2(TlsContext::make(wrong).value());
  TlsSession server2(TlsContext::make(with_root).value());
  converse(client2, server2);
  EXPECT_EQ(client2.state(), State::kFailed);
  // The issuing certificate's fingerprint is not that of a root.
  std::ranges::copy_n(issuing_.certificate.fingerprint().begin(), 16,
                      wrong.trusted_fingerprint->begin());
  TlsSession client3(TlsContext::make(wrong).value());
  TlsSession server3(TlsContext::make(with_root).value());
  converse(client3, server3);
  EXPECT_EQ(client3.state(), State::kFailed);
}

TEST_F(TlsSessionTest, GarbageFails) {
  TlsSession server(TlsContext::make(server_settings()).value());
  server.feed(view_of("GET / HTTP/1.1\r\n\r\n"));
  EXPECT_EQ(server.state(), State::kFailed);
  EXPECT_FALSE(server.error().empty());
  EXPECT_FALSE(server.write(view_of("x")));
}

// A ClientHello of TLS 1.2, also as an attacker makes it of one of 1.3 by leaving out what it
// supports.
TEST_F(TlsSessionTest, OlderVersionsAreRefused) {
  Bytes hello;
  const auto add = [&](std::initializer_list<int> values) {
    for (const int value : values) hello.push_back(static_cast<std::byte>(value));
  };
  add({0x16, 3, 1, 0, 75, 1, 0, 0, 71, 3, 3});
  hello.resize(hello.size() + 32);                                // random
  add({0, 0, 4, 0xC0, 0x2B, 0x13, 0x01, 1, 0});                   // suites of 1.2 and of 1.3
  add({0, 26, 0, 10, 0, 4, 0, 2, 0, 23});                         // extensions; groups: P-256
  add({0, 11, 0, 2, 1, 0, 0, 13, 0, 8, 0, 6, 4, 3, 8, 4, 4, 1});  // signatures
  ASSERT_EQ(hello.size(), 80U);
  TlsSession server(TlsContext::make(server_settings()).value());
  (void)server.feed(hello);
  EXPECT_EQ(server.state(), State::kFailed);
  EXPECT_NE(server.error().find("unsupported protocol"), std::string::npos) << server.error();
}

TEST_F(TlsSessionTest, KeyAndCertificateOfOthersMakeNoContext) {
  TlsSettings mine = server_settings();
  mine.key = client_.key;
  EXPECT_FALSE(TlsContext::make(mine).ok());
  mine.key.reset();
  EXPECT_FALSE(TlsContext::make(mine).ok());
}

}  // namespace tims::security::tls_session_test
