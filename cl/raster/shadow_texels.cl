// The program of the conservative raster of a light's maps, stage by stage.

#include "raster/shadow_bins.cl"
#include "raster/shadow_setup.cl"
