#include "algebra/decompositions.hpp"

LAMPREY_DECOMPOSITIONS(template)
