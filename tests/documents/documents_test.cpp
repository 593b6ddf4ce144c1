// The configuration files in documents are accepted by their readers, and every code block is used
// by some test: here, or by a plan of `follow`.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/vision/marker_map.h"
#include "proxies/message_files.h"
#include "router/config/load.h"
#include "tools/robot/robot_file.h"
#include "tools/sim/fleet_file.h"

namespace tims::test {
namespace documents_test {

namespace fs = std::filesystem;

struct Block {
  std::string document;  // relative to the sources
  std::string language;
  std::string text;
};

std::string text_of(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

void add_blocks(const std::string& document, const std::string& text, std::vector<Block>& blocks) {
  constexpr std::string_view kFence = "```";
  std::size_t at = text.find("\n```");
  while (at != std::string::npos) {
    const std::size_t language = at + 1 + kFence.size();
    const std::size_t first = text.find('\n', language) + 1;
    const std::size_t end = text.find("```", first);
    ASSERT_NE(end, std::string::npos) << document << ": a block does not end";
    blocks.push_back(
        {document, text.substr(language, first - 1 - language), text.substr(first, end - first)});
    at = text.find("\n```", end + kFence.size());
  }
}

// All blocks with a language of all documents of the sources.
std::vector<Block> all_blocks() {
  std::vector<Block> blocks;
  for (auto entry = fs::recursive_directory_iterator(TIMS_SOURCES); entry != fs::end(entry);
       ++entry) {
    const std::string name = entry->path().filename();
    if (entry->is_directory() &&
        (name == "build" || name == "node_modules" || name.starts_with('.')))
      entry.disable_recursion_pending();
    if (entry->is_regular_file() && name.ends_with(".md"))
      add_blocks(fs::relative(entry->path(), TIMS_SOURCES), text_of(entry->path()), blocks);
  }
  std::erase_if(blocks, [](const Block& block) { return block.language.empty(); });
  return blocks;
}

template <typename Problems>
std::string texts_of(const Problems& problems) {
  std::string all;
  for (const auto& problem : problems) all += problem.to_string() + "\n";
  return all;
}

// Empty, or what is wrong.
using Reader = std::function<std::string(const std::string&)>;

// A part of a router's file: of a fleet.
std::string read_router_part(const std::string& text) {
  const std::string fleet =
      "[router]\nrole = \"system\"\nsystem = 1\n[security]\ninsecure = true\n"
      "[fleet]\nname = \"harbour\"\n";
  return texts_of(
      config::load({{{"router.toml", fleet + text}}, {}, {.name = "robot1", .environment = {}}})
          .problems);
}

std::map<std::string, Reader> readers() {
  return {
      {"components/vision/README.md",
       [](const std::string& text) {
         return texts_of(rack::vision::read_marker_map({"markers.toml", text}).problems);
       }},
      {"deploy/fleets/README.md",
       [](const std::string& text) {
         return texts_of(timsctl::sim::read_fleet({"fleet.toml", text}).problems);
       }},
      {"deploy/robots/README.md",
       [](const std::string& text) {
         return texts_of(timsctl::robot::read_robot({"scout.toml", text}, "scout", {}).problems);
       }},
      {"docs/deploying.md",
       [](const std::string& text) {
         return texts_of(timsctl::robot::read_robot({"scout.toml", text}, "scout", {}).problems);
       }},
      {"docs/operating.md", read_router_part},
      {"docs/security.md", read_router_part},
      {"proxies/README.md",
       [](const std::string& text) {
         const auto read = rack::MessageFile::parse(text);
         return read ? std::string() : read.error().detail();
       }},
  };
}

TEST(Documents, ConfigurationFilesInThemAreAccepted) {
  const auto known = readers();
  std::map<std::string, int> read;
  for (const Block& block : all_blocks()) {
    if (block.language != "toml" && block.language != "json") continue;
    const auto reader = known.find(block.document);
    ASSERT_NE(reader, known.end()) << block.document << ": add the reader of this file to the test";
    EXPECT_EQ(reader->second(block.text), "") << block.document << "\n" << block.text;
    ++read[block.document];
  }
  EXPECT_EQ(read.size(), known.size()) << "a document of the test has no such block";
}

// Code and commands: the documents that a plan follows.
TEST(Documents, CodeInThemIsFollowed) {
  std::string plans;
  for (const auto& entry : fs::directory_iterator(TIMS_SOURCES "/tests/documents"))
    if (entry.path().extension() == ".toml") plans += text_of(entry.path());
  int followed = 0;
  for (const Block& block : all_blocks()) {
    if (block.language == "toml" || block.language == "json") continue;
    EXPECT_THAT(plans, testing::HasSubstr("\"" + block.document + "\""))
        << "has " << block.language << " code: name it in a plan of tests/documents";
    ++followed;
  }
  EXPECT_GE(followed, 12);
}

}  // namespace documents_test
}  // namespace tims::test
