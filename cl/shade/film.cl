// The program of what makes a picture of radiance. One program is quicker to build than two.

#include "shade/accumulate.cl"
#include "shade/resolve.cl"
