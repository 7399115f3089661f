#include "roomfix/base/number.hpp"

#include <gtest/gtest.h>

#include <clocale>

namespace roomfix {
namespace {

TEST(Number, IsReadWholeOrNotAtAll) {
    EXPECT_EQ(parse_number("1.5e-3"), 0.0015);
    EXPECT_EQ(parse_number("+2"), 2);
    for (const char* text : {"", " 1", "1 ", "1,5", "nan", "inf", "1e999", "0x10", "+-1", "1.2.3"}) EXPECT_FALSE(parse_number(text)) << text;
    EXPECT_EQ(parse_integer("-12"), -12);
    EXPECT_FALSE(parse_integer("99999999999999999999"));
    EXPECT_FALSE(parse_integer("1.0"));
}

TEST(Number, PrintsTheSameInEveryLocale) {
    std::setlocale(LC_ALL, "de_DE.UTF-8");
    EXPECT_EQ(number_text(1.5), "1.5");
    EXPECT_EQ(number_text(0.0008), "0.0008");
    EXPECT_EQ(parse_number(number_text(0.1)), 0.1);
    std::setlocale(LC_ALL, "C");
}

TEST(Number, SecondsKeepEveryNanosecond) {
    EXPECT_EQ(seconds_text(12345678901), "12.345678901");
    EXPECT_EQ(seconds_text(-1), "-0.000000001");
    EXPECT_EQ(seconds_text(3000000000), "3.0");
    EXPECT_EQ(parse_seconds("1763743556.123456789"), 1763743556123456789);
    EXPECT_EQ(parse_seconds("-0.5"), -500000000);
    EXPECT_EQ(parse_seconds(".25"), 250000000);
    for (const char* text : {"", ".", "-", "1e3", "1.2.3", "99999999999", " 1", "nan"}) EXPECT_FALSE(parse_seconds(text)) << text;
}

}  // namespace
}  // namespace roomfix
