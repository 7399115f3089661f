#include "roomfix/base/decompositions.hpp"

ROOMFIX_LU_AND_SVD(template)
