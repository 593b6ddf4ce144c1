// Where the demo components are when nobody says otherwise.
#pragma once

#include "tims/address.h"

namespace tims::demo {

inline constexpr Address kLadar = Address::of({.class_id = class_id::kLadar});
inline constexpr Address kServer = Address::of({.class_id = class_id::kTest});
inline constexpr Address kViewer =
    Address::of({.class_id = class_id::kTest, .instance = 1, .local = 1});
inline constexpr Address kClient =
    Address::of({.class_id = class_id::kTest, .instance = 2, .local = 1});

}  // namespace tims::demo
