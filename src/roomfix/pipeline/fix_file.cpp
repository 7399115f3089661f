#include "roomfix/pipeline/fix_file.hpp"

#include <fmt/format.h>

#include <iostream>

#include "roomfix/connect/fix_json.hpp"

namespace roomfix {

Result<std::unique_ptr<FixFile>> FixFile::open(const std::string& file, bool append) {
    std::unique_ptr<FixFile> opened(new FixFile(file));
    if (file == "-") return opened;
    opened->file_.open(file, append ? std::ios::binary | std::ios::app : std::ios::binary);
    if (!opened->file_) return Error{fmt::format("{}: cannot be written: check that the folder exists", file)};
    return opened;
}

std::ostream& FixFile::stream() { return file_.is_open() ? file_ : std::cout; }

Result<void> FixFile::give(const FixBatch& batch) {
    std::ostream& out = stream();
    for (const Fix& fix : batch.given) out << fix_line(fix) << '\n';
    out.flush();
    if (out) return {};
    out.clear();
    return Error{fmt::format("{}: fixes could not be written and are lost: is the disk full?", name())};
}

}  // namespace roomfix
