#include "router/io/http/console_files.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tims::io {
namespace console_files_test {

using testing::HasSubstr;
using testing::Not;

using Fields = std::vector<HttpRequest::Field>;

HttpRequest get(std::string target, Fields fields = {}) {
  return {.method = "GET", .target = std::move(target), .fields = std::move(fields)};
}
HttpRequest get_coded(std::string target, std::string codings) {
  return get(std::move(target), {{"Accept-Encoding", std::move(codings)}});
}

const std::string kScript = "main-A1B2C3D4.js";

class ConsoleFilesTest : public testing::Test {
 protected:
  void SetUp() override {
    add("index.html", "<p>page");
    add(kScript, "plain");
    add(kScript + ".br", "brotli");
    add(kScript + ".gz", "gzip");
    add("icons/robot.svg", "<svg/>");
    ASSERT_TRUE(files_.check().ok());
  }
  void add(std::string_view path, std::string bytes) {
    const auto added = files_.add(path, std::move(bytes));
    ASSERT_TRUE(added.ok()) << added.error().detail();
  }
  std::string refusal(std::string_view path, std::string bytes = {}) {
    const auto added = files_.add(path, std::move(bytes));
    return added ? "accepted" : added.error().detail();
  }
  // The form that is sent to a client that accepts these codings.
  std::string_view form(const std::string& codings) {
    return files_.answer(get_coded("/" + kScript, codings)).stored;
  }

