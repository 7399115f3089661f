#include "roomfix/connect/multipart_reader.hpp"

#include <gtest/gtest.h>

namespace roomfix {
namespace {

std::span<const std::uint8_t> bytes_of(std::string_view text) { return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}; }

/// The bodies of all parts, where the stream comes in pieces of some size, each at a time that is its number.
std::vector<MultipartPart> parts_of(const std::string& stream, std::size_t piece) {
    MultipartReader reader;
    std::vector<MultipartPart> parts;
    for (std::size_t i = 0; i < stream.size(); i += piece) {
        EXPECT_TRUE(reader.feed(bytes_of(std::string_view(stream).substr(i, piece)), static_cast<double>(i / piece)));
        while (auto part = reader.take()) parts.push_back(std::move(*part));
    }
    return parts;
}

std::string text_of(const MultipartPart& part) { return {part.body.begin(), part.body.end()}; }

TEST(MultipartReader, PicturesComeWholeHoweverTheStreamIsCutUp) {
    const std::string sized =
        "--frame\r\nContent-Type: image/jpeg\r\nContent-Length: 9\r\nX-Timestamp: 1800000000.25\r\n\r\n\xff\xd8\n--frame\r\n--frame\r\n"
        "content-length:3\r\n\r\nabc\r\n--frame\r\n";
    const std::string open = "\n--a b\nContent-Type: image/jpeg\n\n\xff\xd8-\n-\n--a b\n\nabc\r\n--a b\n\n";
    for (std::size_t piece = 1; piece < 100; ++piece) {
        const auto first = parts_of(sized, piece);
        ASSERT_EQ(first.size(), 2U) << piece;
        EXPECT_EQ(text_of(first[0]), "\xff\xd8\n--fram");
        EXPECT_EQ(first[0].timestamp, 1800000000.25);
        EXPECT_FALSE(first[1].timestamp);
        const auto second = parts_of(open, piece);
        ASSERT_EQ(second.size(), 2U) << piece;
        EXPECT_EQ(text_of(second[0]), "\xff\xd8-\n-");
        EXPECT_EQ(text_of(second[1]), "abc");
    }
}

TEST(MultipartReader, APictureBeginsWithItsOwnBytesAndNotWithTheBoundaryBeforeIt) {
    MultipartReader reader;
    ASSERT_TRUE(reader.feed(bytes_of("--x\r\nContent-Length: 4\r\n\r\n"), 1));
    ASSERT_TRUE(reader.feed(bytes_of("ab"), 2));
    ASSERT_TRUE(reader.feed(bytes_of("cd\r\n--x\r\n"), 3));
    const auto part = reader.take();
    ASSERT_TRUE(part);
    EXPECT_EQ(part->began, 2);
}

TEST(MultipartReader, WhatIsNoSuchStreamIsAnErrorAndStaysOne) {
    for (const std::string& stream :
         {std::string(20000, 'x'), std::string("--x\r\nContent-Length: 99999999999\r\n\r\n"), "--x\r\n" + std::string(20000, 'y')}) {
        MultipartReader reader;
        const auto fed = reader.feed(bytes_of(stream), 0);
        ASSERT_FALSE(fed);
        EXPECT_NE(fed.error().message.find("no stream of pictures"), std::string::npos);
        EXPECT_FALSE(reader.feed(bytes_of("--x\r\n\r\nabc\r\n--x\r\n"), 1));
    }
}

}  // namespace
}  // namespace roomfix
