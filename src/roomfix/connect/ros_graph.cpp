#include "roomfix/connect/ros_graph.hpp"

#include "roomfix/connect/cdr_reader.hpp"
#include "roomfix/connect/cdr_writer.hpp"

namespace roomfix::ros {
namespace {

std::size_t bytes_of_number(GraphLayout layout) { return layout == GraphLayout::numbers_of_16_bytes ? 16 : 24; }

/// A name as ROS allows it, within its limit.
bool is_name(const std::string& text) {
    const auto allowed = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '/'; };
    return text.size() <= 256 && std::all_of(text.begin(), text.end(), allowed);
}

bool is_whole(std::span<const std::uint8_t> message, GraphLayout layout) {
    constexpr std::uint32_t most = 10000;  // of anything
    const std::size_t number = bytes_of_number(layout);
    CdrReader cdr(message);
    cdr.take(number);
    const auto nodes = cdr.get<std::uint32_t>();
    if (nodes > most) return false;
    for (std::uint32_t i = 0; i < nodes && cdr.good(); ++i) {
        const std::string space = cdr.text(), name = cdr.text();
        if (!space.starts_with('/') || name.empty() || !is_name(space) || !is_name(name)) return false;
        for (int of_readers_and_writers = 0; of_readers_and_writers < 2; ++of_readers_and_writers) {
            const auto count = cdr.get<std::uint32_t>();
            if (count > most) return false;
            cdr.take(count * number);
        }
    }
    return cdr.good() && cdr.left() < 4;  // the end may be filled up to a multiple of four
}

void put(CdrWriter& cdr, const Guid& guid, GraphLayout layout) {
    for (const std::uint8_t byte : guid) cdr.put(byte);
    for (std::size_t i = guid.size(); i < bytes_of_number(layout); ++i) cdr.put(std::uint8_t{0});
}

}  // namespace

std::optional<GraphLayout> layout_of_graph(std::span<const std::uint8_t> message) {
    const bool is_16 = is_whole(message, GraphLayout::numbers_of_16_bytes), is_24 = is_whole(message, GraphLayout::numbers_of_24_bytes);
    if (is_16 == is_24) return std::nullopt;
    return is_16 ? GraphLayout::numbers_of_16_bytes : GraphLayout::numbers_of_24_bytes;
}

Bytes encode(const ParticipantEntitiesInfo& message, GraphLayout layout) {
    CdrWriter cdr;
    put(cdr, message.participant, layout);
    cdr.put_count(1);
    cdr.put(message.node_namespace);
    cdr.put(message.node_name);
    for (const std::vector<Guid>* entities : {&message.readers, &message.writers}) {
        cdr.put_count(entities->size());
        for (const Guid& entity : *entities) put(cdr, entity, layout);
    }
    return cdr.take();
}

}  // namespace roomfix::ros
