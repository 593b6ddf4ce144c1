#include "tools/timsctl/config_edit.h"

#include <gtest/gtest.h>

#include "tools/cli/failure.h"

namespace timsctl {
namespace config_edit_test {

TEST(ConfigEdit, TakesAFileOfThisHost) {
  const ConfigEdit edit = parse_config_edit("robots/scout.toml=/tmp/a=b:c.toml");
  EXPECT_EQ(edit.router, "");
  EXPECT_EQ(edit.file, "robots/scout.toml");
  EXPECT_EQ(edit.path, "");
  EXPECT_EQ(edit.source, "/tmp/a=b:c.toml");
}

TEST(ConfigEdit, SetsOrRemovesAValueOnAHost) {
  const ConfigEdit edit = parse_config_edit("arm@router.toml:a.\"b=c\"[1]=x@y:z=1");
  EXPECT_EQ(edit.router, "arm");
  EXPECT_EQ(edit.file, "router.toml");
  EXPECT_EQ(edit.path, "a.\"b=c\"[1]");
  EXPECT_EQ(edit.source, "x@y:z=1");
  EXPECT_EQ(text_at(operation_of(parse_config_edit("f:a=")), "op"), "remove");
}

TEST(ConfigEdit, ValuesAreTomlElseTexts) {
  const auto value = [](const std::string& text) {
    return to_text(operation_of(parse_config_edit("f:a=" + text)).at("value"));
  };
  EXPECT_EQ(value("10"), "10");
  EXPECT_EQ(value("true"), "true");
  EXPECT_EQ(value("debug"), "\"debug\"");
  EXPECT_EQ(value("\"10\""), "\"10\"");
  EXPECT_EQ(value("[1, 2]"), "[1,2]");
  EXPECT_EQ(value("{ a = 1 }"), "{\"a\":1}");
  EXPECT_EQ(value("127.0.0.1:2000"), "\"127.0.0.1:2000\"");
}

TEST(ConfigEdit, OthersAreRefused) {
  for (const std::string wrong : {"", "f", "=x", "f=", "f:", "f:=1", ":a=1"})
    EXPECT_THROW((void)parse_config_edit(wrong), Failure) << wrong;
}

}  // namespace config_edit_test
}  // namespace timsctl
