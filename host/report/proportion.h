// A share of a whole that was estimated from a part of it, and how far it may be off.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// The 95 % confidence interval [low, high] of a share.
typedef struct Proportion {
  double share, low, high;
} Proportion;

// Of `count` clusters: in cluster i a share shares[i * stride] of its pixels counts, and it stands for weights[i *
// stride] of the whole; `pixels` in all of them. With `all` the clusters are the whole and the interval is the share.
//
// Clopper and Pearson's interval for as many independent pixels as would vary as much as the clusters do: n p (1 - p)
// over their variance, never more than there are pixels, for the number of clusters corrected by the quotient of
// normal's and Student's quantiles. The variance takes the strata for one (which is no less on average). Where no pixel
// counts, or all do, nothing varies: then each cluster is one pixel, as if its pixels were all alike; one cluster says
// nothing.
//
// From: Clopper, Pearson, "The Use of Confidence or Fiducial Limits Illustrated in the Case of the Binomial", 1934;
// Korn, Graubard, "Confidence Intervals for Proportions with Small Expected Number of Positive Counts Estimated from
// Survey Data", Survey Methodology 24, 1998.
Proportion proportion_of_clusters(const double *shares, const double *weights, uint32_t stride, uint32_t count,
                                  double pixels, bool all);

// Clopper and Pearson's interval of `hits` of `trials`, both of which need not be whole.
Proportion proportion_of_trials(double hits, double trials);
