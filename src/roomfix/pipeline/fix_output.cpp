#include "roomfix/pipeline/fix_output.hpp"

#include <fmt/format.h>

#include <iostream>

#include "roomfix/connect/fix_json.hpp"

namespace roomfix {

Result<void> FixOutput::open(const std::string& file) {
    if (file == "-") {
        to_stdout_ = true;
        return {};
    }
    file_.open(file, std::ios::binary);
    if (!file_) return Error{fmt::format("{}: cannot be written: check that the folder exists", file)};
    return {};
}

void FixOutput::give(const std::vector<Fix>& fixes) {
    given_ += static_cast<long>(fixes.size());
    for (const Fix& fix : fixes) {
        if (to_stdout_) std::cout << fix_line(fix) << '\n';
        if (file_.is_open()) file_ << fix_line(fix) << '\n';
    }
    if (to_stdout_) std::cout.flush();
    if (file_.is_open()) file_.flush();
}

}  // namespace roomfix
