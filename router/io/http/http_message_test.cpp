#include "router/io/http/http_message.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace tims::io {
namespace http_message_test {

using Status = HttpReader::Status;

// Everything that comes out of `bytes` when at most `cut` of them come at once: the requests as
// "GET /x", and the status of the refusal that ends them.
std::vector<std::string> read(std::string_view bytes, std::size_t cut, HttpReader& reader) {
  std::vector<std::string> story;
  while (!bytes.empty()) {
    const auto room = reader.room();
    EXPECT_FALSE(room.empty());
    const std::size_t n = std::min({cut, bytes.size(), room.size()});
    std::copy_n(bytes.begin(), n, room.begin());
    bytes.remove_prefix(n);
    reader.advance(n);
    Status status = reader.next();
    for (; status == Status::kRequest; status = reader.next())
      story.push_back(reader.request().method + " " + reader.request().target);
    if (status != Status::kRefused) continue;
    story.push_back(std::to_string(reader.refusal().status));
    return story;
  }
  return story;
}
std::vector<std::string> read(std::string_view bytes, std::size_t cut = 100000) {
  HttpReader reader;
  return read(bytes, cut, reader);
}

using Story = std::vector<std::string>;
const std::string kGet = "GET /metrics?x=1 HTTP/1.1\r\nHost: localhost\r\n\r\n";

// A request whose head has so many bytes.
std::string head_of(std::size_t size) {
  std::string head = "GET / HTTP/1.1\r\nHost: localhost\r\n";
  for (int i = 0; head.size() + 1004 < size; ++i)
    head.append("F").append(std::to_string(i)).append(": ").append(900, 'x').append("\r\n");
  head += "Last: " + std::string(size - head.size() - 10, 'x') + "\r\n\r\n";
  return head;
}

TEST(HttpReader, OneRequest) {
  HttpReader reader;
  EXPECT_EQ(read("GET /a/b?c=d HTTP/1.1\r\nHost: localhost:8080\r\nX: y\r\n\r\n", 1000, reader),
            Story{"GET /a/b?c=d"});
  const HttpRequest& request = reader.request();
  EXPECT_EQ(request.path(), "/a/b");
  EXPECT_EQ(request.query(), "c=d");
  EXPECT_TRUE(request.keep_alive);
  EXPECT_FALSE(request.wants_websocket);
  ASSERT_EQ(request.fields.size(), 2U);
  EXPECT_EQ(request.fields[0].name, "Host");
  EXPECT_EQ(request.fields[0].value, "localhost:8080");
  EXPECT_EQ(reader.pending(), 0U);
  EXPECT_FALSE(reader.is_inside());
}

TEST(HttpReader, PipelinedAndSplitAnywhere) {
  const std::string bytes = kGet + "POST /b HTTP/1.1\r\nContent-Length: 5\r\n\r\nGET /" + kGet +
                            "HEAD /c HTTP/1.0\r\n\r\n" + kGet;
  const Story all{"GET /metrics?x=1", "POST /b", "GET /metrics?x=1", "HEAD /c", "GET /metrics?x=1"};
  for (const std::size_t cut : {1, 2, 3, 7, 50, 1000}) EXPECT_EQ(read(bytes, cut), all) << cut;
}

TEST(HttpReader, WhetherTheConnectionStays) {
  const auto keeps = [](const std::string& bytes) {
    HttpReader reader;
    read(bytes, 1000, reader);
    return reader.request().keep_alive;
  };
  EXPECT_TRUE(keeps("GET / HTTP/1.1\r\n\r\n"));
  EXPECT_FALSE(keeps("GET / HTTP/1.1\r\nConnection: close\r\n\r\n"));
  EXPECT_FALSE(keeps("GET / HTTP/1.0\r\n\r\n"));
  EXPECT_TRUE(keeps("GET / HTTP/1.0\r\nConnection: keep-alive\r\n\r\n"));
}

TEST(HttpReader, WhetherItIsInsideARequest) {
  HttpReader reader;
  EXPECT_FALSE(reader.is_inside());
  read("GE", 10, reader);
  EXPECT_TRUE(reader.is_inside());
  read("T / HTTP/1.1\r\nContent-Length: 3\r\n\r\n", 100, reader);
  EXPECT_TRUE(reader.is_inside());
  EXPECT_EQ(read("abc", 100, reader), Story{"GET /"});
  EXPECT_FALSE(reader.is_inside());
}

TEST(HttpReader, WebSocketsAreRecognised) {
  HttpReader reader;
  read(
      "GET /tims HTTP/1.1\r\nHost: x\r\nConnection: keep-alive, Upgrade\r\nUpgrade: websocket\r\n"
      "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n\x82\x00",
      1000, reader);
  EXPECT_TRUE(reader.request().wants_websocket);
}

TEST(HttpReader, HeadsUpToTheLimit) {
  for (const std::size_t cut : {1000U, 100000U}) {
    EXPECT_EQ(read(head_of(kHttpHeadBytesMax), cut), Story{"GET /"});
    EXPECT_EQ(read(head_of(kHttpHeadBytesMax + 1), cut), Story{"431"});
    EXPECT_EQ(read(head_of(100000), cut), Story{"431"});
    EXPECT_EQ(read(kGet + head_of(kHttpHeadBytesMax), cut), (Story{"GET /metrics?x=1", "GET /"}));
  }
  EXPECT_EQ(read("GET /" + std::string(10000, 'a')), Story{"431"});
  EXPECT_EQ(read(std::string(10000, 'A')), Story{"431"});
}

TEST(HttpReader, BodiesUpToTheLimit) {
  const auto with_body = [](std::size_t size) {
    return "POST / HTTP/1.1\r\nContent-Length: " + std::to_string(size) + "\r\n\r\n" +
           std::string(size, 'b');
  };
  EXPECT_EQ(read(with_body(kHttpBodyBytesMax) + kGet, 100), (Story{"POST /", "GET /metrics?x=1"}));
  EXPECT_EQ(read(with_body(kHttpBodyBytesMax + 1)), Story{"413"});
  EXPECT_EQ(read("POST / HTTP/1.1\r\nContent-Length: 18446744073709551615\r\n\r\n"), Story{"413"});
}

TEST(HttpReader, ChunkedBodies) {
  const std::string head = "POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n";
  for (const std::size_t cut : {1, 1000}) {
    EXPECT_EQ(read(head + "3\r\nabc\r\n0\r\n\r\n" + kGet, cut),
              (Story{"POST /", "GET /metrics?x=1"}));
    EXPECT_EQ(read(head + "1001\r\n" + std::string(0x1001, 'b'), cut), Story{"413"});
    EXPECT_EQ(read(head + "x\r\n", cut), Story{"400"});
  }
  // A chunk's line that never ends.
  EXPECT_EQ(read(head + "3;" + std::string(20000, 'x'), 1000), Story{"431"});
}

TEST(HttpReader, WhatIsNoRequest) {
  EXPECT_EQ(read(std::string("\x00\x01\x02\x03\r\n\r\n", 8)), Story{"400"});
  EXPECT_EQ(read("\x16\x03\x01\x02\x00\x01\r\n\r\n"), Story{"400"});  // TLS
  EXPECT_EQ(read("GET /\r\n\r\n"), Story{"400"});
  EXPECT_EQ(read("GET / HTTP/2.0\r\n\r\n"), Story{"505"});
  EXPECT_EQ(read("GET / HTTP/1.1\nHost: x\n\n\r\n\r\n"), Story{"505"});
  EXPECT_EQ(read("GET / HTTP/1.1\r\nno colon\r\n\r\n"), Story{"400"});
  EXPECT_EQ(read("GET / HTTP/1.1\r\nContent-Length: -1\r\n\r\n"), Story{"400"});
  EXPECT_EQ(read("GET / HTTP/1.1\r\nContent-Length: 1\r\nContent-Length: 2\r\n\r\n"), Story{"400"});
}

TEST(HttpReader, ARefusalIsTheEnd) {
  HttpReader reader;
  EXPECT_EQ(read(kGet + "nonsense\r\n\r\n", 1000, reader), (Story{"GET /metrics?x=1", "400"}));
  EXPECT_EQ(reader.next(), Status::kRefused);
  EXPECT_NE(reader.refusal().body.find("not an HTTP request"), std::string::npos);
}

}  // namespace http_message_test

}  // namespace tims::io
