// Bodies written by original programs are decoded, encoded again to the same bytes, and encoded in
// the other byte order as the original C and Java programs do.
#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "base/text.h"
#include "rack/codec/message_text.h"
#include "rack/proxies/catalogue.h"
#include "tests/support/golden_vectors.h"

namespace tims::test {
namespace body_vectors_test {

using rack::find_message;
using rack::MessageInfo;

// Messages to routers and to the text sink are not messages of components; V90 is corrupt.
bool is_of_component(const GoldenVector& v) {
  const bool of_router = v.stated.dest == Address() && v.stated.src == Address();
  return !of_router && v.stated.dest != Address(0x00010000) && v.name != "V90";
}

std::vector<GoldenVector> component_vectors() {
  auto vectors = read_golden_vectors();
  EXPECT_TRUE(vectors) << vectors.error().message();
  if (!vectors) return {};
  std::erase_if(*vectors, [](const GoldenVector& v) { return !is_of_component(v); });
  return *std::move(vectors);
}

std::string label(const GoldenVector& v) { return v.name + " " + v.origin; }

std::string recoded(const GoldenVector& v, std::endian to) {
  const MessageInfo* message = find_message(v.stated);
  if (message == nullptr || message->body == nullptr) return "no body is known";
  const auto bytes = recode(*message->body, v.body(), v.stated.body_order(), to);
  return bytes ? base::to_hex(*bytes) : bytes.error().message();
}

std::string json(const std::string& name, const std::string& origin) {
  for (const GoldenVector& v : component_vectors()) {
    if (v.name != name || v.origin != origin) continue;
    const auto text = body_json(*find_message(v.stated)->body, v.body(), v.stated.body_order(), {});
    return text ? *text : text.error().message();
  }
  return "no such vector";
}

TEST(GoldenBodies, AreAllKnown) {
  std::size_t bodies = 0;
  for (const GoldenVector& v : component_vectors()) {
    const MessageInfo* message = find_message(v.stated);
    ASSERT_NE(message, nullptr) << label(v);
    EXPECT_EQ(message->body == nullptr, v.body().empty()) << label(v) << " " << message->name;
    bodies += v.body().empty() ? 0 : 1;
  }
  EXPECT_EQ(bodies, 46U);
}

TEST(GoldenBodies, AreEncodedAgainByteForByte) {
  for (const GoldenVector& v : component_vectors()) {
    if (!v.body().empty()) {
      EXPECT_EQ(recoded(v, v.stated.body_order()), base::to_hex(v.body())) << label(v);
    }
  }
}

TEST(GoldenBodies, CAndJavaDifferOnlyInByteOrder) {
  // The Java encoders of these use other types for some fields (specification, section 16).
  const std::set<std::string> java_differs = {"V51", "V62"};
  std::map<std::string, GoldenVector> of_c;
  int pairs = 0;
  for (const GoldenVector& v : component_vectors()) {
    if (v.body().empty() || java_differs.contains(v.name)) continue;
    if (v.origin == "C") of_c.emplace(v.name, v);
    if (v.origin != "Java" || !of_c.contains(v.name)) continue;
    ++pairs;
    const GoldenVector& c = of_c.at(v.name);
    EXPECT_EQ(recoded(c, std::endian::big), base::to_hex(v.body())) << label(c);
    EXPECT_EQ(recoded(v, std::endian::little), base::to_hex(c.body())) << label(v);
  }
  EXPECT_EQ(pairs, 16);
}

TEST(GoldenBodies, DecodeToTheValuesOfTheSpecification) {
  for (const char* const origin : {"C", "Java"}) {
    EXPECT_EQ(json("V30", origin),
              R"({"recordingTime":123456,"duration":13,"maxRange":8191,"startAngle":-1.5,)"
              R"("endAngle":1.5,"pointNum":3,"points":[)"
              R"({"angle":-1.5,"distance":1000,"type":0,"intensity":0},)"
              R"({"angle":0,"distance":2000,"type":0,"intensity":7},)"
              R"({"angle":1.5,"distance":3000,"type":16,"intensity":14}]})");
    EXPECT_EQ(
        json("V32", origin),
        R"({"recordingTime":123456,"pos":{"x":-250,"y":1250,"z":0,"phi":0,"psi":0,"rho":3}})");
    EXPECT_EQ(json("V60", origin),
              R"({"pos":{"x":1000,"y":-2000,"z":0,"phi":0,"psi":0,"rho":1.5},"speed":300})");
    EXPECT_EQ(json("V23", origin), R"~({"periodTime":200,"dataMbxAdr":"Pilot(0/1):2"})~");
  }
  EXPECT_EQ(json("V40", "C"), R"({"vx":500,"vy":0,"omega":0.25})");
  EXPECT_EQ(json("V62", "C"), R"({"pos":{"x":1,"y":2,"rho":0.5},"speed":1000,"layer":3})");
}

TEST(GoldenBodies, DecodeToTheValuesOfTheModules) {
  EXPECT_EQ(json("M05", "module"),
            R"~({"recordingTime":4205290943,"deltaX":5,"deltaY":0,"deltaRho":0.01,"vx":50,"vy":0,)~"
            R"~("omega":0.1,"battery":0,"activePilot":"GUI(0/1)"})~");
  EXPECT_EQ(json("V35", "Java"),
            R"({"recordingTime":0,"position":{"x":50,"y":-20,"z":0,"phi":0,"psi":0,"rho":0},)"
            R"("buttons":1})");
  EXPECT_EQ(json("V80", "Java"),
            R"~({"recordingTime":0,"logPathName":"/tmp/","logNum":1,"logInfo":[{"logEnable":1,)~"
            R"~("moduleMbx":"Ladar(0/0)","periodTime":100,"maxDataLen":8664,)~"
            R"~("filename":"ladar_0.dat","bytesLogged":0,"setsLogged":0}]})~");
}

}  // namespace body_vectors_test
}  // namespace tims::test
