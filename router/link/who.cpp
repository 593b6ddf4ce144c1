#include "router/link/who.h"

namespace tims::link {

void put(ByteWriter& out, const Identity& who) {
  out.put(who.epoch);
  out.put(static_cast<std::uint8_t>(who.role));
  out.put(who.system);
  out.put(who.id);
  out.put(static_cast<std::uint8_t>(who.name.view().size()));
  out.put(who.widths.system);
  out.put(who.widths.class_id);
  out.put(who.widths.instance);
  out.put(who.widths.local);
  out.put(who.message_max);
  for (const std::uint8_t first : who.classes.from) out.put(first);
  out.put_text(who.name.view());
}

bool get(ByteReader& in, Identity& who) {
  who.epoch = in.get<std::uint64_t>();
  const bool role_known = get_enum(in, Role::kTop, who.role);
  who.system = in.get<std::uint8_t>();
  who.id = in.get<std::uint8_t>();
  const auto name_size = in.get<std::uint8_t>();
  who.widths = {in.get<std::uint8_t>(), in.get<std::uint8_t>(), in.get<std::uint8_t>(),
                in.get<std::uint8_t>()};
  who.message_max = in.get<std::uint32_t>();
  for (std::uint8_t& first : who.classes.from) first = in.get<std::uint8_t>();
  who.name = in.text(name_size);
  return in.ok() && role_known && who.widths.valid() && who.classes.valid() && who.epoch != 0;
}

}  // namespace tims::link
