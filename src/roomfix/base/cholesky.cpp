#include "roomfix/base/decompositions.hpp"

ROOMFIX_CHOLESKYS(template)
