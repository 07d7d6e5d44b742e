#include "device_scene/environment_table.h"

#include <math.h>
#include <stdlib.h>

#include "base/parallel.h"
#include "shared/scene.h"

typedef struct TableWork {
  const Image *image;
  float *values;
  double *row_weights;  // luminance x solid angle, by row of cells
} TableWork;

static double texel_luminance(const Image *image, uint32_t column, uint32_t row)
{
  const float *pixel = image->pixels + 4 * ((size_t)row * image->width + column);
  double luminance = (double)LUMINANCE_R * pixel[0] + (double)LUMINANCE_G * pixel[1] + (double)LUMINANCE_B * pixel[2];
  return luminance > 0 && isfinite(luminance) ? luminance : 0;
}

// Polar angles of the upper and lower border of a row of cells.
static void row_borders(double borders_rad[2], const Image *image, size_t row)
{
  borders_rad[0] = row == 0 ? 0 : M_PI * ((double)row - 0.5) / image->height;
  borders_rad[1] = row == image->height ? M_PI : M_PI * ((double)row + 0.5) / image->height;
}

// Where the numbers of a tree lie.
static float *search_tree_leaves(float *tree, uint32_t count)
{
  return tree + search_tree_size(count) - TABLE_BLOCKS(count) * TABLE_BLOCK;
}

// Pads the numbers and makes the levels before them.
static void search_tree_finish(float *tree, uint32_t count)
{
  float *level = search_tree_leaves(tree, count);
  for (;;) {
    uint32_t blocks = TABLE_BLOCKS(count);
    for (uint32_t i = count; i < blocks * TABLE_BLOCK; i++) level[i] = TABLE_END;
    if (blocks == 1) return;
    float *above = search_tree_leaves(tree, blocks);
    for (uint32_t i = 0; i < blocks; i++) above[i] = level[i * TABLE_BLOCK];
    level = above;
    count = blocks;
  }
}

// Where the bilinear interpolation is integrated over a cell, the mean of the four corners is left.
static void row_make(void *context, size_t row)
{
  TableWork *work = context;
  const Image *image = work->image;
  uint32_t rows = ENVIRONMENT_TABLE_ROWS(image->height), width = image->width;
  uint32_t above = row == 0 ? 0 : (uint32_t)row - 1, below = row == image->height ? image->height - 1 : (uint32_t)row;
  size_t tree = search_tree_size(width);
  float *values = work->values + search_tree_size(rows) + rows + row * tree;
  float *columns = search_tree_leaves(values, width);
  double sum = 0, borders_rad[2];
  for (int pass = 0; pass < 2; pass++) {
    double whole = sum;
    sum = 0;
    double left = texel_luminance(image, 0, above) + texel_luminance(image, 0, below);
    for (uint32_t column = 0; column < width; column++) {
      uint32_t next = column + 1 < width ? column + 1 : 0;
      double right = texel_luminance(image, next, above) + texel_luminance(image, next, below);
      if (pass == 1) columns[column] = (float)(whole > 0 ? sum / whole : (double)column / width);
      sum += 0.25 * (left + right);
      left = right;
    }
  }
  search_tree_finish(values, width);
  row_borders(borders_rad, image, row);
  work->row_weights[row] = sum * (2 * M_PI / width) * (cos(borders_rad[0]) - cos(borders_rad[1]));
}

// Shares of the rows, and what turns luminance into density: a cell's share is luminance x solid angle / total, spread
// in it as the interpolated luminance over (u, v), and d omega = 2 pi^2 sin(theta) du dv.
static void rows_finish(TableWork *work)
{
  const Image *image = work->image;
  uint32_t rows = ENVIRONMENT_TABLE_ROWS(image->height);
  float *shares = search_tree_leaves(work->values, rows), *scales = work->values + search_tree_size(rows);
  double total = 0, before = 0;
  for (uint32_t row = 0; row < rows; row++) total += work->row_weights[row];
  for (uint32_t row = 0; row < rows; row++) {
    double borders_rad[2];
    row_borders(borders_rad, image, row);
    double mean_sine = (cos(borders_rad[0]) - cos(borders_rad[1])) / (borders_rad[1] - borders_rad[0]);
    shares[row] = (float)(before / total);
    scales[row] = (float)(mean_sine / total);
    before += work->row_weights[row];
  }
  search_tree_finish(work->values, rows);
}

Status environment_table_make(EnvironmentTable *out, const Environment *environment, Log *log)
{
  Status status = STATUS_OK;
  TableWork work = {.image = &environment->image};
  *out = (EnvironmentTable){0};
  if (environment->kind != ENVIRONMENT_IMAGE) return STATUS_OK;
  uint32_t rows = ENVIRONMENT_TABLE_ROWS(work.image->height);
  size_t count = search_tree_size(rows) + rows * (1 + (size_t)search_tree_size(work.image->width));
  work.values = malloc(count * sizeof *work.values);
  work.row_weights = malloc(rows * sizeof *work.row_weights);
  if (!work.values || !work.row_weights) {
    status = log_no_memory(log, "environment");
    goto done;
  }
  parallel_for(rows, row_make, &work);
  double brightest = 0;
  for (uint32_t row = 0; row < rows; row++) brightest = fmax(brightest, work.row_weights[row]);
  if (brightest > 0) {
    rows_finish(&work);
    *out = (EnvironmentTable){work.values, count};
    work.values = NULL;
  }

done:
  free(work.values);
  free(work.row_weights);
  return status;
}

void environment_table_free(EnvironmentTable *table)
{
  free(table->values);
  *table = (EnvironmentTable){0};
}
