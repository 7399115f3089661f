#include "roomfix/base/decompositions.hpp"

ROOMFIX_ALL_EIGENVALUES(template)
