// HOTA: detection and association in one figure, over all demands on the place from lax to strict.
// Luiten, Osep, Dendorfer, Torr, Geiger, Leal-Taixe and Leibe, HOTA: a higher order metric for evaluating multi-object tracking (IJCV 129, 2021).
#pragma once

#include "roomfix/evaluate/moments.hpp"

namespace roomfix {

/// Averages over the thresholds alpha = 0.05, 0.10, ... 0.95 of the similarity 1 - distance / cut-off: a pair may be 0.95, 0.90, ... 0.05 of the
/// cut-off apart. At each, HOTA is the root of DetA times AssA. Of the matchings that the paper leaves open it is that of the authors' own program
/// (TrackEval): at each moment the greatest sum of similarity times how well the two agree over all moments.
struct Hota {
    double hota = 0;
    double detection = 0;    // DetA: pairs, as a part of pairs, missed and false ones
    double association = 0;  // AssA: of the pairs, how much of the target's and the track's time they are together
};

Hota hota_of(const Moments& moments);

}  // namespace roomfix
