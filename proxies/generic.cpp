#include "rack/proxies/generic.h"

#include <algorithm>
#include <array>

namespace rack {

std::string_view reason_of(std::span<const std::byte> body) {
  const std::string_view text(reinterpret_cast<const char*>(body.data()), body.size());
  return text.substr(0, text.find('\0'));
}

std::string_view name(Status status) {
  switch (status) {
    case Status::kEnabled:
      return "enabled";
    case Status::kDisabled:
      return "disabled";
    case Status::kError:
      return "error";
  }
  return "unknown";
}

std::string_view name(TakesEffect when) {
  constexpr std::array<std::string_view, 3> kNames = {"now", "at the next ON",
                                                      "when its program starts again"};
  const auto i = static_cast<std::size_t>(when);
  return i < kNames.size() ? kNames[i] : "unknown";
}

std::string_view name(WatchDepth depth) {
  constexpr std::array<std::string_view, 4> kNames = {"off", "counts", "places of page faults",
                                                      "places"};
  const auto i = static_cast<std::size_t>(depth);
  return i < kNames.size() ? kNames[i] : "unknown";
}

// --- pages of a description

tims::Result<DescriptionPage> page_of(std::string_view description,
                                      const DescriptionRequest& request) {
  const auto size = static_cast<i64>(description.size());
  if (request.offset < 0 || request.offset > size || request.bytesMax < 0)
    return tims::Error(tims::Errc::kInvalidArgument,
                       "the description has " + std::to_string(size) + " bytes, requested are " +
                           std::to_string(request.bytesMax) + " from byte " +
                           std::to_string(request.offset) + " on");
  constexpr std::size_t kMost = decltype(DescriptionPage::text)::kMax;
  const auto wanted = static_cast<std::size_t>(request.bytesMax);
  const std::string_view text = description.substr(static_cast<std::size_t>(request.offset),
                                                   wanted == 0 ? kMost : std::min(wanted, kMost));
  DescriptionPage page{.size = static_cast<i32>(size), .offset = request.offset};
  page.text.assign(text.begin(), text.end());
  return page;
}

tims::Result<bool> append_page(std::string& description, const DescriptionPage& page) {
  const auto wrong = [](std::string_view why) {
    return tims::Error(tims::Errc::kMalformed,
                       "the description is not usable: " + std::string(why) +
                           "; its sender is broken, or has another version of it");
  };
  if (page.size < 0 || static_cast<std::size_t>(page.size) > kDescriptionMax)
    return wrong(std::to_string(page.size) + " bytes, allowed are up to " +
                 std::to_string(kDescriptionMax));
  const auto size = static_cast<std::size_t>(page.size);
  if (page.offset < 0 || static_cast<std::size_t>(page.offset) != description.size())
    return wrong("a page from byte " + std::to_string(page.offset) + " on, expected was " +
                 std::to_string(description.size()));
  if (description.size() + page.text.size() > size) return wrong("a page is longer than the rest");
  if (page.text.empty() && description.size() < size) return wrong("an empty page");
  description.append(page.text.data(), page.text.size());
  return description.size() < size;
}

}  // namespace rack
