// The program of the bins' way to depth maps, stage by stage.

#include "raster/chunks_seen.cl"
#include "raster/depth_bins.cl"
#include "raster/depth_planes.cl"
#include "raster/depth_setup.cl"
