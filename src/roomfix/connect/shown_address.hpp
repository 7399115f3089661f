// Addresses in messages.
#pragma once

#include <string>

namespace roomfix {

/// An address without user and password; everything else as it is.
std::string shown_address(const std::string& address);

}  // namespace roomfix
