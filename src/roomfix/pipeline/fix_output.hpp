// Where fixes go: one JSON line each, to a file or to stdout.
#pragma once

#include <fstream>
#include <string>
#include <vector>

#include "roomfix/base/result.hpp"
#include "roomfix/observation/fix.hpp"

namespace roomfix {

class FixOutput {
public:
    /// "-" is stdout. An error if the file cannot be written.
    Result<void> open(const std::string& file);
    /// Writes them out at once.
    void give(const std::vector<Fix>& fixes);
    long given() const { return given_; }

private:
    std::ofstream file_;
    bool to_stdout_ = false;
    long given_ = 0;
};

}  // namespace roomfix
