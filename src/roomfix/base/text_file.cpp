#include "roomfix/base/text_file.hpp"

#include <fstream>
#include <sstream>

namespace roomfix {

Result<std::string> read_text(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    if (stream && stream.peek() == std::ifstream::traits_type::eof() && stream.eof()) return std::string();
    std::ostringstream text;
    if (!stream || !(text << stream.rdbuf())) return Error{file.string() + ": cannot be read"};
    return text.str();
}

}  // namespace roomfix
