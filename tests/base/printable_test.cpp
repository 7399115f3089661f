#include "roomfix/base/printable.hpp"

#include <gtest/gtest.h>

namespace roomfix {
namespace {

TEST(Printable, TextStaysAsItIs) {
    EXPECT_EQ(printable(""), "");
    EXPECT_EQ(printable("hall 1, 'north'"), "hall 1, 'north'");
    EXPECT_EQ(printable("Gr\u00f6\u00dfe \u20ac \U0001F916"), "Gr\u00f6\u00dfe \u20ac \U0001F916");
}

TEST(Printable, WhatCannotBeShownIsAQuestionMark) {
    EXPECT_EQ(printable("a\nb\x1b[31m\x7f"), "a?b?[31m?");
    EXPECT_EQ(printable("\xff\xfe"), "??");
    EXPECT_EQ(printable("\xc3"), "?") << "cut off";
    EXPECT_EQ(printable("\xe2\x82"), "??") << "cut off";
    EXPECT_EQ(printable("\xc0\xaf"), "??") << "longer than it need be";
    EXPECT_EQ(printable("\xe0\x80\xaf"), "???") << "longer than it need be";
    EXPECT_EQ(printable("\xed\xa0\x80"), "???") << "half of a pair";
    EXPECT_EQ(printable("\xf4\x90\x80\x80"), "????") << "beyond the last character";
    EXPECT_EQ(printable("\xc2\x9b"), "??") << "a control character";
    EXPECT_EQ(printable("\xc3\x41"), "?A");
}

TEST(Utf8, TheFirstByteThatIsNoneIsFound) {
    EXPECT_EQ(first_that_is_not_utf8(""), std::nullopt);
    EXPECT_EQ(first_that_is_not_utf8("a\tb\r\n\xc2\x9b Gr\u00f6\u00dfe \U0001F916"), std::nullopt) << "control characters are UTF-8, too";
    EXPECT_EQ(first_that_is_not_utf8("a\u00f6\xff"), 3);
    EXPECT_EQ(first_that_is_not_utf8("a\xe2\x82"), 1);
}

}  // namespace
}  // namespace roomfix
