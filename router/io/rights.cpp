#include "router/io/rights.h"

#include <algorithm>
#include <array>
#include <variant>

#include "router/io/admin_question.h"
#include "tims/message.h"

namespace tims::io {
namespace {

// Types that only ask. All others may change something.
constexpr std::array kReadingTypes{
    type::kGetStatus,   type::kGetData,     type::kGetContData,    type::kStopContData,
    type::kGetNextData, type::kGetParam,    type::kGetDescription, type::kGetParamEffects,
    type::kGetRuntime,  type::kGetListeners};

// The same of single classes (proxies), a range each.
struct ReadingTypes {
  std::uint32_t class_id;
  std::int8_t first;
  std::int8_t last;
};
constexpr std::array kReadingOfClass{
    ReadingTypes{class_id::kGdos, 21, 22},        // GET_LOG, GET_TEXTS
    ReadingTypes{class_id::kChassis, 22, 22},     // GET_PARAMETER
    ReadingTypes{class_id::kPosition, 22, 27},    // WGS84_TO_POS to POS_TO_UTM
    ReadingTypes{class_id::kCamera, 21, 21},      // GET_PARAMETER
    ReadingTypes{class_id::kPilot, 24, 24},       // GET_STATUS
    ReadingTypes{class_id::kDatalog, 23, 23},     // GET_LOG_STATUS
    ReadingTypes{class_id::kScan3d, 21, 21},      // GET_RANGE_IMAGE
    ReadingTypes{class_id::kPlanner, 22, 22},     // GET_COMMAND
    ReadingTypes{class_id::kFeatureMap, 27, 27},  // GET_LAYER
    ReadingTypes{class_id::kPath, 25, 26},        // GET_DBG_GRIDMAP, GET_LAYER
    ReadingTypes{0x7F, 26, 26},                   // GET_LINES of a simulated world
};

bool only_reads(std::int8_t type, std::uint32_t class_id) {
  if (std::ranges::find(kReadingTypes, type) != kReadingTypes.end()) return true;
  return std::ranges::any_of(kReadingOfClass, [&](const ReadingTypes& reading) {
    return reading.class_id == class_id && reading.first <= type && type <= reading.last;
  });
}

// What this router cannot read changes nothing here: its answer explains the error. Another one may
// understand it.
Effect effect_of(const SentMessage& question, const AddressWidths& widths) {
  const auto read = parse_question(question.body, widths);
  if (const auto* parsed = std::get_if<Question>(&read)) return effect(parsed->ask);
  return question.to_other ? Effect::kChanges : Effect::kNone;
}

Right needed_for_question(const SentMessage& question, const AddressWidths& widths) {
  switch (effect_of(question, widths)) {
    case Effect::kChanges:
      return Right::kConfigure;
    case Effect::kDrives:
      return Right::kDrive;
    case Effect::kNone:
    case Effect::kLogin:
      break;
  }
  return Right::kLook;
}

}  // namespace

std::string_view name(Right right) {
  switch (right) {
    case Right::kNone:
      break;
    case Right::kLook:
      return "look";
    case Right::kDrive:
      return "drive";
    case Right::kConfigure:
      return "configure";
  }
  return "none";
}

std::optional<Right> right_of(std::string_view text) {
  for (const Right right : {Right::kLook, Right::kDrive, Right::kConfigure})
    if (text == name(right)) return right;
  return std::nullopt;
}

bool has(const security::Rights& rights, Right right) { return highest(rights) >= right; }

Right highest(const security::Rights& rights) {
  if (rights.configure) return Right::kConfigure;
  if (rights.drive) return Right::kDrive;
  return rights.look ? Right::kLook : Right::kNone;
}

security::Rights rights_up_to(Right right) {
  return {.look = right >= Right::kLook,
          .drive = right >= Right::kDrive,
          .configure = right >= Right::kConfigure};
}

Right needed_for(const SentMessage& sent, const AddressWidths& widths) {
  if (sent.to_agent) return is_agent_reading(sent.body) ? Right::kLook : Right::kConfigure;
  if (sent.type == type::kAdminRequest) return needed_for_question(sent, widths);
  if (sent.to_router) return Right::kLook;
  if (sent.type == type::kSetParam) return Right::kConfigure;
  return only_reads(sent.type, sent.class_id) ? Right::kLook : Right::kDrive;
}

policy::Right asked_of(const SentMessage& question, const AddressWidths& widths) {
  using To = policy::Right;
  if (question.to_agent && is_agent_agreeing(question.body)) return To::kAgree;
  if (question.to_agent) return is_agent_reading(question.body) ? To::kLook : To::kChange;
  switch (effect_of(question, widths)) {
    case Effect::kChanges:
      return To::kChange;
    case Effect::kLogin:
      return To::kLogin;
    case Effect::kDrives:
      return To::kDrive;
    case Effect::kNone:
      break;
  }
  return To::kLook;
}

SentMessage SentMessage::of(const core::Message& message, const core::RouterSettings& settings) {
  const Address dest = message.header.dest;
  const auto fields = dest.fields(settings.widths);
  const bool is_router = fields.class_id == settings.address.fields(settings.widths).class_id;
  const auto body = message.body();
  return {.type = message.header.type,
          .to_router = dest == Address() || (is_router && fields.local == 0),
          .to_agent = is_router && fields.local != 0,
          .to_other = dest != Address() && dest != settings.address,
          .class_id = fields.class_id,
          // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): bytes as the text they are
          .body = {reinterpret_cast<const char*>(body.data()), body.size()}};
}

Person person_of(const security::Identity& identity, const security::Certificate& certificate,
                 const security::Identity& own) {
  using security::MemberRole;
  Person person{.name = identity.name, .certificate = certificate};
  if (identity.role == MemberRole::kUser)
    person.rights = identity.rights;
  else if (identity.role == MemberRole::kTop)
    person.rights = rights_up_to(Right::kConfigure);
  else
    person.rights = rights_up_to(identity.system == own.system ? Right::kDrive : Right::kLook);
  if (identity.role != MemberRole::kUser)
    person.proven.add(policy::kind::kRouter, identity.name)
        .add(policy::kind::kSystem, identity.system)
        .add(policy::kind::kRole, security::name(identity.role));
  return person;
}

}  // namespace tims::io
