#include "rack/proxies/catalogue.h"

#include <algorithm>

#include "proxies/body_info.h"
#include "proxies/catalogue_tables.h"
#include "rack/proxies/generic.h"

namespace rack {

namespace {

namespace type = tims::type;

constexpr MessageInfo kFramework[] = {
    {kEveryClass, type::kOk, "OK"},
    {kEveryClass, type::kError, "ERROR"},
    {kEveryClass, type::kTimeout, "TIMEOUT"},
    {kEveryClass, type::kNotAvailable, "NOT_AVAILABLE"},
    {kEveryClass, type::kEnabled, "ENABLED"},
    {kEveryClass, type::kDisabled, "DISABLED"},
    {kEveryClass, type::kContData, "CONT_DATA", kBody<ContDataReply>},
    {kEveryClass, type::kParam, "PARAM", kBody<ParameterList>},
    {kEveryClass, type::kParamEffects, "PARAM_EFFECTS", kBody<ParameterEffects>},
    {kEveryClass, type::kRuntime, "RUNTIME", kBody<RuntimeData>},
    {kEveryClass, type::kListeners, "LISTENERS", kBody<ListenersData>},
    {kEveryClass, type::kOn, "ON"},
    {kEveryClass, type::kOff, "OFF"},
    {kEveryClass, type::kGetStatus, "GET_STATUS"},
    {kEveryClass, type::kGetData, "GET_DATA", kBody<GetDataRequest>},
    {kEveryClass, type::kGetContData, "GET_CONT_DATA", kBody<GetContDataRequest>},
    {kEveryClass, type::kStopContData, "STOP_CONT_DATA", kBody<StopContDataRequest>},
    {kEveryClass, type::kGetNextData, "GET_NEXT_DATA"},
    {kEveryClass, type::kGetParam, "GET_PARAM"},
    {kEveryClass, type::kSetParam, "SET_PARAM", kBody<ParameterList>},
    {kEveryClass, type::kGetParamEffects, "GET_PARAM_EFFECTS"},
    {kEveryClass, type::kGetRuntime, "GET_RUNTIME"},
    {kEveryClass, type::kGetListeners, "GET_LISTENERS"},
};

// Not std::toupper: it depends on the locale.
char upper(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c & ~0x20) : c; }

// Of the class, else of the framework.
template <typename Fits>
const MessageInfo* find(u32 class_id, const Fits& fits) {
  for (const u32 of_class : {class_id, kEveryClass}) {
    for (const auto table : message_tables()) {
      const auto found = std::ranges::find_if(
          table, [&](const MessageInfo& m) { return m.class_id == of_class && fits(m); });
      if (found != table.end()) return &*found;
    }
  }
  return nullptr;
}

}  // namespace

std::array<std::span<const MessageInfo>, 4> message_tables() {
  return {kFramework, driver_messages(), perception_messages(), navigation_messages()};
}

const MessageInfo* find_message(u32 class_id, i8 type) {
  return find(class_id, [&](const MessageInfo& m) { return m.type == type; });
}

const MessageInfo* find_message(u32 class_id, std::string_view name) {
  const auto same = [](char a, char b) { return upper(a) == upper(b); };
  return find(class_id,
              [&](const MessageInfo& m) { return std::ranges::equal(m.name, name, same); });
}

const MessageInfo* find_message(const tims::Header& header, const tims::AddressWidths& widths) {
  if (header.dest == tims::Address() && header.src == tims::Address()) return nullptr;
  const u32 sender = header.src.fields(widths).class_id;
  if (header.type <= 0) return find_message(sender, header.type);
  const MessageInfo* found = find_message(header.dest.fields(widths).class_id, header.type);
  // Some classes have replies with positive numbers.
  return found != nullptr ? found : find_message(sender, header.type);
}

}  // namespace rack
