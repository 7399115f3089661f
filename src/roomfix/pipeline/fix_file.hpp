// Fixes as JSON lines, in a file or on stdout.
#pragma once

#include <fstream>
#include <memory>
#include <ostream>
#include <string>

#include "roomfix/pipeline/fix_sink.hpp"

namespace roomfix {

class FixFile final : public FixSink {
public:
    /// "-" is stdout. `append`: what is in the file stays. An error if it cannot be written.
    static Result<std::unique_ptr<FixFile>> open(const std::string& file, bool append = false);
    std::string name() const override { return name_ == "-" ? "stdout" : name_; }
    /// Writes them out at once.
    Result<void> give(const FixBatch& batch) override;

private:
    explicit FixFile(const std::string& file) : name_(file) {}
    std::ostream& stream();

    std::string name_;
    std::ofstream file_;
};

}  // namespace roomfix
