#include "roomfix/imaging/tag_codes.hpp"

#include <cstdint>
#include <vector>

extern "C" {
#include <apriltag/tag16h5.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h10.h>
#include <apriltag/tag36h11.h>
#include <apriltag/tagCircle21h7.h>
#include <apriltag/tagCircle49h12.h>
#include <apriltag/tagCustom48h12.h>
#include <apriltag/tagStandard41h12.h>
#include <apriltag/tagStandard52h13.h>
}

#ifdef ROOMFIX_CHARUCO
#include <opencv2/aruco.hpp>
#endif

namespace roomfix {
namespace {

#ifdef ROOMFIX_CHARUCO

/// One of OpenCV's dictionaries as a family of libapriltag.
struct ArucoFamily : apriltag_family_t {
    std::vector<std::uint64_t> code_list;
    std::vector<std::uint32_t> columns, rows;  // of the bits

    explicit ArucoFamily(const cv::aruco::Dictionary& dictionary, int count) : apriltag_family_t{} {
        order_bits(dictionary.markerSize);
        for (int number = 0; number < count; ++number) code_list.push_back(code_of(dictionary, number));
        ncodes = static_cast<std::uint32_t>(count);
        codes = code_list.data();
        width_at_border = dictionary.markerSize + 2;
        total_width = dictionary.markerSize + 4;
        nbits = static_cast<std::uint32_t>(columns.size());
        bit_x = columns.data();
        bit_y = rows.data();
        h = static_cast<std::uint32_t>(2 * dictionary.maxCorrectionBits + 1);
    }

private:
    /// A quarter turn of the tag moves its code on by a quarter: one quarter of the bits after the other, clockwise, the middle one last.
    void order_bits(int size) {
        const auto add = [&](int column, int row) {
            columns.push_back(static_cast<std::uint32_t>(column + 1));
            rows.push_back(static_cast<std::uint32_t>(row + 1));
        };
        for (int turn = 0; turn < 4; ++turn) {
            for (int row = 0; row < size / 2; ++row) {
                for (int column = 0; column < (size + 1) / 2; ++column) {
                    int x = column, y = row;
                    for (int t = 0; t < turn; ++t) {
                        const int before = x;
                        x = size - 1 - y;
                        y = before;
                    }
                    add(x, y);
                }
            }
        }
        if (size % 2 == 1) add(size / 2, size / 2);
    }
    std::uint64_t code_of(const cv::aruco::Dictionary& dictionary, int number) const {
        const cv::Mat bits = cv::aruco::Dictionary::getBitsFromByteList(dictionary.bytesList.rowRange(number, number + 1), dictionary.markerSize);
        std::uint64_t code = 0;
        for (std::size_t i = 0; i < columns.size(); ++i) {
            code = code << 1 | bits.at<std::uint8_t>(static_cast<int>(rows[i]) - 1, static_cast<int>(columns[i]) - 1);
        }
        return code;
    }
};

TagCodes aruco_codes(TagFamily family) {
    // OpenCV counts its dictionaries in the same order.
    const int index = static_cast<int>(family) - static_cast<int>(TagFamily::aruco_4x4_50);
    const auto dictionary = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_50 + index);
    return {new ArucoFamily(*dictionary, tag_count(family)), [](apriltag_family_t* f) { delete static_cast<ArucoFamily*>(f); }};
}

#else

TagCodes aruco_codes(TagFamily) {
    return {nullptr, [](apriltag_family_t*) {}};
}

#endif

}  // namespace

TagCodes tag_codes(TagFamily family) {
    switch (family) {
        case TagFamily::tag36h11:
            return {tag36h11_create(), tag36h11_destroy};
        case TagFamily::tag36h10:
            return {tag36h10_create(), tag36h10_destroy};
        case TagFamily::tag25h9:
            return {tag25h9_create(), tag25h9_destroy};
        case TagFamily::tag16h5:
            return {tag16h5_create(), tag16h5_destroy};
        case TagFamily::tag_circle21h7:
            return {tagCircle21h7_create(), tagCircle21h7_destroy};
        case TagFamily::tag_circle49h12:
            return {tagCircle49h12_create(), tagCircle49h12_destroy};
        case TagFamily::tag_custom48h12:
            return {tagCustom48h12_create(), tagCustom48h12_destroy};
        case TagFamily::tag_standard41h12:
            return {tagStandard41h12_create(), tagStandard41h12_destroy};
        case TagFamily::tag_standard52h13:
            return {tagStandard52h13_create(), tagStandard52h13_destroy};
        default:
            return aruco_codes(family);
    }
}

}  // namespace roomfix
