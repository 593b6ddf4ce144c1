#include "rack/partner.h"

namespace rack {

PartnerBase::PartnerBase(Module& module, std::uint32_t class_id, std::string_view name,
                         const OwnMailbox& work)
    : module_(&module),
      work_(&work),
      class_id_(class_id),
      system_(partner_parameter(name, "Sys")),
      instance_(partner_parameter(name, "Inst")) {}

bool PartnerBase::is_named() const { return module_->integer(instance_) >= 0; }

tims::Address PartnerBase::address() const {
  return module_->address_of(class_id_, module_->integer(system_), module_->integer(instance_));
}

}  // namespace rack