  ConsoleFiles files_;
};

TEST_F(ConsoleFilesTest, TheRootIsTheIndex) {
  EXPECT_EQ(files_.answer(get("/")).stored, "<p>page");
  EXPECT_EQ(files_.answer(get("/?x=1")).stored, "<p>page");
  EXPECT_EQ(files_.answer(get("/index.html")).stored, "<p>page");
  EXPECT_EQ(files_.answer(get("/icons/robot.svg")).stored, "<svg/>");
  EXPECT_EQ(files_.size(), 3U);
  EXPECT_EQ(files_.bytes(), 7U + 5 + 6 + 4 + 6);
}

// Nothing is decoded or resolved: there is no other spelling of a path.
TEST_F(ConsoleFilesTest, OnlyEqualPathsMatch) {
  for (const auto* path : {"",
                           "*",
                           "index.html",
                           "//",
                           "/./index.html",
                           "/../index.html",
                           "/icons/../index.html",
                           "/%69ndex.html",
                           "/%2e%2e/index.html",
                           "/..%2findex.html",
                           "/index.html/",
                           "/INDEX.HTML",
                           "/icons",
                           "/icons/",
                           "/icons//robot.svg",
                           "/icons\\robot.svg",
                           "/etc/passwd",
                           "/main-A1B2C3D4.js.br",
                           "/main-A1B2C3D4.js.gz",
                           "http://127.0.0.1/index.html"})
    EXPECT_FALSE(files_.has(path)) << path;
  EXPECT_FALSE(files_.has(std::string_view("/index.html\0", 12)));
}

TEST_F(ConsoleFilesTest, TypesFollowTheName) {
  EXPECT_EQ(files_.answer(get("/")).type, "text/html; charset=utf-8");
  EXPECT_EQ(files_.answer(get("/" + kScript)).type, "text/javascript; charset=utf-8");
  EXPECT_EQ(files_.answer(get_coded("/" + kScript, "br")).type, "text/javascript; charset=utf-8");
  EXPECT_EQ(files_.answer(get("/icons/robot.svg")).type, "image/svg+xml");
  add("a.css", "");
  add("b.unknown", "");
  add("main-A1B2C3D4.js.LEGAL.txt", "");
  EXPECT_EQ(files_.answer(get("/a.css")).type, "text/css; charset=utf-8");
  EXPECT_EQ(files_.answer(get("/b.unknown")).type, "application/octet-stream");
  EXPECT_EQ(files_.answer(get("/main-A1B2C3D4.js.LEGAL.txt")).type, kTextType);
}

TEST_F(ConsoleFilesTest, TheBestAcceptedFormIsSent) {
  for (const auto* codings :
       {"br", "gzip, deflate, br, zstd", "BR", "gzip,br;q=0.1", "*", " br ;q=1.000 ", "br;q=1,br"})
    EXPECT_EQ(form(codings), "brotli") << codings;
  for (const auto* codings : {"gzip", "gzip, br;q=0", "br;q=0.000, *", "gzip;q=0.001", "x, GZIP"})
    EXPECT_EQ(form(codings), "gzip") << codings;
  for (const auto* codings : {"", "identity", "deflate", "*;q=0", "br;q=0, gzip;q=0.0", "brotli",
                              "gzipbr", ";", ",,", "br;q=0,*;q=0"})
    EXPECT_EQ(form(codings), "plain") << codings;
  EXPECT_EQ(files_.answer(get("/" + kScript)).stored, "plain");
  EXPECT_EQ(files_.answer(get_coded("/", "br, gzip")).stored, "<p>page");
  const Fields two{{"accept-encoding", "gzip"}, {"Accept-Encoding", "br"}};
  EXPECT_EQ(files_.answer(get("/" + kScript, two)).stored, "brotli");
}

TEST_F(ConsoleFilesTest, AFormStatesItsCoding) {
  EXPECT_THAT(std::string(files_.answer(get_coded("/" + kScript, "br")).field),
              HasSubstr("Content-Encoding: br\r\n"));
  EXPECT_THAT(std::string(files_.answer(get_coded("/" + kScript, "gzip")).field),
              HasSubstr("Content-Encoding: gzip\r\n"));
  const std::string plain(files_.answer(get("/" + kScript)).field);
  EXPECT_THAT(plain, Not(HasSubstr("Content-Encoding")));
  EXPECT_THAT(plain, HasSubstr("Vary: Accept-Encoding\r\n"));
}

TEST_F(ConsoleFilesTest, OnlyNamesWithAHashAreKept) {
  EXPECT_EQ(files_.answer(get("/" + kScript)).cache, "public, max-age=31536000, immutable");
  for (const auto* path : {"main-a1b2c3d4.js", "main-A1B2C3D.js", "mainA1B2C3D4.js", "-A1B2C3D4-/x",
                           "main-A1B2C3D45.js", "main.A1B2C3D4.js"})
    if (files_.add(path, "").ok()) {
      EXPECT_EQ(files_.answer(get("/" + std::string(path))).cache, "no-cache") << path;
    }
  EXPECT_EQ(files_.answer(get("/")).cache, "no-cache");
  add("chunks/plots-ABCDEFGH.js", "");
  EXPECT_THAT(std::string(files_.answer(get("/chunks/plots-ABCDEFGH.js")).cache),
              HasSubstr("immutable"));
}

std::string tag_of(const HttpResponse& response) {
  const std::string fields(response.field);
  const std::size_t at = fields.find("ETag: ") + 6;
  return fields.substr(at, fields.find("\r\n", at) - at);
}

TEST_F(ConsoleFilesTest, AKnownFileIsNotSentAgain) {
  const std::string tag = tag_of(files_.answer(get("/")));
  EXPECT_THAT(tag, testing::MatchesRegex("\"[0-9a-f]{16}-7\""));
  for (const std::string& tags :
       {tag, "W/" + tag, "\"x\", " + tag, tag + ",\"x\"", std::string("*")}) {
    const HttpResponse response = files_.answer(get("/", {{"if-none-match", tags}}));
    EXPECT_EQ(response.status, 304) << tags;
    EXPECT_EQ(response.stored, "");
    EXPECT_EQ(tag_of(response), tag);
    const std::string bytes = to_bytes(response, {});
    EXPECT_THAT(bytes, testing::StartsWith("HTTP/1.1 304 Not Modified\r\n"));
    EXPECT_THAT(bytes, Not(HasSubstr("Content-Length")));
    EXPECT_THAT(bytes, testing::EndsWith("\r\n\r\n"));
  }
  for (const std::string& tags :
       {std::string(), std::string("x"), tag.substr(1), "w/" + tag, '"' + tag, std::string("\"\"")})
    EXPECT_EQ(files_.answer(get("/", {{"If-None-Match", tags}})).status, 200) << tags;
}

TEST_F(ConsoleFilesTest, TagsDifferByBytesAndForm) {
  const std::string brotli = tag_of(files_.answer(get_coded("/" + kScript, "br")));
  const Fields plain_with_brotli_tag{{"If-None-Match", brotli}};
  EXPECT_EQ(files_.answer(get("/" + kScript, plain_with_brotli_tag)).status, 200);
  add("a.txt", "a");
  add("b.txt", "b");
  EXPECT_NE(tag_of(files_.answer(get("/a.txt"))), tag_of(files_.answer(get("/b.txt"))));
}

TEST_F(ConsoleFilesTest, EveryFileIsProtected) {
  const Fields known{{"If-None-Match", "*"}};
  for (const HttpRequest& request : {get("/"), get("/" + kScript), get("/", known)}) {
    const std::string bytes = to_bytes(files_.answer(request), {});
    for (const auto* field :
         {"Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; "
          "img-src 'self' blob: data:; connect-src 'self'; worker-src 'self'; font-src 'self'; "
          "manifest-src 'self'; "
          "base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n",
          "X-Content-Type-Options: nosniff\r\n", "Referrer-Policy: no-referrer\r\n",
          "Cross-Origin-Opener-Policy: same-origin\r\n",
          "Cross-Origin-Resource-Policy: same-origin\r\n"})
      EXPECT_THAT(bytes, HasSubstr(field));
  }
}

TEST_F(ConsoleFilesTest, OddNamesAreRefused) {
  for (const auto* path : {"", "/", "/a", "a/", "a//b", ".", "..", "../a", "a/../b", ".hidden",
                           "a/.b", "a b", "a%20b", "a\\b", "a\nb", "-a", "ä.js", "a?b", "a#b"})
    EXPECT_THAT(refusal(path), HasSubstr("other characters")) << path;
  EXPECT_THAT(refusal("index.html"), HasSubstr("added twice"));
  EXPECT_THAT(refusal(kScript + ".br"), HasSubstr("added twice"));
  EXPECT_EQ(refusal("a/b_c-d.e.js"), "accepted");
}

TEST_F(ConsoleFilesTest, ACompressedFormAloneIsRefused) {
  add("other.js.br", "x");
  EXPECT_THAT(files_.check().error().detail(), HasSubstr("other.js: only a compressed form"));
  add("other.js", "x");
  EXPECT_TRUE(files_.check().ok());
}

TEST(ConsoleFiles, AFolderWithoutAnIndexIsRefused) {
  ConsoleFiles files;
  EXPECT_THAT(files.check().error().detail(), HasSubstr("index.html"));
  ASSERT_TRUE(files.add("main.js", "").ok());
  EXPECT_THAT(files.check().error().detail(), HasSubstr("index.html"));
}

TEST(ConsoleFiles, TheNumberOfFilesIsBounded) {
  ConsoleFiles files;
  for (std::size_t i = 0; i < ConsoleFiles::kFilesMax; ++i)
    ASSERT_TRUE(files.add("f" + std::to_string(i), "x").ok()) << i;
  EXPECT_TRUE(files.add("f0.br", "x").ok());  // not one more file
  const auto more = files.add("more", "");
  ASSERT_FALSE(more.ok());
  EXPECT_THAT(more.error().detail(), HasSubstr("more: there are more than 64 files"));
}

TEST(ConsoleFiles, TheBytesAreBounded) {
  ConsoleFiles files;
  ASSERT_TRUE(files.add("a", std::string(ConsoleFiles::kBytesMax - 10, 'x')).ok());
  ASSERT_TRUE(files.add("b", std::string(9, 'x')).ok());
  const auto more = files.add("c", "xx");
  ASSERT_FALSE(more.ok());
  EXPECT_THAT(more.error().detail(), HasSubstr("c: with it, the files have more than 4194304"));
  EXPECT_TRUE(files.add("d", "x").ok());
  EXPECT_EQ(files.bytes(), ConsoleFiles::kBytesMax);
  EXPECT_FALSE(files.add("e", "x").ok());
  EXPECT_TRUE(files.add("f", "").ok());
}

TEST(ConsoleFiles, WithoutOneAPageStatesTheReason) {
  const ConsoleFiles files = ConsoleFiles::without_console("/x/<b>&: No such file");
  ASSERT_TRUE(files.has("/"));
  const HttpResponse page = files.answer(get("/"));
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.type, "text/html; charset=utf-8");
  EXPECT_THAT(std::string(page.stored), HasSubstr("/x/&lt;b>&amp;: No such file"));
  EXPECT_THAT(std::string(page.stored), HasSubstr("tools/dev build"));
  EXPECT_THAT(std::string(page.field), HasSubstr("Content-Security-Policy: default-src 'none'"));
}

}  // namespace console_files_test
}  // namespace tims::io
