#include "router/io/admin_actions.h"

#include <vector>

namespace tims::io {
namespace {

using link::Links;

Links::Hand hand_of(std::string_view action) {
  if (action == "up") return Links::Hand::kUp;
  return action == "down" ? Links::Hand::kDown : Links::Hand::kReset;
}

std::string change_routes(const Question& question, const AdminSource& source) {
  std::vector<core::StaticRoute> routes = source.router().static_routes();
  const std::size_t gone = std::erase_if(routes, [&](const core::StaticRoute& route) {
    return route.text.view() == question.pattern &&
           (question.link.empty() || route.via.view() == question.link);
  });
  if (question.ask == Ask::kRouteAdd) {
    if (question.link.empty()) return "\"via\" is missing: the name of a router on a link";
    if (routes.size() >= kStaticRoutesMax)
      return "there are " + std::to_string(kStaticRoutesMax) + " static routes already";
    routes.push_back(
        {question.match, std::string_view(question.pattern), std::string_view(question.link)});
  } else if (gone == 0) {
    return "no static route for \"" + question.pattern + "\"";
  }
  source.set_static_routes(routes);
  return {};
}

}  // namespace

std::string carry_out(const Question& question, const AdminSource& source) {
  switch (question.ask) {
    case Ask::kLinkDo:
      return source.act_on_link(question.link, hand_of(question.action));
    case Ask::kFault:
      return source.spoil(question.link, question.faults);
    default:
      return change_routes(question, source);
  }
}

}  // namespace tims::io
