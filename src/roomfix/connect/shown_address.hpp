// Addresses in messages.
#pragma once

#include <string>

namespace roomfix {

/// An address without what may be secret: user, password, and what stands behind a question mark.
std::string shown_address(const std::string& address);

}  // namespace roomfix
