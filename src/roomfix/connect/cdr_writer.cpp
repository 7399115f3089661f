#include "roomfix/connect/cdr_writer.hpp"

namespace roomfix {

void CdrWriter::put(std::string_view text) {
    put_count(text.size() + 1);
    append_text(bytes_, text);
    put(std::uint8_t{0});
}

void CdrWriter::put_array(std::span<const double> values) {
    for (const double value : values) put(value);
}

void CdrWriter::put_bytes(std::span<const std::uint8_t> values) {
    put_count(values.size());
    bytes_.insert(bytes_.end(), values.begin(), values.end());
}

}  // namespace roomfix
