#include "shm/layout.h"

namespace tims::shm {

MailboxView::MailboxView(std::byte* base, const Geometry& geometry)
    : header_(reinterpret_cast<MailboxHeader*>(base)),
      arrival_(reinterpret_cast<Word64*>(base + geometry.arrival_at)),
      free_(reinterpret_cast<Word64*>(base + geometry.free_at)),
      holders_(reinterpret_cast<Word64*>(base + geometry.holders_at)),
      slots_(base + geometry.slots_at),
      long_(base + geometry.long_at),
      geometry_(geometry) {}

Result<MailboxView> MailboxView::open(std::span<std::byte> mapping, std::uint64_t offset) {
  const auto bad = [](const char* what) { return Error(Errc::kBadLayout, what); };
  if (offset % kMailboxAlign != 0) return bad("the mailbox is not aligned");
  if (offset > mapping.size() || mapping.size() - offset < sizeof(MailboxHeader))
    return bad("the mailbox is outside its segment");
  auto& header = *reinterpret_cast<MailboxHeader*>(mapping.data() + offset);
  if (header.ready.load(std::memory_order_acquire) != kReady) return bad("not ready");
  // Volatile: each field is read exactly once, because the memory may change between two reads.
  const auto once = [](const auto& field) {
    return *static_cast<const volatile std::remove_cvref_t<decltype(field)>*>(&field);
  };
  if (once(header.version) != kLayoutVersion) return bad("another layout version");
  const std::uint32_t slots = once(header.slots);
  const std::uint32_t message_max = once(header.message_max);
  if (!Geometry::valid(slots, message_max)) return bad("impossible size");
  const Geometry geometry = Geometry::of(slots, message_max, once(header.long_places));
  if (mapping.size() - offset < geometry.bytes)
    return bad("the mailbox is larger than its segment");
  MailboxView view(mapping.data() + offset, geometry);
  view.wake_ = once(header.wake);
  if (view.wake_ > WakeKind::kDoorbell) return bad("unknown kind of waking");
  view.address_ = Address(once(header.address));
  return view;
}

MailboxView MailboxView::create(std::span<std::byte> mapping, std::uint64_t offset,
                                const Options& options) {
  MailboxView view(mapping.data() + offset,
                   Geometry::of(options.slots, options.message_max, options.long_places));
  view.wake_ = options.wake;
  view.address_ = options.address;
  MailboxHeader& header = *view.header_;
  header.version = kLayoutVersion;
  header.address = options.address.raw();
  header.slots = options.slots;
  header.message_max = options.message_max;
  header.wake = options.wake;
  header.owner_pid = options.owner_pid;
  header.long_places = view.geometry_.long_places;
  for (std::uint32_t i = 0; i < options.slots; ++i) {
    const Hint hint{.lap = view.geometry_.lap_of(i), .index = static_cast<std::uint16_t>(i)};
    view.free(i).store(hint.pack(), std::memory_order_relaxed);
  }
  header.ready.store(kReady, std::memory_order_release);
  return view;
}

}  // namespace tims::shm
