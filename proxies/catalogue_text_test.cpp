#include "proxies/catalogue_text.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>

#include <gtest/gtest.h>

#include "proxies/struct_json.h"
#include "proxies/value_names.h"

namespace rack {
namespace catalogue_text_test {

// The console is built without a compiler for C++, so its files are kept in the repository.
void expect_in_console(const std::string& file, const std::string& text,
                       const std::string& option) {
  const std::string path = std::string(CONSOLE_CODEC_DIR "/") + file;
  std::ifstream stream(path);
  const std::string there{std::istreambuf_iterator<char>(stream), {}};
  // Not EXPECT_EQ, which would print both files.
  EXPECT_TRUE(there == text) << "the messages have changed. Renew the console's copy:\n"
                             << "  build/release/bin/tims-schema" << option << " > " << path;
}

TEST(CatalogueText, TheConsoleHasTheSameMessages) {
  expect_in_console("schema.json", catalogue_json(), "");
  expect_in_console("messages.ts", catalogue_types(), " --types");
}

TEST(CatalogueText, DescribesTails) {
  const std::string json = catalogue_json();
  EXPECT_NE(json.find(R"({"name": "occupancy", "type": "u8", "tail_at_most": 250000})"),
            std::string::npos);
  EXPECT_NE(
      json.find(R"({"name": "vx", "type": "i32", "unit": "mm/s", "si_unit": "m/s", "si": 0.001})"),
      std::string::npos);
}

TEST(CatalogueText, NamesOfNumbersBelongToFields) {
  StructsThere there;
  std::string ignored;
  for (const Schema* schema : own_bodies()) append_struct(ignored, there, *schema);
  for (const FieldValues& values : field_values()) {
    const auto exists = [&](const Schema* schema) {
      return std::ranges::any_of(schema->fields, [&](const SchemaField& field) {
        return values.field == std::string(schema->name) + "." + std::string(field.name);
      });
    };
    EXPECT_TRUE(std::ranges::any_of(there, exists)) << values.field;
  }
  const std::string json = catalogue_json();
  EXPECT_NE(json.find(R"({"field": "GpsData.mode", "names": {"invalid": 0, "2D": 1, "3D": 2}, )"
                      R"("flags": {"differential": 16, "estimated": 32}})"),
            std::string::npos);
}

TEST(CatalogueText, TypesOfEveryKindOfField) {
  const std::string types = catalogue_types();
  for (const auto* expected :
       {"  image: Uint8Array;\n", "  pointNum?: number;\n", "  points: LadarPoint[];\n",
        "  pageFaults: Integer64;\n", "  name: string;\n", "  vx: number; // mm/s\n",
        "  'Chassis.MOVE': ChassisMoveData;\n", "  'GET_STATUS': undefined;\n"})
    EXPECT_NE(types.find(expected), std::string::npos) << expected;
}

struct Vector {
  std::string name;
  std::string order;
  std::string body;
  std::string result;
};

std::vector<Vector> vectors() {
  std::vector<Vector> found;
  std::istringstream lines(catalogue_vectors(1));
  for (Vector v;
       lines >> v.name >> v.order >> v.body && lines.ignore() && std::getline(lines, v.result);)
    found.push_back(v);
  return found;
}

TEST(CatalogueVectors, AreTheSameForTheSameSeed) {
  EXPECT_TRUE(catalogue_vectors(1) == catalogue_vectors(1));
  EXPECT_FALSE(catalogue_vectors(1) == catalogue_vectors(2));
}

TEST(CatalogueVectors, ContainEveryStructInBothOrdersAndDamagedBodies) {
  std::set<std::pair<std::string, std::string>> seen;
  std::size_t refused = 0;
  for (const Vector& v : vectors()) {
    seen.emplace(v.name, v.order);
    if (v.result.starts_with('!')) {
      ++refused;
    } else {
      EXPECT_TRUE(v.result.starts_with('{')) << v.result;
    }
  }
  for (const Schema* schema : own_bodies())
    for (const char* order : {"little", "big"})
      EXPECT_TRUE(seen.contains({std::string(schema->name), order})) << schema->name;
  EXPECT_GT(refused, 100U);
}

}  // namespace catalogue_text_test
}  // namespace rack
