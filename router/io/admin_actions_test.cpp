#include "router/io/admin_actions.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace tims::io {
namespace admin_actions_test {

TEST(ReloadRoutes, KeepsWhatPeopleHaveChanged) {
  const auto route = [](std::string_view match, std::string_view via) {
    return core::StaticRoute{.match = {}, .text = match, .via = via};
  };
  const auto as_text = [](const std::vector<core::StaticRoute>& routes) {
    std::string text;
    for (const auto& r : routes) text += fmt::format("{}>{} ", r.text.view(), r.via.view());
    return text;
  };
  const auto a = route("a", "x");
  const auto b = route("b", "x");
  const auto c = route("c", "x");
  const auto b_elsewhere = route("b", "y");
  EXPECT_EQ(as_text(reload_routes({a, b, c}, {a, b}, {a, b})), "a>x b>x c>x ") << "c was added";
  EXPECT_EQ(as_text(reload_routes({a, c}, {a, b}, {a, b})), "a>x c>x ") << "b was deleted";
  EXPECT_EQ(as_text(reload_routes({a, b, c}, {a, b}, {b_elsewhere})), "b>y c>x ");
  EXPECT_EQ(as_text(reload_routes({a, b, c}, {a, b}, {c, a})), "c>x a>x ") << "once";
  EXPECT_EQ(as_text(reload_routes({}, {}, {a, b})), "a>x b>x ");
}

}  // namespace admin_actions_test
}  // namespace tims::io
