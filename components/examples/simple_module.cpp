// A minimal component: SimpleModule of the paper on RACK.
#include "rack/module.h"

namespace {

constexpr rack::ModuleInfo kInfo{.program = "SimpleModule",
                                 .purpose = "A minimal component that does nothing.",
                                 .class_id = tims::class_id::kTest};

class SimpleModule : public rack::Module {
 public:
  SimpleModule() : Module(kInfo) {}

 private:
  rack::Result<void> module_init() override {
    log().print("allocate resources");
    return Module::module_init();
  }
  void module_cleanup() override {
    log().print("free resources");
    Module::module_cleanup();
  }
  rack::Result<void> module_on() override {
    log().print("init something");
    return Module::module_on();
  }
  rack::Result<void> module_loop() override {
    sleep_until_next(std::chrono::milliseconds(100));
    return {};
  }
};

}  // namespace

int main(int argc, char** argv) {
  SimpleModule simple;
  return simple.run(argc, argv);
}
