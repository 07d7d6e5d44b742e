#include "stability/stability.h"
static const StabilityRow rows[1];
const StabilityTable geometry_table = {"geometry", rows, 0};
