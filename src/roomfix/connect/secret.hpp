// Passwords and tokens from where the site file says they are.
#pragma once

#include "roomfix/base/result.hpp"
#include "roomfix/site/site.hpp"

namespace roomfix {

/// `what` it is, for the error: "the password of outputs.mqtt". An error names the file or the variable, never its content.
Result<std::string> secret_text(const Secret& secret, const Site& site, const std::string& what);

}  // namespace roomfix
