#include "report/proportion.h"

#include <math.h>

static const double confidence = 0.95, normal_quantile = 1.959963985;

static double away_from_zero(double x) { return fabs(x) < 1e-300 ? 1e-300 : x; }

// Continued fraction of the incomplete beta function, by Lentz's method. From Press et al., "Numerical Recipes", 2nd
// edition, 1992, section 6.4.
static double beta_fraction(double x, double a, double b)
{
  double c = 1, d = 1 / away_from_zero(1 - (a + b) * x / (a + 1)), product = d;
  for (int i = 1; i <= 10000; i++) {
    double even = i * (b - i) * x / ((a + 2 * i - 1) * (a + 2 * i));
    double odd = -(a + i) * (a + b + i) * x / ((a + 2 * i) * (a + 2 * i + 1)), step = 1;
    for (int half = 0; half < 2; half++) {
      double term = half ? odd : even;
      d = 1 / away_from_zero(1 + term * d);
      c = away_from_zero(1 + term / c);
      step = c * d;
      product *= step;
    }
    if (fabs(step - 1) < 1e-14) break;
  }
  return product;
}

// Regularised incomplete beta function I_x(a, b).
static double beta_share(double x, double a, double b)
{
  if (x <= 0 || x >= 1) return x > 0;
  int sign = 0;
  double scale = exp(lgamma_r(a + b, &sign) - lgamma_r(a, &sign) - lgamma_r(b, &sign) + a * log(x) + b * log1p(-x));
  return x < (a + 1) / (a + b + 2) ? scale * beta_fraction(x, a, b) / a : 1 - scale * beta_fraction(1 - x, b, a) / b;
}

// x with I_x(a, b) = share.
static double beta_quantile(double share, double a, double b)
{
  double low = 0, high = 1;
  for (int i = 0; i < 60; i++) {
    double middle = (low + high) / 2;
    if (beta_share(middle, a, b) < share)
      low = middle;
    else
      high = middle;
  }
  return (low + high) / 2;
}

// Student's two-sided quantile: P(|t| > T) = I_(f / (f + T^2))(f / 2, 1 / 2) for f degrees of freedom.
static double student_quantile(double freedom)
{
  double x = beta_quantile(1 - confidence, freedom / 2, 0.5);
  return sqrt(freedom * (1 - x) / x);
}

Proportion proportion_of_trials(double hits, double trials)
{
  const double tail = (1 - confidence) / 2;
  if (!(trials > 0)) return (Proportion){0, 0, 1};
  return (Proportion){.share = hits / trials,
                      .low = hits > 0 ? beta_quantile(tail, hits, trials - hits + 1) : 0,
                      .high = hits < trials ? beta_quantile(1 - tail, hits + 1, trials - hits) : 1};
}

Proportion proportion_of_clusters(const double *shares, const double *weights, uint32_t stride, uint32_t count,
                                  double pixels, bool all)
{
  double sum = 0, weight = 0, variance = 0;
  for (uint32_t i = 0; i < count; i++) {
    sum += weights[i * stride] * shares[i * stride];
    weight += weights[i * stride];
  }
  double share = weight > 0 ? fmin(sum / weight, 1) : 0;
  if (all) return (Proportion){share, share, share};
  if (count < 2) return (Proportion){share, 0, 1};
  for (uint32_t i = 0; i < count; i++) {
    double off = weights[i * stride] / weight * (shares[i * stride] - share);
    variance += off * off * count / (count - 1);
  }
  double trials = count;
  if (variance > 0) trials = share * (1 - share) / variance;
  double student = normal_quantile / student_quantile(count - 1);
  Proportion out =
      proportion_of_trials(share * fmin(trials * student * student, pixels), fmin(trials * student * student, pixels));
  out.share = share;
  return out;
}
