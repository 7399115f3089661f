#include "roomfix/connect/ros_names.hpp"

#include <algorithm>

namespace roomfix {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

std::string word_of(const std::string& id) {
    std::string word;
    for (const char c : id) {
        const char kept = is_digit(c) || is_letter(c) ? c : '_';
        if (kept != '_' || word.empty() || word.back() != '_') word += kept;
    }
    while (!word.empty() && word.back() == '_') word.pop_back();
    if (word.empty()) return "id";
    if (is_digit(word.front())) word.insert(0, "id_");
    return word;
}

}  // namespace

const std::string& RosNames::of(const std::string& id) {
    const auto known = words_.find(id);
    if (known != words_.end()) return known->second;
    const std::string word = word_of(id);
    std::string free = word;
    for (int number = 2; !taken_.insert(free).second; ++number) free = word + "_" + std::to_string(number);
    return words_.emplace(id, free).first->second;
}

void RosNames::forget(const std::string& id) {
    const auto known = words_.find(id);
    if (known == words_.end()) return;
    taken_.erase(known->second);
    words_.erase(known);
}

RobotFrames robot_frames(const std::string& robot_word, bool only_one) {
    if (only_one) return {"odom", "base_link"};
    return {robot_word + "/odom", robot_word + "/base_link"};
}

}  // namespace roomfix
