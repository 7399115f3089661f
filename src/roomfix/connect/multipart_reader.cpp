#include "roomfix/connect/multipart_reader.hpp"

#include <algorithm>
#include <cctype>
#include <utility>

#include "roomfix/base/number.hpp"

namespace roomfix {
namespace {

constexpr std::size_t longest_header = 16 << 10;  // bytes
constexpr std::size_t largest_body = 64 << 20;
constexpr std::size_t longest_boundary = 200;

bool same_word(std::string_view a, std::string_view b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](char x, char y) { return std::tolower(static_cast<unsigned char>(x)) == std::tolower(static_cast<unsigned char>(y)); });
}

std::string_view trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(" \t\r");
    if (first == text.npos) return {};
    return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

}  // namespace

std::string_view MultipartReader::rest() const { return {reinterpret_cast<const char*>(buffer_.data()) + from_, buffer_.size() - from_}; }

Result<void> MultipartReader::feed(std::span<const std::uint8_t> bytes, double time) {
    if (!problem_.empty()) return Error{problem_};
    time_ = time;
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
    while (problem_.empty() && step()) {
    }
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(from_));
    from_ = 0;
    if (!problem_.empty()) return Error{problem_};
    return {};
}

std::optional<MultipartPart> MultipartReader::take() {
    if (whole_.empty()) return std::nullopt;
    MultipartPart part = std::move(whole_.front());
    whole_.erase(whole_.begin());
    return part;
}

/// False where more bytes are needed.
bool MultipartReader::step() {
    switch (state_) {
        case State::boundary:
            return read_boundary();
        case State::headers:
            return read_headers();
        case State::sized_body:
            return read_sized_body();
        case State::open_body:
            return read_open_body();
    }
    return false;
}

/// Skips lines until one is the boundary.
bool MultipartReader::read_boundary() {
    const std::string_view text = rest();
    const std::size_t end = text.find('\n');
    if (end == text.npos) {
        if (text.size() > longest_header) problem_ = "what comes is no stream of pictures: no boundary between them";
        return false;
    }
    const std::string_view line = trimmed(text.substr(0, end));
    from_ += end + 1;
    if (boundary_.empty() && line.size() > 2 && line.size() <= longest_boundary && line.starts_with("--")) boundary_ = line;
    if (boundary_.empty() || line != boundary_) return true;
    part_ = {};
    began_ = false;
    size_ = 0;
    state_ = State::headers;
    return true;
}

bool MultipartReader::read_headers() {
    const std::string_view text = rest();
    const std::size_t end = text.find('\n');
    if (end == text.npos) {
        if (text.size() > longest_header) problem_ = "what comes is no stream of pictures: a header without an end";
        return false;
    }
    const std::string_view line = trimmed(text.substr(0, end));
    from_ += end + 1;
    if (!line.empty()) {
        read_header(line);
    } else {
        searched_ = 0;
        state_ = size_ > 0 ? State::sized_body : State::open_body;
    }
    return true;
}

void MultipartReader::read_header(std::string_view line) {
    const std::size_t colon = line.find(':');
    if (colon == line.npos) return;
    const std::string_view name = trimmed(line.substr(0, colon));
    const std::string value(trimmed(line.substr(colon + 1)));
    if (same_word(name, "Content-Length")) {
        const auto size = parse_integer(value);
        if (!size || *size < 0 || static_cast<std::size_t>(*size) > largest_body) {
            problem_ = "what comes is no stream of pictures: one of them would have " + value.substr(0, 40) + " bytes";
        } else {
            size_ = static_cast<std::size_t>(*size);
        }
    } else if (same_word(name, "X-Timestamp")) {
        part_.timestamp = parse_number(value);
    }
}

/// The boundary and even the headers may have come with the picture before: a picture begins with its own first byte.
void MultipartReader::note_begin() {
    if (began_ || rest().empty()) return;
    began_ = true;
    part_.began = time_;
}

bool MultipartReader::read_sized_body() {
    note_begin();
    if (rest().size() < size_) return false;
    finish_body(size_);
    return true;
}

/// Without a stated size a body ends where a line is the boundary.
bool MultipartReader::read_open_body() {
    note_begin();
    const std::string_view text = rest();
    const std::string mark = "\n" + boundary_;
    const std::size_t end = text.find(mark, searched_);
    if (end == text.npos) {
        searched_ = text.size() < mark.size() ? 0 : text.size() - mark.size();
        if (text.size() > largest_body) problem_ = "what comes is no stream of pictures: one of them does not end";
        return false;
    }
    finish_body(end > 0 && text[end - 1] == '\r' ? end - 1 : end);
    return true;
}

void MultipartReader::finish_body(std::size_t size) {
    const std::string_view text = rest();
    part_.body.assign(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(size));
    from_ += size;
    if (!part_.body.empty()) whole_.push_back(std::move(part_));
    part_ = {};
    state_ = State::boundary;
}

}  // namespace roomfix
