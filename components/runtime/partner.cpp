#include "rack/partner.h"

namespace rack {

PartnerBase::PartnerBase(Module& module, std::uint32_t class_id, std::string_view name,
                         const OwnMailbox& work)
    : module_(&module),
      work_(&work),
      class_id_(class_id),
      system_(partner_parameter(name, "Sys")),
      instance_(partner_parameter(name, "Inst")) {
  module.partners_.push_back({class_id, system_, instance_});
}

std::optional<tims::Address> PartnerBase::address() const {
  const std::int32_t instance = module_->integer(instance_);
  if (instance < 0) return {};
  return module_->address_of(class_id_, module_->integer(system_), instance);
}

}  // namespace rack
