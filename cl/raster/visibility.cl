// The program of the bins' way to camera visibility, stage by stage. One program is quicker to build than three.

#include "raster/chunks_seen.cl"
#include "raster/triangle_pack.cl"
#include "raster/visibility_bins.cl"
#include "raster/visibility_setup.cl"
